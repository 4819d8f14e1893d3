"""The panels of a build's picture: network, meshes by flattenability, shaded meshes, layouts.

Meshes are projected and sorted by us, triangles and boundaries of all patches together, and handed over as
plain polygons: matplotlib's 3D axes would sort every collection by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from flatnet.export.drawn_layout import DrawnPiece
from flatnet.geometry.triangles import edges_of
from flatnet.parameters import STROKES
from flatnet.pattern.labels import Label, fitting_label, line_breaks
from flatnet.report.build_files import BuildFiles, BuiltPatch
from flatnet.report.summary import sheet_size
from flatnet.report.view import FROM_THE_FRONT, Camera, Surface, cameras

Floats = NDArray[np.float64]

POINT = 1.0 / 72.0  # inches

#: Flattenability from 0 to this is shown from blue to red, rad: the scale of the paper's figures.
RED = 0.02
COLOURS = LinearSegmentedColormap.from_list(
    "flattenability", ["#2a52be", "#2f9ad6", "#7fd0b0", "#f2e266", "#f4902c", "#c8102e"]
)
#: Distances from the reference surface, from inside to outside.
DISTANCES = LinearSegmentedColormap.from_list("distance", ["#b2182b", "#f4a582", "#f7f7f7", "#92c5de", "#2166ac"])
OUTSIDE, INSIDE = np.array([0.95, 0.95, 0.93]), np.array([0.86, 0.58, 0.44])
INK = np.array([0.10, 0.12, 0.20])
NORMAL, RIGHT_NORMAL = np.array([0.80, 0.15, 0.12]), np.array([0.10, 0.50, 0.25])
#: Colour that the farthest parts of the network approach.
HAZE = np.array([0.86, 0.88, 0.91])
#: Length of a normal's arrow over the extent of the network.
ARROW = 0.045
#: Defects of a hide, and the rim of its quality zones.
DEFECT, ZONE = "#8a8a8a", "#cc8800"
#: Points of a piece's name, the first that fits.
NAME_SIZES = (10.0, 9.0, 8.0, 7.0, 6.0, 5.0)


@dataclass(frozen=True, eq=False)
class Panel:
    """One drawing of the sheet.

    Attributes
    ----------
    low, high : (2,) float, mm; the corners of what it shows.
    paint : draws it into axes, given their scale in points per mm.
    y_down : as on a page, not as on a graph.
    """

    caption: str
    low: Floats
    high: Floats
    paint: Callable[[Axes, float], None]
    y_down: bool = False

    @property
    def aspect(self) -> float:
        """Width over height."""
        width, height = self.high - self.low
        return float(width / height)


def panels_of(build: BuildFiles) -> list[Panel]:
    """All panels of a build; those seen from the same direction have the same scale and place."""
    curves, layouts = build.network["curves"], build.report["layouts"]
    if not build.patches:
        drawn = [network_panel(curves, FROM_THE_FRONT)] if curves else []
        return [*drawn, *(layout_panel(build, record) for record in layouts)]
    warped = Surface.of([patch.warped for patch in build.patches])
    fitted = Surface.of([patch.mesh for patch in build.patches], [patch.flat for patch in build.patches])
    limit = max((record.get("metrics") or {}).get("strain_limit", 0.0) for record in build.report["patches"])
    first, second = cameras(fitted)
    alike = [
        network_panel(curves, first),
        flattenability_panel(f"warped, M⁰: worst {warped.flattenability.max():.1g} rad", warped, first),
        flattenability_panel(f"fitted, M: worst {fitted.flattenability.max():.0e} rad", fitted, first),
        *([strain_panel(limit, fitted, first)] if limit else []),
        shaded_panel("fitted, the inside brown", fitted, first),
    ]
    low = np.min([panel.low for panel in alike], axis=0)
    high = np.max([panel.high for panel in alike], axis=0)
    heights = [patch.heights[patch.mesh.triangles] for patch in build.patches if patch.heights is not None]
    if len(heights) == len(build.patches):
        alike.append(distance_panel(np.concatenate(heights), fitted, first))
    return [
        *(replace(panel, low=low, high=high) for panel in alike),
        shaded_panel("from another side", fitted, second),
        *(layout_panel(build, record) for record in layouts),
    ]


def network_panel(curves: Sequence[dict[str, Any]], camera: Camera) -> Panel:
    """The curves in space and an arrow for the normal of every edge, the farther the paler."""
    edges_of_curve = [np.stack([curve["vertices"][:-1], curve["vertices"][1:]], axis=1) for curve in curves]
    sides = [
        (edges.mean(axis=1), np.array(curve[key]), np.tile(ink, (len(edges), 1)))
        for key, ink in (("normals", NORMAL), ("right_normals", RIGHT_NORMAL))
        for curve, edges in zip(curves, edges_of_curve, strict=True)
        if key in curve  # right normals only at creases
    ]
    feet, normals, inks = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    edges = np.concatenate(edges_of_curve)
    seen, tails = camera.project(edges), camera.project(feet)
    arrows = ARROW * float(np.ptp(edges, axis=(0, 1)).max()) * camera.project(normals)

    def paint(axes: Axes, _: float) -> None:
        nearness = seen[..., 2].mean(axis=1)
        order = np.argsort(nearness, kind="stable")
        colours = _hazy(nearness, np.tile(INK, (len(seen), 1)))
        lines = list(seen[order, :, :2])
        axes.add_collection(LineCollection(lines, colors=colours[order], linewidths=1.4, capstyle="round"))
        order = np.argsort(tails[:, 2], kind="stable")
        axes.quiver(
            *tails[order, :2].T, *arrows[order, :2].T,
            color=_hazy(tails[:, 2], inks)[order], angles="xy", scale_units="xy", scale=1.0, units="dots",
            width=1.0, headwidth=4.5, headlength=5.5, headaxislength=5.0, minlength=0.0, zorder=3,
        )  # fmt: skip
        _scale_bar(axes)

    tips = (tails + arrows)[:, :2]
    return Panel("curves and edge normals", *_box(np.concatenate([*seen[..., :2], tips])), paint)


def _hazy(nearness: Floats, inks: Floats) -> Floats:
    """Every ink mixed with haze, the more the farther away, (k, 3)."""
    depth = (nearness.max() - nearness) / max(float(np.ptp(nearness)), 1e-12)
    part = 0.8 * depth[:, None]
    return (1.0 - part) * inks + part * HAZE


def _scale_bar(axes: Axes) -> None:
    """A bar of 1, 2 or 5 times a power of ten mm in the lower left corner, at most 0.4 of the width."""
    (left, right), bottom = axes.get_xlim(), axes.get_ylim()[0]
    most = 0.4 * (right - left)
    power = 10.0 ** np.floor(np.log10(most))
    length = power * max(step for step in (1.0, 2.0, 5.0) if step * power <= most)
    axes.plot([left, left + length], [bottom, bottom], color="#555555", linewidth=1.5, clip_on=False)
    axes.annotate(
        f"{length:g} mm", (left, bottom), (0, -3), textcoords="offset points",
        va="top", fontsize=7, color="#555555",
    )  # fmt: skip


def flattenability_panel(caption: str, surface: Surface, camera: Camera) -> Panel:
    """Triangles in the colour of their worst corner, lightly shaded."""
    return _coloured_panel(caption, surface.flattenability / RED, surface, camera)


def strain_panel(limit: float, surface: Surface, camera: Camera) -> Panel:
    """Triangles in the colour of their most strained edge, red at the limit."""
    caption = f"strained by {100.0 * surface.strain.max():.1f} % of {100.0 * limit:g} %"
    return _coloured_panel(caption, surface.strain / limit, surface, camera)


def _coloured_panel(caption: str, parts: Floats, surface: Surface, camera: Camera) -> Panel:
    """Triangles coloured from blue at 0 to red at 1 and above, (t,)."""
    brightness, _ = surface.light(camera)
    colours = COLOURS(Normalize(0.0, 1.0)(parts))[:, :3]
    colours = colours * (0.6 + 0.4 * brightness[:, None])
    # Strokes in the triangles' own colours close the hairlines between them.
    return _surface_panel(caption, surface, camera, colours, colours, 0.5)


def distance_panel(heights: Floats, surface: Surface, camera: Camera) -> Panel:
    """Triangles by the distance of their corners, (t, 3) mm, from the reference surface: red inside, blue outside."""
    brightness, _ = surface.light(camera)
    most = max(float(np.abs(heights).max()), 1e-9)
    colours = DISTANCES(Normalize(-most, most)(heights.mean(axis=1)))[:, :3] * (0.6 + 0.4 * brightness[:, None])
    caption = f"off the surface: {-heights.min():.1f} mm inside (red) to {heights.max():.1f} mm outside (blue)"
    return _surface_panel(caption, surface, camera, colours, colours, 0.5)


def shaded_panel(caption: str, surface: Surface, camera: Camera) -> Panel:
    """Triangles and their edges, the outside light grey, the inside brown."""
    brightness, outside = surface.light(camera)
    colours = np.where(outside[:, None], OUTSIDE, INSIDE) * brightness[:, None]
    return _surface_panel(caption, surface, camera, colours, 0.8 * colours, 0.25)


def _surface_panel(
    caption: str, surface: Surface, camera: Camera, faces: Floats, edges: Floats, edge_points: float
) -> Panel:
    """Triangles and their edges in colours of their own, (t, 3) each, the patches' boundaries in ink."""
    corners, order = surface.back_to_front(camera)
    ink = np.tile(INK, (len(surface.boundaries), 1))
    faces, edges = np.concatenate([faces, ink])[order], np.concatenate([edges, ink])[order]
    widths = np.repeat([edge_points, 0.7], [len(surface.corners), len(ink)])[order]

    def paint(axes: Axes, _: float) -> None:
        axes.add_collection(
            PolyCollection(
                list(corners[order]), facecolors=faces, edgecolors=edges, linewidths=widths, joinstyle="round"
            )
        )

    return Panel(caption, *_box(corners.reshape(-1, 2)), paint)


def layout_panel(build: BuildFiles, record: Mapping[str, Any]) -> Panel:
    """A sheet as its SVG shows it, every piece with its flat mesh and its name."""
    pieces = build.sheets[record["file"]]
    patches = {patch.name: patch for patch in build.patches}
    hide = record.get("hide")
    length, width = sheet_size(record)
    space = "\u00a0"  # where a caption is not to be broken
    size, used = f"{round(width, 1):g} × {length:.0f} mm", f"{100.0 * record['utilisation']:.0f} % used"
    caption = f"{record['material']}: {size.replace(' ', space)}, {used.replace(' ', space)}"
    if record["draft"]:
        caption += " (draft: not nested)"

    def paint(axes: Axes, scale: float) -> None:
        outline = hide["outline"] if hide else [[0, 0], [length, 0], [length, width], [0, width]]
        grounds = [(outline, "#f4f1ea", "#999999")]
        if hide:
            grounds += [(ring, "none", ZONE) for _, ring in hide["zones"]]
            grounds += [(ring, DEFECT, "#333333") for ring in hide["defects"]]
        for ring, fill, edge in grounds:
            drawn = np.array([0.0, width]) + np.array(ring) * (1.0, -1.0)
            axes.add_collection(PolyCollection([drawn], facecolors=fill, edgecolors=edge, clip_on=False))
        cut, sew, notch, nick, internal, grain = (
            [line for piece in pieces for line in piece.lines.get(kind, [])]
            for kind in ("cut", "sew", "notch", "nick", "internal", "grain")
        )
        mesh = [
            edge for piece in pieces if piece.patch in patches for edge in _flat_edges(piece, patches[piece.patch])
        ]
        axes.add_collection(
            PolyCollection(cut, facecolors="white", edgecolors=STROKES["cut"], linewidths=0.8)
        )
        axes.add_collection(LineCollection(mesh, colors="#c4cad6", linewidths=0.2, zorder=1))
        axes.add_collection(
            PolyCollection(sew, facecolors="none", edgecolors=STROKES["sew"], linewidths=0.6)
        )
        axes.add_collection(LineCollection(notch, colors=STROKES["notch"], linewidths=0.6))
        axes.add_collection(LineCollection(nick, colors=STROKES["nick"], linewidths=0.6))
        axes.add_collection(LineCollection(internal, colors=STROKES["internal"], linewidths=0.5))
        axes.add_collection(LineCollection(grain, colors=STROKES["grain"], linewidths=0.7))
        halo = [withStroke(linewidth=1.5, foreground="white")]
        for piece in pieces:
            name = _name(piece, scale)
            x, y = name.position / scale
            text = "\n".join(name.lines)
            angle = 0.0 if name.direction[0] else 90.0
            axes.text(
                x, y, text, fontsize=name.height, ha="center", va="center", rotation=angle, path_effects=halo
            )

    return Panel(caption, np.zeros(2), np.array([length, width]), paint, y_down=True)


def _flat_edges(piece: DrawnPiece, patch: BuiltPatch) -> Floats:
    return piece.place(patch.flat)[edges_of(patch.mesh.triangles)]


def _name(piece: DrawnPiece, scale: float) -> Label:
    """The patch's name as large as it fits beside the grain arrow; lengths in points."""
    inside = shapely.Polygon(piece.lines["sew"][0] * scale)
    grain = shapely.MultiLineString([line * scale for line in piece.lines.get("grain", [])])
    texts = line_breaks(f"{piece.patch}{' (mirrored)' * piece.mirrored}")
    free = inside.difference(grain.buffer(1.5))
    # A piece may be as narrow as its arrow is drawn.
    return fitting_label(texts, inside if free.is_empty else free, NAME_SIZES)


def _box(points: Floats) -> tuple[Floats, Floats]:
    """The corners of a box round points (k, 2), a little larger, so that no stroke is cut off."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.01 * float((high - low).max())
    return low - margin, high + margin
