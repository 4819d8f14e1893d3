"""Find the faces that the project's patches and openings mean: match each `around` with the traced loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

from flatnet.network.graph import Dart, Face, TracedFaces
from flatnet.network.network import SampledStretch
from flatnet.project.model import Project
from flatnet.project.patch_specs import OpeningSpec, PatchSpec, SignedCurve
from flatnet.project.problems import Mark, Problem

#: How many of the faces nearest to a wrong `around` are printed.
NEAREST_SHOWN = 3


@dataclass(frozen=True)
class MatchedFaces:
    """The loops of every patch and opening that has faces, each starting where its `around` starts."""

    patches: Mapping[str, tuple[tuple[Dart, ...], ...]]
    openings: Mapping[str, tuple[tuple[Dart, ...], ...]]


def match_faces(
    project: Project, stretches: Mapping[str, SampledStretch], traced: TracedFaces
) -> tuple[MatchedFaces, list[Problem]]:
    """Give every `around` its face and every face its `around`.

    Problems are: an `around` that is no face, or could be several; a face listed twice; a face listed nowhere
    (unless the project says `rest: openings`); no patch at all. Where a closed curve without node is the whole
    network, the side of it that is not listed is open without further word.
    """
    matcher = FaceMatcher(stretches, traced.faces)
    problems: list[Problem] = []
    owner: dict[Face, str] = {}
    found: dict[str, dict[str, tuple[tuple[Dart, ...], ...]]] = {"patch": {}, "opening": {}}
    listed: list[tuple[str, PatchSpec | OpeningSpec]] = [("patch", p) for p in project.patches.values()]
    listed += [("opening", o) for o in project.openings.values()]
    for kind, spec in listed:
        loops = []
        title = f"{kind} '{spec.name}'"
        for around in spec.loops:
            matches = matcher.matches(around)
            if len(matches) != 1:
                problems.append(Problem(around[0].mark, f"{title}: {matcher.explain(around, matches)}"))
                continue
            face, darts = matches[0]
            if face in owner:
                problems.append(
                    Problem(around[0].mark, f"{title}: the face {_around(darts)} already is {owner[face]}")
                )
            owner.setdefault(face, title)
            loops.append(darts)
        if len(loops) == len(spec.loops):
            found[kind][spec.name] = tuple(loops)

    rest = [face for face in traced.faces if face not in owner]
    lone_side = len(traced.faces) == 2 and stretches[traced.faces[0].darts[0].stretch].start is None
    if rest and not project.rest_is_open and not (lone_side and len(rest) == 1):
        problems.append(_unlisted(project, stretches, matcher, rest, len(traced.euler_characteristics)))
    elif not project.patches:
        problems.append(Problem(None, "every face is an opening, and no patch is left to make"))
    return MatchedFaces(found["patch"], found["opening"]), problems


class FaceMatcher:
    """Reads an `around` against the traced faces, and writes a face as an `around`."""

    def __init__(self, stretches: Mapping[str, SampledStretch], faces: Sequence[Face]) -> None:
        self.stretches = stretches
        self.faces = faces

    def matches(self, around: Sequence[SignedCurve]) -> list[tuple[Face, tuple[Dart, ...]]]:
        """The faces that an `around` may stand for, with their darts from where it starts."""
        found = []
        for face in self.faces:
            darts = self._turned(around, face.darts)
            if darts:
                found.append((face, darts))
        return found

    def _turned(self, around: Sequence[SignedCurve], darts: tuple[Dart, ...]) -> tuple[Dart, ...] | None:
        """The darts of a loop from where an `around` starts; None where it is another loop."""
        turns = (darts[i:] + darts[:i] for i in range(len(darts)))
        return next((turn for turn in turns if self._reads(around, turn)), None)

    def _reads(self, around: Sequence[SignedCurve], darts: Sequence[Dart]) -> bool:
        """Whether the darts are the entries of `around`, in order, each a run of stretches of its curve."""
        if not around or not darts:
            return not around and not darts
        return any(self._reads(around[1:], darts[size:]) for size in self._runs(around[0], darts))

    def _runs(self, entry: SignedCurve, darts: Sequence[Dart]) -> Iterator[int]:
        """How many of the first darts the entry may stand for."""
        for size, dart in enumerate(darts, start=1):
            if self.stretches[dart.stretch].curve != entry.curve or dart.reversed != entry.reversed:
                return
            first, last = (darts[size - 1], darts[0]) if entry.reversed else (darts[0], darts[size - 1])
            ends = (self.stretches[first.stretch].start, self.stretches[last.stretch].end)
            if entry.stretch is None or entry.stretch == ends:
                yield size

    def shortest_around(self, darts: Sequence[Dart]) -> str:
        """A face as `around`: with plain curve names where they fit it alone, else with stretch names."""
        signed = self._signed(darts)
        start = next((i for i in range(len(signed)) if signed[i - 1] != signed[i]), 0)
        signed = signed[start:] + signed[:start]
        runs = [s for i, s in enumerate(signed) if i == 0 or s != signed[i - 1]]
        plain = [SignedCurve(curve, reversed_, None, Mark(0, 0)) for curve, reversed_ in runs]
        return _around(plain if len(self.matches(plain)) == 1 else darts)

    def explain(self, around: Sequence[SignedCurve], matches: Sequence[tuple[Face, tuple[Dart, ...]]]) -> str:
        """Why an `around` has no face, or several, and what could be written instead."""
        if matches:
            written = " or ".join(_around(darts) for _, darts in matches)
            return f"around {_around(around)} fits {len(matches)} faces; name the stretches: {written}"
        message = f"around {_around(around)} is no face of the network"
        for face in self.faces:
            rim = tuple(dart for dart in face.darts if dart.opposite not in face.darts)
            if len(rim) < len(face.darts) and self._turned(around, rim):
                return f"{message}; curves that run inside it belong there, there and back: " + (
                    self.shortest_around(face.darts)
                )
        backwards = [SignedCurve(e.curve, not e.reversed, e.stretch, e.mark) for e in reversed(around)]
        if self.matches(backwards):
            message += (
                f"; run the other way it is: {_around(backwards)} (a patch lies on the left of its boundary, "
                "seen against the normals: turn the loop round, or the normals)"
            )
        nearest = sorted(self.faces, key=lambda face: self._difference(around, face))[:NEAREST_SHOWN]
        return f"{message}; the nearest faces are {', '.join(self.shortest_around(f.darts) for f in nearest)}"

    def _signed(self, darts: Sequence[Dart]) -> list[tuple[str, bool]]:
        return [(self.stretches[d.stretch].curve, d.reversed) for d in darts]

    def _difference(self, around: Sequence[SignedCurve], face: Face) -> tuple[int, int]:
        """How many curves, and how many signed curves, are in one of both only."""
        asked = {(entry.curve, entry.reversed) for entry in around}
        there = set(self._signed(face.darts))
        return len({c for c, _ in asked} ^ {c for c, _ in there}), len(asked ^ there)


def _unlisted(
    project: Project,
    stretches: Mapping[str, SampledStretch],
    matcher: FaceMatcher,
    rest: Sequence[Face],
    parts: int,
) -> Problem:
    """The faces listed nowhere, ready to paste."""
    taken = {*project.patches, *project.openings}
    free = (name for name in (f"face_{i}" for i in count(1)) if name not in taken)
    lines = []
    for name, face in zip(free, rest):
        length = sum(stretches[dart.stretch].length for dart in face.darts)
        lines.append(f"  {name}: {{around: {matcher.shortest_around(face.darts)}}}  # {length:.0f} mm around")
    curve = project.curves[stretches[rest[0].darts[0].stretch].curve]
    what = "1 face is" if len(rest) == 1 else f"{len(rest)} faces are"
    message = f"{what} listed neither under patches nor under openings"
    if parts > 1:
        message = (
            f"ambiguous_faces: the network has {parts} parts that no curve joins, and {message}: a loop may "
            "be a face by itself, or one of several loops of a face, around: [[...], [...]]"
        )
    return Problem(curve.mark, "\n".join([f"{message}; ready to paste under one of them:", *lines]))


def _around(entries: Sequence[Dart] | Sequence[SignedCurve]) -> str:
    return f"[{', '.join(map(str, entries))}]"
