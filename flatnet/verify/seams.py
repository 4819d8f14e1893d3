"""Check the seams: every side on its curve, both sides equal, the boundary of every patch all seams."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.build import NETWORK, PIECES, Findings, WrittenBuild, WrittenCurve, WrittenPatch, WrittenPiece
from flatnet.verify.measured import LENGTH, PLACE, Measured
from flatnet.verify.mesh import farthest, lengths
from flatnet.verify.written import REPORT, DamagedError, Record

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SeamSide:
    """A patch along a seam.

    Attributes
    ----------
    key : `a` or `b`, as the report calls it.
    vertices : (k,) int, in the seam's direction.
    reversed : the patch's boundary runs against it.
    """

    key: str
    patch: WrittenPatch
    vertices: Ints
    reversed: bool

    @property
    def steps(self) -> Floats:
        """Flat length of every edge, (k - 1,)."""
        return lengths(self.patch.mesh.flat, self.pairs)

    @property
    def arclengths(self) -> Floats:
        """Of its vertices along the flat piece, (k,)."""
        return np.concatenate([[0.0], np.cumsum(self.steps)])

    def place(self, arclength: float) -> Floats:
        """A point of the flat piece, (2,)."""
        flat = self.patch.mesh.flat[self.vertices]
        return np.array([np.interp(arclength, self.arclengths, flat[:, axis]) for axis in (0, 1)])

    @property
    def pairs(self) -> Ints:
        return np.stack([self.vertices[:-1], self.vertices[1:]], axis=1)


@dataclass(frozen=True, eq=False)
class WrittenSeam:
    """A stretch of a curve and the patches along it (those that were made)."""

    name: str
    curve: WrittenCurve
    sides: tuple[SeamSide, ...]
    record: Record

    @property
    def steps(self) -> Floats:
        """Length of every edge in space, (k - 1,)."""
        count = len(self.curve.vertices)
        return lengths(self.curve.vertices, np.stack([np.arange(count - 1), np.arange(1, count)], axis=1))


def read_seams(build: WrittenBuild, findings: Findings) -> list[WrittenSeam]:
    """The seams of the report, with the curves of the network and the meshes of the patches."""
    seams = []
    with findings.guarded():
        for record in build.report.records("seams"):
            with findings.guarded():
                name = record.text("curve")
                if name not in build.curves:
                    raise DamagedError(NETWORK, f"holds no curve '{name}', along which the report has a seam")
                curve = build.curves[name]
                sides = [_side(name, key, side, build) for key, side in zip("ab", record.records("sides"))]
                seams.append(WrittenSeam(name, curve, tuple(side for side in sides if side), record))
    return seams


def _side(seam: str, key: str, record: Record, build: WrittenBuild) -> SeamSide | None:
    patch = build.patches.get(record.text("patch"))
    if patch is None or patch.mesh.faults:
        return None
    ids = record.indices("vertices")
    where = f"seam '{seam}', side of '{patch.name}'"
    if len(ids) != len(build.curves[seam].vertices):
        count = len(build.curves[seam].vertices)
        raise DamagedError(REPORT, f"{where}: {len(ids)} vertices, and the curve in {NETWORK} has {count}")
    if ids.max() >= len(patch.mesh.vertices):
        raise DamagedError(REPORT, f"{where}: vertex {ids.max()}, and {patch.file} has {len(patch.mesh.vertices)}")
    following = dict(patch.mesh.half_edges[patch.mesh.twins < 0].tolist())
    forwards = [following.get(a) == b for a, b in zip(ids[:-1].tolist(), ids[1:].tolist())]
    backwards = [following.get(b) == a for a, b in zip(ids[:-1].tolist(), ids[1:].tolist())]
    if not all(forwards) and not all(backwards):
        bad = min(forwards.count(False), backwards.count(False))
        raise DamagedError(REPORT, f"{where}: {bad} of its edges do not follow the boundary of {patch.file}")
    return SeamSide(key, patch, ids, not all(forwards))


def check_seams(build: WrittenBuild, seams: list[WrittenSeam]) -> Iterator[Measured]:
    """Every side of every seam, both together, and that they are all of every boundary."""
    for seam in seams:
        for side in seam.sides:
            yield from _check_side(seam, side)
        if len(seam.sides) == 2:
            yield from _check_both(seam, *seam.sides)
    for patch in build.patches.values():
        if patch.mesh.faults:
            continue
        used = [np.sort(side.pairs, axis=1) for seam in seams for side in seam.sides if side.patch is patch]
        rim = np.sort(patch.mesh.half_edges[patch.mesh.twins < 0], axis=1)
        _, count = np.unique(np.concatenate([rim, *used]), axis=0, return_counts=True)
        off = int((count != 2).sum())
        words = f"{off} edges of the boundary are along no seam, or along two"
        yield Measured("boundary all seams", patch.file, patch.name, float(off), 0.0, words=words)


def _check_side(seam: WrittenSeam, side: SeamSide) -> Iterator[Measured]:
    patch, subject = side.patch, f"{side.patch.name} along '{seam.name}'"
    away = farthest(patch.mesh.vertices[side.vertices], seam.curve.vertices)
    yield Measured("boundary on the network", patch.file, subject, away, PLACE, "mm", f"off its curve in {NETWORK}")
    worst, allowed = _difference(side.steps, seam.steps)
    yield Measured("seam lengths, flat and in space", patch.file, subject, worst, allowed, "mm")


def _check_both(seam: WrittenSeam, first: SeamSide, second: SeamSide) -> Iterator[Measured]:
    subject = f"'{seam.name}' of {first.patch.name} and {second.patch.name}"
    file = f"{first.patch.file}, {second.patch.file}"
    apart = farthest(first.patch.mesh.vertices[first.vertices], second.patch.mesh.vertices[second.vertices])
    yield Measured("both sides of a seam in space", file, subject, apart, PLACE, "mm")
    worst, allowed = _difference(first.steps, second.steps)
    yield Measured("both sides of a seam when flat", file, subject, worst, allowed, "mm")
    alike = float(first.reversed == second.reversed)
    yield Measured("seams join opposite sides", file, subject, alike, 0.0, words="both patches lie on the same side")


def check_notches(build: WrittenBuild, seams: list[WrittenSeam], findings: Findings) -> None:
    """Every notch of a seam is on the pieces of both sides, where the report says."""
    for seam in seams:
        for side in seam.sides:
            for piece in build.pieces:
                if piece.patch == side.patch.name:
                    with findings.guarded():
                        findings += _check_notches(seam, side, piece)


def _check_notches(seam: WrittenSeam, side: SeamSide, piece: WrittenPiece) -> Iterator[Measured]:
    on_piece = piece.notches.get(seam.name, [])
    for number, notch in enumerate(seam.record.records("notches"), start=1):
        place = side.place(notch.number(f"at_{side.key}_mm"))
        off = min((float(np.linalg.norm(place - other)) for other in on_piece), default=np.nan)
        subject = f"{piece.name}, notch {number} of '{seam.name}'"
        yield Measured("notches on both sides", PIECES, subject, off, PLACE, "mm", "not where the report says")


def _difference(first: Floats, second: Floats) -> tuple[float, float]:
    """The larger of what an edge and what the whole differs by, and what is allowed."""
    whole = abs(float(first.sum() - second.sum()))
    return max(float(np.abs(first - second).max(initial=0.0)), whole), max(PLACE, LENGTH * float(first.sum()))
