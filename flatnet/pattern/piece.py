"""A fitted patch becomes a piece to cut: sew line, cut line, seams, grain, labels, in the flat frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Geometry, Polygon

from flatnet.failure import Finding, PatchFailure
from flatnet.fitting.results import FittedPatch
from flatnet.geometry.polygon import side_lengths
from flatnet.geometry.triangles import boundary_triangle_normals
from flatnet.network.patch import Patch, Stretch
from flatnet.pattern.allowance import TOUCH, cut_line
from flatnet.pattern.darts import Dart, dart_marks, dart_notches, fold_darts, with_straight_legs
from flatnet.pattern.edging import Edging, Fold, edging, is_on_fold, unfolded
from flatnet.pattern.labels import Label, grain_line, name_label, room_for_text, seam_label
from flatnet.pattern.marks import Mark, make_marks
from flatnet.pattern.nicks import Nick, nicks_along, turns_under
from flatnet.pattern.notches import Notch, SeamNotch, notch_on_piece
from flatnet.pattern.seams import Seam
from flatnet.project.model import Material
from flatnet.project.patch_specs import AlsoSpec, MarkSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SeamRun:
    """One seam along a piece.

    Attributes
    ----------
    vertices : (k,) int; the sew line's vertices along the seam, in the seam's own direction, so that both
        pieces of a seam count from the same end.
    label : the seam's number, and name where it has room, inside the piece; None where it fits nowhere.
    """

    seam: Seam
    vertices: Ints
    label: Label | None

    def __post_init__(self) -> None:
        self.vertices.setflags(write=False)

    def edges(self, count: int) -> Ints:
        """Those along it of a sew line of `count` vertices, (k - 1,), in the seam's direction; edge i starts at i."""
        starts, ends = self.vertices[:-1], self.vertices[1:]
        return np.where(ends == (starts + 1) % count, starts, ends)


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece as it is cut and marked: mm, anticlockwise seen from the normals' side, the grain along +x.

    Attributes
    ----------
    sew_line : (n, 2) float; the flat boundary of the patch, untouched.
    cut_line : (k, 2) float; the sew line and its allowances.
    holes : (k, 2) float each, clockwise; cut out inside it: what a patch that closes on itself goes round.
    allowances : (n,) float; of the sew line's edge from vertex i to vertex i + 1.
    grain : (2, 2) float; the arrow's tail and head, inside the piece; None where the patch has no grain.
    one_way : its material may not be turned by 180 degrees (a nap).
    notches : marks in the allowance, from the cut line inwards.
    marks : lines and points that are drawn and not cut.
    label : name, copies, material and what it belongs to, well inside the piece.
    cut, mirrored : how many plain and how many mirrored copies are cut.
    material : name of the material.
    project : what it belongs to, with its size.
    nicks : cuts into allowances that are folded over.
    fold : the line along which it is its own mirror image, where the project says that it is to be cut on the fold.
    on_fold : it is the half that is cut on the fold.
    warnings : what whoever cuts it has to know.
    zone : the quality zone of a hide that it lies in; "": anywhere.
    match : all its copies lie in the same direction.
    """

    name: str
    sew_line: Floats
    cut_line: Floats
    holes: tuple[Floats, ...]
    allowances: Floats
    seams: tuple[SeamRun, ...]
    notches: tuple[Notch, ...]
    marks: tuple[Mark, ...]
    grain: Floats | None
    one_way: bool
    label: Label
    cut: int
    mirrored: int
    material: str
    project: str = ""
    nicks: tuple[Nick, ...] = ()
    fold: Fold | None = None
    on_fold: bool = False
    warnings: tuple[Finding, ...] = ()
    zone: str = ""
    match: bool = False

    def __post_init__(self) -> None:
        for array in (self.sew_line, self.cut_line, *self.holes, self.allowances):
            array.setflags(write=False)

    @cached_property
    def region(self) -> Polygon:
        """What is inside the cut line and outside its holes."""
        return Polygon(self.cut_line, self.holes) if self.holes else region_of(self.cut_line)

    @property
    def description(self) -> tuple[str, ...]:
        """What has to be said of it: name, copies, material, project."""
        return (self.name, *what_to_cut(self.cut, self.mirrored, self.material, self.project, self.on_fold))

    @property
    def area(self) -> float:
        """mm^2 inside the cut line."""
        return float(self.region.area)


def region_of(outline: Floats) -> Polygon:
    """The region inside a closed outline, which may touch itself along a slit.

    An outline that overlaps itself covers some of its region twice: its signed area and that of the region
    differ.

    Raises
    ------
    ValueError
        Where the outline crosses itself; says where and how much is covered twice.
    """
    polygon = Polygon(outline)
    if polygon.is_valid:
        return polygon
    slack = TOUCH * polygon.length
    repaired = shapely.get_parts(shapely.make_valid(polygon, method="structure", keep_collapsed=False))
    parts = [part for part in repaired if part.area > slack]
    difference = abs(polygon.area - sum(part.area for part in parts))
    if len(parts) != 1 or difference > slack:
        raise ValueError(f"it crosses itself ({shapely.is_valid_reason(polygon)} mm; {difference:.3g} mm^2)")
    return Polygon(parts[0].exterior, [hole for hole in parts[0].interiors if Polygon(hole).area > slack])


def make_piece(
    fitted: FittedPatch,
    material: Material,
    seams: Mapping[str, Seam],
    project: str = "",
    also: AlsoSpec | None = None,
    marks: Sequence[MarkSpec] = (),
) -> Piece:
    """Draw the piece of a fitted patch.

    Parameters
    ----------
    seams : what is decided for each of its seams, by name.
    project : what it belongs to, for its label.
    also : how it is cut from a further material; None: from the patch's own.
    marks : what is drawn inside it.

    Raises
    ------
    PatchFailure
        `self_intersection` where the sew line overlaps itself in the plane: such a piece can't be cut.
    """
    patch = fitted.patch
    copies = (patch.cut, patch.mirrored) if also is None else (also.cut, also.mirrored)
    edged, fold = edging(patch, fitted.outline, material, seams), None
    if patch.fold is not None and is_on_fold(patch, seams):
        edged, fold = unfolded(edged, patch, seams)
    elif patch.fold is not None:  # a part beside the one with the fold: there are two of it
        copies = (sum(copies), sum(copies))
    sew_line, widths, darts = edged.sew_line, edged.widths, list(edged.darts)
    inside = _inside(patch, sew_line)
    if also is not None and also.allowance is not None:
        widths[:] = also.allowance
    for dart in darts:
        widths[dart.edges] = 0.0
    outline = with_straight_legs(sew_line, darts) if darts else sew_line
    cut = fold_darts(cut_line(outline, region_of(outline), widths, edged.corners), darts)
    rings = shapely.MultiLineString([[*ring, ring[0]] for ring in (cut.outline, *cut.holes)])
    notches = _notches(edged, rings, seams)
    notches += tuple(notch for dart in darts for notch in dart_notches(dart, cut))
    drawn, far = _marks(fitted, marks, darts, fold)
    lines = [line for notch in notches for line in notch.lines] + [line for mark in drawn for line in mark.lines]
    free = room_for_text(inside, [sew_line[np.r_[:len(sew_line), 0]], *lines])
    label = name_label(patch.name, what_to_cut(*copies, material.name, project), free)
    runs, free = _seam_runs(edged, seams, free.difference(label.box))
    return Piece(
        name=patch.name,
        sew_line=sew_line,
        cut_line=cut.outline,
        holes=cut.holes,
        allowances=widths,
        seams=tuple(runs),
        notches=notches,
        marks=tuple(drawn),
        grain=grain_line(free) if _shows_grain(fitted, material) else None,
        one_way=material.one_way,
        label=label,
        cut=copies[0],
        mirrored=copies[1],
        material=material.name,
        project=project,
        nicks=_nicks(fitted, edged, rings, seams, notches),
        fold=fold,
        warnings=(
            *(_crowded(patch, edged, first, count, also) for first, count in cut.crowded),
            *_deep_notches(patch, notches, also),
            *far,
        ),
    )


def _inside(patch: Patch, sew_line: Floats) -> Polygon:
    """What is inside the sew line."""
    try:
        return region_of(sew_line)
    except ValueError as error:
        raise PatchFailure.of(
            "self_intersection", "pattern", f"the flat piece can't be cut from one sheet: {error}.",
            "Divide the patch by another curve through the place where it overlaps.", patch=patch.name,
        ) from error


def _marks(
    fitted: FittedPatch, specs: Sequence[MarkSpec], darts: Sequence[Dart], fold: Fold | None
) -> tuple[list[Mark], list[Finding]]:
    """What is drawn inside a piece, on both sides of its fold, and warnings of marks that lie off it."""
    drawn, far = make_marks(fitted, specs)
    if fold is not None:
        drawn += [image for mark in drawn if (image := _across(mark, fold))]
        drawn.append(Mark(fitted.patch.fold or "", "fold", fold.line))
    return drawn + [mark for dart in darts for mark in dart_marks(dart)], far


def _seam_runs(edged: Edging, seams: Mapping[str, Seam], free: Geometry) -> tuple[list[SeamRun], Geometry]:
    """The seams along a sew line, with their labels where there is room, and the room that these leave."""
    runs = []
    for stretch in edged.stretches:
        along = np.arange(stretch.first, stretch.first + stretch.count + 1) % len(edged.sew_line)
        seam = seams[stretch.seam]
        words = seam_label(seam.number, seam.name, edged.sew_line[along], free)
        if words:
            free = free.difference(words.box)
        runs.append(SeamRun(seam, along[::-1].copy() if stretch.reversed else along, words))
    return runs, free


def _across(mark: Mark, fold: Fold) -> Mark | None:
    """A mark's mirror image; None of one that is its own."""
    points = fold.reflect(mark.points)
    return None if np.abs(points - mark.points).max() < TOUCH else replace(mark, points=points)


def _shows_grain(fitted: FittedPatch, material: Material) -> bool:
    """Whether the piece has an arrow: on leather, which may lie as it likes, only where the project asks for it."""
    grain = fitted.patch.grain
    return fitted.has_grain and grain is not None and (grain.said or material.rotations is not None)


def _nicks(
    fitted: FittedPatch, edged: Edging, rings: shapely.Geometry, seams: Mapping[str, Seam], notches: Sequence[Notch]
) -> tuple[Nick, ...]:
    """The nicks of every seam whose allowance has some."""
    mesh, n = fitted.mesh, fitted.mesh.boundary_count
    feet = [notch.foot for notch in notches]
    found: list[Nick] = []
    for stretch in edged.stretches:
        spec = seams[stretch.seam].spec.nicks
        if spec is not None:
            along = np.arange(stretch.first, stretch.first + stretch.count + 1) % len(edged.sew_line)
            source = edged.sources[along]
            edges = np.where(source[1:] == (source[:-1] + 1) % n, source[:-1], source[1:])
            normals = boundary_triangle_normals(mesh.vertices, mesh.triangles, n)[edges]
            under = turns_under(mesh.vertices[source], normals)
            width = float(edged.widths[stretch.first])
            found += nicks_along(stretch.seam, spec, edged.sew_line[along], under, width, rings, feet)
    return tuple(found)


def _notches(edged: Edging, rings: shapely.Geometry, seams: Mapping[str, Seam]) -> tuple[Notch, ...]:
    """The notches of every seam, and those at nodes where the outline runs straight on along one curve."""
    sew_line, stretches = edged.sew_line, edged.stretches
    found = []
    for before, stretch in zip((stretches[-1], *stretches[:-1]), stretches, strict=True):
        seam = seams[stretch.seam]
        if seam.spec.notches is None:
            continue
        spec = seam.spec.notches
        notches = [_on_boundary(stretch, notch) for notch in seam.notches]
        node = seam.end if stretch.reversed else seam.start
        if spec.is_at(node) and len(stretches) > 1 and seams[before.seam].curve == seam.curve:
            notches.append((stretch.first, 0.0, 1))
        for edge, fraction, marks in notches:
            ends = sew_line[[edge, (edge + 1) % len(sew_line)]]
            found.append(notch_on_piece(seam.name, spec, ends, fraction, marks, float(edged.widths[edge]), rings))
    return tuple(found)


def _on_boundary(stretch: Stretch, notch: SeamNotch) -> tuple[int, float, int]:
    """A notch's boundary edge and place on it, in the direction of the boundary, and its marks."""
    if stretch.reversed:
        return stretch.first + stretch.count - 1 - notch.edge, 1.0 - notch.fraction, notch.marks
    return stretch.first + notch.edge, notch.fraction, notch.marks


def _also_of(also: AlsoSpec | None, curves: str) -> tuple[str, str]:
    """In a warning: which of a patch's pieces it is, and whose allowance counts, that of its curves or one for all."""
    if also is None:
        return "", curves
    return f" of {also.material!r}", curves if also.allowance is None else f"{also.material!r} under `also`"


def _deep_notches(patch: Patch, notches: Sequence[Notch], also: AlsoSpec | None) -> Iterator[Finding]:
    """One warning for every seam whose notches reach across the sew line."""
    which, whose = _also_of(also, "its curve")
    for seam in dict.fromkeys(notch.seam for notch in notches):
        over = [n.depth - float(np.linalg.norm(n.foot - n.position)) for n in notches if n.seam == seam]
        if max(over) > TOUCH:
            yield Finding(
                code="deep_notch",
                stage="pattern",
                patch=patch.name,
                where=f"'{seam}'",
                amount=max(over),
                unit="mm",
                message=f"notches of '{seam}' reach {max(over):.1f} mm across the sew line into the piece{which}.",
                remedy=f"Give {whose} a larger `allowance` or the curve's `notches` a smaller `depth`.",
            )


def _crowded(patch: Patch, edged: Edging, first: int, count: int, also: AlsoSpec | None) -> Finding:
    which, whose = _also_of(also, "its curves")
    edges = np.arange(first, first + count + 1) % len(edged.widths)
    length, width = float(side_lengths(edged.sew_line)[edges[:-1]].sum()), float(edged.widths[edges[:-1]].max())
    start, end = (patch.boundary.place(int(edged.sources[vertex])) for vertex in edges[[0, -1]])
    return Finding(
        code="crowded_allowance",
        stage="pattern",
        patch=patch.name,
        where=f"from {start} to {end}",
        amount=length,
        unit="mm",
        message=f"the allowance of {width:g} mm{which} has no room along {length:.0f} mm, from {start} to {end}: the "
        "piece itself or another allowance lies there, and the cut line leaves this part of the sew line out.",
        remedy=f"Give {whose} a smaller `allowance`, 0 at the least, or divide the patch.",
    )


def what_to_cut(cut: int, mirrored: int, material: str, project: str, on_fold: bool = False) -> tuple[str, ...]:
    """What is printed below a piece's name; on the fold, a mirrored copy is one like the others."""
    copies = f"cut {cut}" + (f" + {mirrored} mirrored" if mirrored else "")
    if on_fold:
        copies = f"cut {cut + mirrored} on the fold"
    return (copies, material, *([project] if project else []))
