"""Read models in space: GLB, PLY, and OBJ with several objects."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.written import DamagedError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: glTF's numbers for the types of components, with numpy's names.
_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_PLY = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4",
    "int32": "<i4", "uint": "<u4", "uint32": "<u4", "float": "<f4", "float32": "<f4", "double": "<f8", "float64": "<f8",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Model:
    """A patch of a model: vertices (m, 3), flat (m, 2) mm, triangles (t, 3)."""

    vertices: Floats
    flat: Floats
    triangles: Ints


def read_glb(file: str, content: bytes) -> dict[str, Model]:
    """Name of a node -> its mesh in mm with z up; flat: where its first morph target lays it.

    Raises
    ------
    DamagedError
        It is no binary glTF 2.0, or cut short.
    """
    try:
        magic, version, length = struct.unpack_from("<4sII", content)
        if magic != b"glTF" or version != 2 or length != len(content):
            raise ValueError(f"its head says {length} bytes, and it has {len(content)}")
        json_length = struct.unpack_from("<I", content, 12)[0]
        document = json.loads(content[20 : 20 + json_length])
        data = content[28 + json_length :]
        models = {}
        for node in document["nodes"]:
            (primitive,) = document["meshes"][node["mesh"]]["primitives"]
            places = _accessor(document, data, primitive["attributes"]["POSITION"])
            moved = places + _accessor(document, data, primitive["targets"][0]["POSITION"])
            triangles = _accessor(document, data, primitive["indices"]).astype(np.int64).reshape(-1, 3)
            flat = _z_up(moved)
            if float(np.ptp(flat[:, 2])) > 1e-4 * max(float(np.ptp(flat[:, :2])), 1.0):
                raise ValueError(f"the morph target of '{node['name']}' is not flat")
            models[node["name"]] = Model(_z_up(places), flat[:, :2], triangles)
    except (KeyError, IndexError, TypeError, ValueError, struct.error) as error:
        raise DamagedError(file, f"is no GLB of a model, or cut short: {error}") from None
    return models


def _z_up(points: Floats) -> Floats:
    """From metres with y up."""
    return 1e3 * points @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def _accessor(document: dict[str, list[dict[str, int | str]]], data: bytes, number: int) -> Floats:
    accessor = document["accessors"][number]
    view = document["bufferViews"][int(accessor["bufferView"])]
    kind, width = _COMPONENTS[int(accessor["componentType"])], _WIDTHS[str(accessor["type"])]
    start = int(view.get("byteOffset", 0)) + int(accessor.get("byteOffset", 0))
    values = np.frombuffer(data, kind, int(accessor["count"]) * width, start)
    return values.astype(np.float64).reshape(-1, width)


def read_ply(file: str, content: bytes) -> Model:
    """One mesh, binary and little-endian, with the flat coordinates as properties s and t of its vertices."""
    try:
        head, data = content.split(b"end_header\n", 1)
        lines = [line.split() for line in head.decode("ascii").splitlines()]
        if ["format", "binary_little_endian", "1.0"] not in lines:
            raise ValueError("it is not binary and little-endian")
        counts: dict[str, int] = {}
        fields: dict[str, list[list[str]]] = {}
        for words in lines:
            if words[:1] == ["element"]:
                name = words[1]
                counts[name], fields[name] = int(words[2]), []
            elif words[:1] == ["property"]:
                fields[name].append(words[1:])
        vertex = np.dtype([(words[1], _PLY[words[0]]) for words in fields["vertex"]])
        (_, size, kind, _), *_ = fields["face"]
        face = np.dtype([("count", _PLY[size]), ("corners", _PLY[kind], 3)])
        vertices = np.frombuffer(data, vertex, counts["vertex"])
        faces = np.frombuffer(data, face, counts["face"], vertices.nbytes)
        if (faces["count"] != 3).any():
            raise ValueError("a face is no triangle")
        columns = {key: vertices[key].astype(np.float64) for key in "xyzst"}
    except (KeyError, TypeError, ValueError, UnicodeDecodeError) as error:
        raise DamagedError(file, f"is no PLY of a model, or cut short: {error}") from None
    return Model(
        np.column_stack([columns[key] for key in "xyz"]),
        np.column_stack([columns[key] for key in "st"]),
        faces["corners"].astype(np.int64),
    )
