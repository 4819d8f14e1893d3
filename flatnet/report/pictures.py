"""Draw a build as one picture, from its written files to a PNG: network, warped and fitted patches, layouts.

Needs matplotlib. Meshes are projected and sorted here, all patches together, and drawn as plain polygons:
matplotlib's own 3D axes sort every collection by itself.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from flatnet.export.drawn_layout import DrawnPiece
from flatnet.export.svg import STROKES
from flatnet.geometry.triangles import edges_of
from flatnet.pattern.labels import Label, name_label
from flatnet.report.build_files import BuildFiles, BuildFilesError, read_build
from flatnet.report.view import Camera, Surface, cameras

try:
    from matplotlib import style
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.figure import Figure
except ImportError as error:
    raise BuildFilesError(
        f"pictures need matplotlib ({error}); install it with: pip install flatnet[pictures]"
    ) from None

Floats = NDArray[np.float64]

WIDTH = 14.0  # inches
RESOLUTION = 150  # dots per inch
#: Height over width that the sheet should have; the rows are broken to come near it.
PROPORTION = 0.62
TALLEST_ROW, GAP, MARGIN, HEAD, CAPTION = 7.5, 0.25, 0.25, 0.7, 0.5  # inches
POINT = 1.0 / 72.0  # inches

#: Flattenability from 0 to this is shown from blue to red, rad: the paper's scale.
RED = 0.02
COLOURS = LinearSegmentedColormap.from_list(
    "flattenability", ["#2a52be", "#2f9ad6", "#7fd0b0", "#f2e266", "#f4902c", "#c8102e"]
)
OUTSIDE, INSIDE = np.array([0.93, 0.93, 0.91]), np.array([0.80, 0.55, 0.42])
INK, FADED = np.array([0.10, 0.12, 0.20]), np.array([0.80, 0.82, 0.86])
NORMAL, OTHER_NORMAL = np.array([0.82, 0.20, 0.16]), np.array([0.10, 0.50, 0.25])


@dataclass(frozen=True, eq=False)
class Panel:
    """One drawing of the sheet.

    Attributes
    ----------
    low, high : (2,) float, mm; the corners of what it shows.
    paint : draws it into axes whose scale is given in points per mm.
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


def draw(folder: Path, picture: Path | None = None) -> Path:
    """Draw the build in a folder; the PNG is written to `picture`, beside the folder where none is given.

    Raises
    ------
    BuildFilesError
        The folder holds no whole build, or the picture can't be written.
    """
    build = read_build(folder)
    if picture is None:
        folder = folder.resolve()
        picture = folder.with_name(f"{folder.name}.png")
    with style.context("default"):
        figure = _figure(build)
        try:
            figure.savefig(picture, dpi=RESOLUTION, format="png")
        except OSError as error:
            raise BuildFilesError(f"{picture}: can't be written: {error.strerror}") from None
    return picture


def _figure(build: BuildFiles) -> Figure:
    panels = _panels(build)
    rows = _rows([panel.aspect for panel in panels])
    height = 2.0 * MARGIN + HEAD + sum(row_height + CAPTION for _, row_height in rows) + GAP * (len(rows) - 1)
    figure = Figure(figsize=(WIDTH, height), dpi=RESOLUTION, facecolor="white")
    FigureCanvasAgg(figure)
    _head(figure, build, height)
    top, remaining = MARGIN + HEAD, iter(panels)
    for count, row_height in rows:
        left = MARGIN
        for _ in range(count):
            panel = next(remaining)
            width = panel.aspect * row_height
            _add(figure, panel, left, height - top - CAPTION - row_height, width, row_height)
            left += width + GAP
        top += row_height + CAPTION + GAP
    return figure


def _rows(aspects: Sequence[float]) -> list[tuple[int, float]]:
    """Break panels into rows that fill the sheet's width: how many stand in each, and its height in inches."""
    best: tuple[float, list[tuple[int, float]]] | None = None
    for wanted in np.linspace(1.0, TALLEST_ROW, 66):
        rows = _filled(aspects, float(wanted))
        heights = np.array([height for _, height in rows])
        total = heights.sum() + CAPTION * len(rows)
        badness = abs(np.log(total / (PROPORTION * WIDTH))) + np.abs(np.log(heights / heights.mean())).mean()
        if best is None or badness < best[0] - 1e-9:
            best = float(badness), rows
    assert best is not None
    return best[1]


def _filled(aspects: Sequence[float], wanted: float) -> list[tuple[int, float]]:
    """Rows filled one after the other until the next panel, `wanted` inches high, would pass the edge."""
    groups: list[list[float]] = [[]]
    for aspect in aspects:
        if groups[-1] and _row_height([*groups[-1], aspect]) < wanted:
            groups.append([])
        groups[-1].append(aspect)
    return [(len(group), min(_row_height(group), TALLEST_ROW)) for group in groups]


def _row_height(aspects: Sequence[float]) -> float:
    return (WIDTH - 2.0 * MARGIN - GAP * (len(aspects) - 1)) / sum(aspects)


def _add(figure: Figure, panel: Panel, left: float, bottom: float, width: float, height: float) -> None:
    page = figure.get_size_inches()
    axes = figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))
    axes.set_axis_off()
    axes.set_xlim(panel.low[0], panel.high[0])
    axes.set_ylim(*((panel.high[1], panel.low[1]) if panel.y_down else (panel.low[1], panel.high[1])))
    panel.paint(axes, width / float(panel.high[0] - panel.low[0]) / POINT)
    letters = int(width / (9.0 * 0.55 * POINT))
    caption = textwrap.fill(panel.caption, max(letters, 12))
    figure.text(left / page[0], (bottom + height + 0.08) / page[1], caption, fontsize=9, va="bottom", linespacing=1.15)


def _head(figure: Figure, build: BuildFiles, height: float) -> None:
    """Title, what failed, and the colour bar."""
    records = build.report["patches"]
    failed = [record["name"] for record in records if record["status"] != "ok"]
    vertices = sum(len(patch.mesh.vertices) for patch in build.patches)
    figures = f"{len(records)} patches · {vertices:,} vertices"
    if build.patches:
        worst = max(patch.mesh.max_flattenability for patch in build.patches)
        figures += f" · worst flattenability {worst:.0e} rad"
    left, top = MARGIN / WIDTH, 1.0 - MARGIN / height
    figure.text(left, top, build.report["project"], fontsize=17, weight="bold", va="top")
    figure.text(left, top - 0.34 / height, figures, fontsize=11, va="top", color="#444444")
    if failed:
        text = textwrap.shorten(f"FAILED: {', '.join(failed)}", 110, placeholder=" ...")
        figure.text(left, top - 0.55 / height, text, fontsize=9, va="top", color="#b00020", weight="bold")
    bar = figure.add_axes((1.0 - (MARGIN + 3.2) / WIDTH, top - 0.2 / height, 3.0 / WIDTH, 0.14 / height))
    colours = figure.colorbar(
        ScalarMappable(Normalize(0.0, RED), COLOURS), cax=bar, orientation="horizontal", extend="max",
        extendfrac=0.03, ticks=[0.0, 0.005, 0.01, 0.015, 0.02],
    )
    colours.ax.tick_params(labelsize=8, length=2)
    colours.outline.set_linewidth(0.4)  # type: ignore[operator]
    figure.text(1.0 - (MARGIN + 3.3) / WIDTH, top - 0.13 / height, "flattenability |θ − 2π|, rad",
                fontsize=9, ha="right", va="center")


def _panels(build: BuildFiles) -> list[Panel]:
    curves = build.network["curves"]
    points = np.concatenate([np.array(curve["vertices"]) for curve in curves])
    panels = []
    if build.patches:
        warped = Surface.of([patch.warped for patch in build.patches])
        fitted = Surface.of([patch.mesh for patch in build.patches])
        first, second = cameras(fitted)
        panels = [
            _coloured(f"warped onto the curves: worst {warped.flattenability.max():.1g} rad", warped, first),
            _coloured(f"fitted: worst {fitted.flattenability.max():.0e} rad", fitted, first),
            _shaded("fitted", fitted, first),
            _shaded("fitted, from another side", fitted, second),
        ]
    else:
        first = Camera(50.0, 12.0)
    network = _network("curves and their edge normals", curves, first, 0.03 * float(np.ptp(points, axis=0).max()))
    return [network, *panels, *(_layout(build, record) for record in build.report["layouts"])]


def _network(caption: str, curves: Sequence[dict[str, Any]], camera: Camera, arrow: float) -> Panel:
    """Curves and an arrow of `arrow` mm at every edge, the farther the paler."""
    edges = np.concatenate([np.stack([c["vertices"][:-1], c["vertices"][1:]], axis=1) for c in curves])
    feet = edges.mean(axis=1)
    normals = np.concatenate([np.array(c["normals"]) for c in curves])
    crease = np.concatenate([np.full(len(c["normals"]), "right_normals" in c) for c in curves])
    others = np.concatenate([np.array(c["right_normals"]) for c in curves if "right_normals" in c] or [np.empty((0, 3))])
    feet, heads = np.concatenate([feet, feet[crease]]), np.concatenate([normals, others])
    inks = np.where(np.arange(len(feet))[:, None] < len(edges), NORMAL, OTHER_NORMAL)
    seen, tails = camera.project(edges), camera.project(feet)
    tips = tails + arrow * camera.project(heads)

    def paint(axes: Axes, scale: float) -> None:
        order = np.argsort(seen[..., 2].mean(axis=1), kind="stable")
        axes.add_collection(LineCollection(
            list(seen[order, :, :2]), colors=_faded(seen[..., 2].mean(axis=1), INK)[order], linewidths=1.2, capstyle="round",
        ))
        order = np.argsort(tails[:, 2], kind="stable")
        x, y, _ = tails[order].T
        u, v, _ = (tips - tails)[order].T
        axes.quiver(
            x, y, u, v, color=_faded(tails[:, 2], inks)[order], angles="xy", scale_units="xy", scale=1.0,
            units="dots", width=0.9, headwidth=4.0, headlength=5.0, headaxislength=4.5, minlength=0.0, zorder=3,
        )

    drawn = np.concatenate([seen[..., :2].reshape(-1, 2), tips[:, :2]])
    return Panel(caption, *_padded(drawn), paint)


def _faded(nearness: Floats, ink: Floats) -> Floats:
    """A colour for each place, `ink` where it is nearest and paler the farther it is, (k, 3)."""
    depth = (nearness.max() - nearness) / max(float(np.ptp(nearness)), 1e-12)
    part = 0.85 * depth[:, None]
    return (1.0 - part) * ink + part * FADED


def _coloured(caption: str, surface: Surface, camera: Camera) -> Panel:
    brightness, _ = surface.light(camera)
    colours = COLOURS(Normalize(0.0, RED)(surface.flattenability))[:, :3]
    return _surface(caption, surface, camera, colours * (0.6 + 0.4 * brightness[:, None]), None)


def _shaded(caption: str, surface: Surface, camera: Camera) -> Panel:
    brightness, outside = surface.light(camera)
    colours = np.where(outside[:, None], OUTSIDE, INSIDE) * brightness[:, None]
    return _surface(caption, surface, camera, colours, 0.75 * colours)


def _surface(caption: str, surface: Surface, camera: Camera, colours: Floats, edges: Floats | None) -> Panel:
    """Triangles in their colours, with or without their edges, and the boundaries of the patches in ink."""
    corners, order = surface.back_to_front(camera)
    boundary = np.tile(INK, (len(surface.boundaries), 1))
    widths = np.repeat([0.25, 0.7], [len(colours), len(boundary)])

    def paint(axes: Axes, scale: float) -> None:
        axes.add_collection(PolyCollection(
            corners[order],
            facecolors=np.concatenate([colours, boundary])[order],
            edgecolors=np.concatenate([colours if edges is None else edges, boundary])[order],
            linewidths=widths[order],
            joinstyle="round",
        ))

    return Panel(caption, *_padded(corners.reshape(-1, 2)), paint)


def _layout(build: BuildFiles, record: dict[str, Any]) -> Panel:
    """A sheet as its SVG shows it, every piece with its flat mesh and its name."""
    pieces = build.sheets[record["file"]]
    patches = {patch.name: patch for patch in build.patches}
    length, width = record["used_length_mm"], record["sheet_width_mm"]
    caption = f"{record['material']}: {width:g} × {length:.0f} mm, {100.0 * record['utilisation']:.0f} % used"
    if record["draft"]:
        caption += " (draft: plain rows)"

    def paint(axes: Axes, scale: float) -> None:
        axes.add_collection(PolyCollection(
            [np.array([[0, 0], [length, 0], [length, width], [0, width]])], facecolors="#f7f5f0", edgecolors="#999999",
            linewidths=0.8, clip_on=False,
        ))
        for kind, stroke in (("cut", 0.8), ("mesh", 0.2), ("sew", 0.5), ("grain", 0.6)):
            lines: list[Floats] = []
            for piece in pieces:
                if kind == "mesh":
                    mesh = patches[piece.patch]
                    lines += list(piece.place(mesh.flat)[edges_of(mesh.mesh.triangles)])
                else:
                    lines += piece.lines.get(kind, [])
            if kind == "cut":
                axes.add_collection(PolyCollection(lines, facecolors="white", edgecolors=STROKES["cut"], linewidths=stroke))
            else:
                if kind == "sew":
                    lines = [np.vstack([line, line[:1]]) for line in lines]
                axes.add_collection(LineCollection(lines, colors=STROKES.get(kind, "#c4c9d4"), linewidths=stroke))
        for piece in pieces:
            label = _name(piece, scale)
            axes.text(*label.position / scale, "\n".join(label.lines), fontsize=label.height, ha="center", va="center")

    return Panel(caption, np.zeros(2), np.array([length, width]), paint, y_down=True)


def _name(piece: DrawnPiece, scale: float) -> Label:
    """The patch's name inside its piece in letters as large as fit, broken at `_`; in points of the picture."""
    words = piece.patch.replace("_", "_ ").split()
    if piece.mirrored:
        words.append("(mirrored)")
    inside = Polygon(piece.lines["sew"][0] * scale)
    letters = sorted({len("".join(words[i:j])) for i in range(len(words)) for j in range(i + 1, len(words) + 1)})
    lines = [textwrap.wrap(" ".join(words), width) for width in letters]
    return max((name_label(text, inside) for text in lines), key=lambda label: label.height)


def _padded(points: Floats) -> tuple[Floats, Floats]:
    """The corners of a box around points, a little larger than needed, so that no stroke is cut off."""
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.01 * float((high - low).max()) + 1e-9
    return low - pad, high + pad
