"""Read the files of a build, strictly: text, JSON and OBJ as docs/report.md has them, with the hash of each."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flatnet.verify.mesh import WrittenMesh

REPORT = "report.json"
REPORT_FORMAT = "flatnet-report/1"


class NotABuildError(Exception):
    """The folder holds no build, or can't be read or written."""


class DamagedError(Exception):
    """A file is missing, cut short or not what a build writes; the message says where."""

    def __init__(self, file: str, words: str) -> None:
        super().__init__(f"{file}: {words}")
        self.file, self.words = file, words


class WrittenFiles:
    """The files below a folder; `hashes` holds the SHA-256 of every one that was looked at."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.hashes: dict[str, str] = {}

    def content(self, name: str) -> bytes:
        """The bytes of a file.

        Raises
        ------
        DamagedError
            It is missing, can't be read, or lies outside the folder.
        """
        path = self.folder / name
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise DamagedError(name, "lies outside the folder of the build")
        try:
            content = path.read_bytes()
        except OSError as error:
            raise DamagedError(name, f"can't be read: {error.strerror}; build again") from None
        self.hashes[name] = hashlib.sha256(content).hexdigest()
        return content

    def text(self, name: str) -> str:
        try:
            return self.content(name).decode("utf-8")
        except UnicodeDecodeError as error:
            raise DamagedError(name, f"is no UTF-8 at byte {error.start}") from None

    def json(self, name: str) -> Any:
        try:
            return json.loads(self.text(name))
        except json.JSONDecodeError as error:
            raise DamagedError(name, f"is no JSON, or cut short: {error}") from None
        except RecursionError:
            raise DamagedError(name, "is no JSON of a build: it is nested too deeply") from None

    def mesh(self, name: str) -> WrittenMesh:
        """An OBJ with triangles `f v/vt`, v = vt."""
        text = self.text(name)
        if not text.endswith("\n"):
            raise DamagedError(name, "is cut short: its last line has no end")
        rows: dict[str, list[list[float]]] = {"v": [], "vt": [], "f": []}
        for number, line in enumerate(text.splitlines(), start=1):
            kind, *words = line.split() or ["#"]
            if kind.startswith("#") or kind == "o":
                continue
            try:
                rows[kind].append(_corners(words) if kind == "f" else _coordinates(words, 3 if kind == "v" else 2))
            except KeyError:
                raise DamagedError(name, f"line {number}: '{kind}' is in no OBJ of a build") from None
            except ValueError as error:
                raise DamagedError(name, f"line {number}: {error}") from None
        vertices, flat = np.array(rows["v"], float), np.array(rows["vt"], float)
        triangles = np.array(rows["f"], np.int64) - 1
        if not len(triangles) or len(vertices) != len(flat):
            counts = f"{len(vertices)} `v`, {len(flat)} `vt`, {len(triangles)} `f`"
            raise DamagedError(name, f"{counts}: there is to be one `vt` for each `v`, and a face")
        if triangles.min() < 0 or triangles.max() >= len(vertices):
            raise DamagedError(name, f"a face names vertex {triangles.max() + 1}, and there are {len(vertices)}")
        return WrittenMesh(vertices, flat, triangles)


def _coordinates(words: Sequence[str], count: int) -> list[float]:
    numbers = [float(word) for word in words]
    if len(numbers) != count:
        raise ValueError(f"{len(numbers)} coordinates instead of {count}")
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"'{' '.join(words)}' is not finite")
    return numbers


def _corners(words: Sequence[str]) -> list[float]:
    pairs = [word.split("/") for word in words]
    if len(pairs) != 3 or any(len(pair) != 2 or pair[0] != pair[1] for pair in pairs):
        raise ValueError(f"'{' '.join(words)}' is no triangle of corners v/vt with v = vt")
    if len({pair[0] for pair in pairs}) != 3:
        raise ValueError(f"the triangle '{' '.join(words)}' has a corner twice")
    return [int(pair[0]) for pair in pairs]


class Record:
    """A JSON object of a file, read key by key; what is missing or of another kind is `DamagedError`."""

    def __init__(self, file: str, content: object, where: str = "") -> None:
        if not isinstance(content, Mapping):
            raise DamagedError(file, f"{where or 'it'} is no object")
        self.file, self._content, self._where = file, content, where

    def _get(self, key: str) -> object:
        if key not in self._content:
            raise DamagedError(self.file, f"{self._place(key)} is missing")
        return self._content[key]

    def _place(self, key: str) -> str:
        return f"{self._where}.{key}" if self._where else key

    def _wrong(self, key: str, kind: str) -> DamagedError:
        return DamagedError(self.file, f"{self._place(key)} is no {kind}: {str(self._content[key])[:40]!r}")

    def has(self, key: str) -> bool:
        """Whether the key is there and not null."""
        return self._content.get(key) is not None

    def text(self, key: str) -> str:
        value = self._get(key)
        if not isinstance(value, str):
            raise self._wrong(key, "text")
        return value

    def flag(self, key: str) -> bool:
        value = self._get(key)
        if not isinstance(value, bool):
            raise self._wrong(key, "true or false")
        return value

    def number(self, key: str) -> float:
        """A number, which may be nan: then it agrees with nothing."""
        value = self._get(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._wrong(key, "number")
        return float(value)

    def count(self, key: str) -> int:
        value = self._get(key)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self._wrong(key, "whole number")
        return value

    def numbers(self, key: str, columns: int = 0) -> Any:
        """A list of finite numbers, (n,), or of rows of so many, (n, columns)."""
        try:
            array = np.array(self._get(key), dtype=float)
        except (TypeError, ValueError):
            raise self._wrong(key, "list of numbers") from None
        array = array.reshape(0, columns) if columns and not array.size else array
        if array.ndim != (2 if columns else 1) or (columns and array.shape[1] != columns):
            raise self._wrong(key, f"list of {f'rows of {columns} ' if columns else ''}numbers")
        if not np.isfinite(array).all():
            raise DamagedError(self.file, f"{self._place(key)} holds a number that is not finite")
        return array

    def point(self, key: str) -> Any:
        """Two coordinates, (2,)."""
        array = self.numbers(key)
        if array.shape != (2,):
            raise self._wrong(key, "point")
        return array

    def point_lists(self, key: str) -> list[Any]:
        """A list of lists of points, (k, 2) each."""
        return [Record(self.file, {key: points}, self._where).numbers(key, 2) for points in self.lists(key)]

    def pairs(self, key: str) -> list[Record]:
        """A list of pairs, as records with the keys 0 and 1."""
        items = self.lists(key)
        if not all(isinstance(item, list) and len(item) == 2 for item in items):
            raise self._wrong(key, "list of pairs")
        return [Record(self.file, {"0": item[0], "1": item[1]}, self._place(key)) for item in items]

    def indices(self, key: str, columns: int = 0) -> Any:
        array = self.numbers(key, columns)
        if (array < 0).any() or (array != np.rint(array)).any():
            raise self._wrong(key, "list of numbers of vertices")
        return array.astype(np.int64)

    def texts(self, key: str) -> list[str]:
        value = self._get(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self._wrong(key, "list of texts")
        return value

    def record(self, key: str) -> Record:
        return Record(self.file, self._get(key), self._place(key))

    def records(self, key: str) -> list[Record]:
        value = self.lists(key)
        return [Record(self.file, item, f"{self._place(key)}[{number}]") for number, item in enumerate(value)]

    def lists(self, key: str) -> list[Any]:
        value = self._get(key)
        if not isinstance(value, list):
            raise self._wrong(key, "list")
        return value

    def record_lists(self, key: str) -> list[list[Record]]:
        """A list of lists of records."""
        return [Record(self.file, {key: items}, self._where).records(key) for items in self.lists(key)]

    def names(self) -> list[str]:
        return [str(name) for name in self._content]
