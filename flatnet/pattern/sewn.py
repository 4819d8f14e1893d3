"""Curves that are sewn to other curves: which place of one meets which of the others, and the ease between them.

A curve that begins or ends at the fold of its patch goes on in the other half of the piece: it is sewn with the whole
of it, and so measured. One that stays off the fold (an armhole) is there twice, once on either half, and counts once.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from flatnet.geometry.polygon import arclengths
from flatnet.network.network import SampledStretch
from flatnet.pattern.notches import SeamNotch
from flatnet.project.curve_specs import CurveSpec
from flatnet.project.seam_specs import NotchSpec

#: Notches of one seam that are nearer to each other, mm, are one.
APART = 0.1


class Place(NamedTuple):
    """A place on a seam, where it has a notch; `image`: the same on the other half of a piece on the fold."""

    seam: str
    notch: SeamNotch
    image: bool = False


@dataclass(frozen=True)
class Run:
    """Seams that follow each other along one side of what is sewn together.

    Attributes
    ----------
    curves : the curves as the project names them, in order.
    seams : (name, whether it is run backwards), in order.
    drawn : mm, as it is drawn.
    fold : which end of it, as it is drawn, lies on the fold of its patch: it is half of a curve.
    """

    curves: tuple[str, ...]
    seams: tuple[tuple[str, bool], ...]
    drawn: float
    fold: Literal["start", "end"] | None = None

    @property
    def length(self) -> float:
        """Of the whole, mm."""
        return self.drawn if self.fold is None else 2.0 * self.drawn

    def along(self, drawn: float, image: bool, half: float | None = None) -> float:
        """The arclength on the whole, mm, of one on what is drawn or of its image; `half` : the length drawn."""
        half = self.drawn if half is None else half
        if self.fold == "start":
            return half - drawn if image else half + drawn
        return 2.0 * half - drawn if image else drawn

    def __str__(self) -> str:
        return " + ".join(self.curves)


@dataclass(frozen=True)
class Join:
    """A curve and what it is sewn to.

    Attributes
    ----------
    eased, plain : the curve that says what it is sewn to, and the curves that it is sewn to.
    ease : by how much the first is to be longer, mm, on the whole of both.
    matches : the places that meet, on the first and on the second, from the starts of the whole.
    """

    eased: Run
    plain: Run
    ease: float
    matches: tuple[tuple[Place, Place], ...]

    def partner(self, curve: str) -> str:
        """What is sewn to one of its curves, with the ease."""
        if curve in self.plain.curves:
            return f"sewn to {self.eased}"
        ease = f", ease {self.ease:.1f} mm ({100.0 * self.ease / self.plain.length:.1f} %)" if self.ease else ""
        return f"sewn to {self.plain}{ease}"


def join(
    curve: CurveSpec,
    curves: Mapping[str, CurveSpec],
    stretches: Mapping[str, SampledStretch],
    notches: Mapping[str, Sequence[SeamNotch]],
    fold_ends: Mapping[str, Collection[str | None]],
) -> tuple[Join, dict[str, list[SeamNotch]], NotchSpec] | None:
    """A curve joined to what it is sewn to, the notches that are carried from one to the other, and their kind.

    They are carried in proportion to the lengths, with the marks that they have: all notches, the nodes where
    `nodes` says so, and the places where curves of a list follow each other. None where nothing is said.

    Parameters
    ----------
    notches : stretch -> its own.
    fold_ends : stretch -> the nodes at the ends of the folds of the patches along it.
    """
    said = curve.seam.sewn_to
    if said is None:
        return None
    eased = _run([(curve.name, False)], stretches, fold_ends)
    plain = _run(said.curves, stretches, fold_ends)
    forth = curve.seam.notches is not None
    source, target = (eased, plain) if forth else (plain, eased)
    specs = [spec for name in source.curves if (spec := curves[name].seam.notches)]
    matches: list[tuple[Place, Place]] = []
    carried: dict[str, list[SeamNotch]] = {}
    for arclength, marks in _on_the_whole(source, _marked(source, curves, stretches, notches)):
        here = _place(source, arclength, marks, stretches)
        there = _place(target, arclength * target.length / source.length, marks, stretches)
        matches.append((here, there) if forth else (there, here))
        found = carried.setdefault(there.seam, [])
        if all(abs(notch.arclength - there.notch.arclength) > APART for notch in found):  # both halves carry one
            found.append(there.notch)
    for found in carried.values():
        found.sort(key=lambda notch: notch.arclength)
    kind = replace(specs[0], nodes=False) if specs else NotchSpec()
    return Join(eased, plain, said.ease(plain.length), tuple(matches)), carried, kind


def _run(
    curves: Sequence[tuple[str, bool]],
    stretches: Mapping[str, SampledStretch],
    fold_ends: Mapping[str, Collection[str | None]],
) -> Run:
    seams = []
    for name, back in curves:
        own = [stretch.name for stretch in stretches.values() if stretch.curve == name]
        seams += [(each, back) for each in (own[::-1] if back else own)]
    drawn = sum(stretches[name].length for name, _ in seams)
    (first, first_back), (last, last_back) = seams[0], seams[-1]
    start = stretches[first].end if first_back else stretches[first].start
    end = stretches[last].start if last_back else stretches[last].end
    fold: Literal["start", "end"] | None = None
    if end in fold_ends.get(last, ()):
        fold = "end"
    elif start in fold_ends.get(first, ()):
        fold = "start"
    return Run(tuple(name for name, _ in curves), tuple(seams), drawn, fold)


def _on_the_whole(run: Run, marked: Sequence[tuple[float, int]]) -> list[tuple[float, int]]:
    """(arclength on the whole, marks), in order, of what is marked on what is drawn of a run."""
    halves = (False, True) if run.fold else (False,)
    found = sorted((run.along(place, image), marks) for place, marks in marked for image in halves)
    # What is marked on the fold itself is there once.
    return [each for k, each in enumerate(found) if k == 0 or each[0] - found[k - 1][0] > APART]


def _marked(
    run: Run,
    curves: Mapping[str, CurveSpec],
    stretches: Mapping[str, SampledStretch],
    notches: Mapping[str, Sequence[SeamNotch]],
) -> list[tuple[float, int]]:
    """(arclength along the run, marks) of what the other side is to meet."""
    found = []
    start = 0.0
    for number, (name, back) in enumerate(run.seams):
        stretch = stretches[name]
        spec = curves[stretch.curve].seam.notches
        if number > 0:
            between_curves = stretches[run.seams[number - 1][0]].curve != stretch.curve
            node = stretch.end if back else stretch.start
            if between_curves or (spec is not None and spec.is_at(node)):
                found.append((start, 1))
        own = [(stretch.length - n.arclength if back else n.arclength, n.marks) for n in notches[name]]
        found += [(start + place, marks) for place, marks in sorted(own)]
        start += stretch.length
    return found


def _place(run: Run, arclength: float, marks: int, stretches: Mapping[str, SampledStretch]) -> Place:
    """The place at an arclength of the whole of a run."""
    image = False
    if run.fold == "start":
        arclength, image = abs(arclength - run.drawn), arclength < run.drawn
    elif run.fold == "end":
        arclength, image = min(arclength, run.length - arclength), arclength > run.drawn
    *before, last = run.seams
    for name, back in before:
        if arclength <= stretches[name].length:
            last = name, back
            break
        arclength -= stretches[name].length
    name, back = last
    along = arclengths(stretches[name].vertices)
    within = float(np.clip(along[-1] - arclength if back else arclength, 0.0, along[-1]))
    edge = int(np.clip(np.searchsorted(along, within, side="right") - 1, 0, len(along) - 2))
    fraction = float((within - along[edge]) / (along[edge + 1] - along[edge]))
    return Place(name, SeamNotch(edge, fraction, within, marks), image)
