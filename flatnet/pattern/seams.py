"""What is decided once for a seam and carried to every piece along it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.pattern.notches import NotchedSeam, SeamNotch, place_notches, tell_apart
from flatnet.pattern.sewn import Join, join
from flatnet.project.curve_specs import CurveSpec
from flatnet.project.model import Project
from flatnet.project.problems import Problem, ProjectError
from flatnet.project.seam_specs import SeamSpec

#: More notches or nicks than this in one row are a slip of the unit, and would take minutes to place.
MOST_IN_A_ROW = 10_000


@dataclass(frozen=True, eq=False)
class Seam:
    """A stretch of a curve that at least one patch runs along.

    Attributes
    ----------
    number : seams count from 1, in the order of the project; printed on both sides.
    curve : the curve that it is a stretch of.
    spec : how pieces are cut along it.
    patches : the one or two patches along it.
    length : mm.
    notches : in the order of their arclength.
    joins : what its curve is sewn to, where that is not the other side of the same curve.
    partners : the same in words, as printed.
    start, end : the nodes at its ends.
    """

    name: str
    number: int
    curve: str
    spec: SeamSpec
    patches: tuple[str, ...]
    length: float
    notches: tuple[SeamNotch, ...] = ()
    joins: tuple[Join, ...] = ()
    partners: tuple[str, ...] = ()
    start: str | None = None
    end: str | None = None

    @property
    def description(self) -> str:
        """What its number stands for."""
        return " · ".join((self.name, f"{self.length:.1f} mm", " + ".join(self.patches), *self.partners))


def plan_seams(project: Project, network: CurveNetwork) -> dict[str, Seam]:
    """The seams of a project by name, in its order.

    Raises
    ------
    ProjectError
        A notch lies beyond the end of its curve, or there would be far too many.
    """
    patches: dict[str, list[str]] = {name: [] for name in network.stretches}
    for patch in network.patches:
        for along in patch.boundary.stretches:
            patches[along.seam].append(patch.name)
    stretches = {name: stretch for name, stretch in network.stretches.items() if patches[name]}
    marked = _notched(project, network.stretches)
    telling = dict(zip(stretches, tell_apart([marked[name] for name in stretches]), strict=True))
    seams = {
        name: Seam(
            name=name,
            number=number,
            curve=stretch.curve,
            spec=project.curves[stretch.curve].seam,
            patches=tuple(patches[name]),
            length=stretch.length,
            notches=telling[name].notches,
            start=stretch.start,
            end=stretch.end,
        )
        for number, (name, stretch) in enumerate(stretches.items(), start=1)
    }
    return _joined(project, network, seams)


def _joined(project: Project, network: CurveNetwork, seams: Mapping[str, Seam]) -> dict[str, Seam]:
    """The seams with what is said of curves that are sewn to other curves."""
    made, stretches, fold_ends = dict(seams), network.stretches, _fold_ends(network)
    notches = {name: seams[name].notches if name in seams else () for name in stretches}
    for curve in project.curves.values():
        found = join(curve, project.curves, stretches, notches, fold_ends)
        if found is None:
            continue
        joined, carried, kind = found
        for name, _ in (*joined.eased.seams, *joined.plain.seams):
            if name in made:
                seam = made[name]
                partners = (*seam.partners, joined.partner(seam.curve))
                made[name] = replace(seam, joins=(*seam.joins, joined), partners=partners)
            if name in made and name in carried:
                spec = replace(made[name].spec, notches=kind)
                made[name] = replace(made[name], spec=spec, notches=tuple(carried[name]))
    return made


def _fold_ends(network: CurveNetwork) -> dict[str, set[str | None]]:
    """Stretch -> the nodes at the ends of the folds of the patches along it."""
    ends: dict[str, set[str | None]] = {}
    for patch in network.patches:
        along = [network.stretches[run.seam] for run in patch.boundary.stretches]
        fold = {node for each in along if each.curve == patch.fold for node in (each.start, each.end)}
        for each in along:
            if each.curve != patch.fold:
                ends.setdefault(each.name, set()).update(fold)
    return ends


def _notched(project: Project, stretches: Mapping[str, SampledStretch]) -> dict[str, NotchedSeam]:
    """The notches of every stretch, curve by curve."""
    found: dict[str, NotchedSeam] = {}
    problems = []
    for curve in project.curves.values():
        spec = curve.seam.notches
        parts = [stretch for stretch in stretches.values() if stretch.curve == curve.name]
        total = sum(stretch.length for stretch in parts)
        crowded = list(_crowded(curve, total))
        problems += crowded
        if crowded:
            continue
        start = 0.0
        for stretch in parts:
            notches = place_notches(spec, stretch, start, total) if spec else ()
            found[stretch.name] = NotchedSeam(stretch.length, notches, spec is not None and spec.marks is not None)
            start += stretch.length
        for place in spec.at if spec else ():
            if place > total:
                message = f"curve {curve.name!r}: notches: {place:g} mm is beyond its end, it is {total:.1f} mm long"
                problems.append(Problem(curve.mark, message))
    if problems:
        raise ProjectError(project.file, problems)
    return found


def _crowded(curve: CurveSpec, length: float) -> Iterator[Problem]:
    """Rows of notches or nicks that are far too close."""
    for key, row in (("notches", curve.seam.notches), ("nicks", curve.seam.nicks)):
        if row is not None and row.every is not None and length > MOST_IN_A_ROW * row.every:
            yield Problem(
                curve.mark,
                f"curve {curve.name!r}: {key}: one every {row.every:g} mm would be {length / row.every:.3g} along its "
                f"{length:.1f} mm, more than {MOST_IN_A_ROW}; give a larger distance",
            )
