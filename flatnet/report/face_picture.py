"""The picture of a network's faces: from two sides, each face in a colour of its own, with names."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from flatnet.network.listing import FaceList, ListedFace
from flatnet.network.network import SampledStretch
from flatnet.report.panels import INK, POINT
from flatnet.report.summary import counted
from flatnet.report.view import Camera, Surface, cameras

Floats = NDArray[np.float64]

RESOLUTION = 150  # dots per inch
WIDTH, HEIGHT, HEAD = 14.0, 8.0, 0.4  # inches
#: Turn of the hue from one face to the next: the golden ratio's, so that neighbours in the list differ.
HUE = 0.618034
LARGEST_NAME, SMALLEST_NAME = 9.0, 4.5  # points


def face_picture(listed: FaceList) -> bytes:
    """A PNG; the same faces give the same one whatever matplotlib's settings are."""
    surface = Surface(
        corners=np.concatenate([np.zeros((0, 3, 3)), *(_fan(face.outline) for face in listed.faces if not face.fault)]),
        boundaries=np.concatenate([np.stack([s.vertices[:-1], s.vertices[1:]], 1) for s in listed.stretches.values()]),
        flattenability=np.zeros(0),
        strain=np.zeros(0),
    )
    front = cameras(surface)[0] if len(surface.corners) else Camera(-65.0, 50.0)
    back = replace(front, azimuth=front.azimuth + 180.0)
    content = BytesIO()
    with style.context("default"):
        figure = Figure(figsize=(WIDTH, HEIGHT), facecolor="white")
        for left, camera, title in ((0.0, front, "front"), (0.5, back, "back")):
            axes = figure.add_axes((left + 0.01, 0.01, 0.48, 1.0 - HEAD / HEIGHT))
            axes.set_axis_off()
            axes.set_aspect("equal")
            axes.set_title(f"{title}: {counted(len(listed.faces), 'face')}, openings grey", fontsize=9)
            _paint(axes, listed, surface, camera)
        figure.savefig(content, dpi=RESOLUTION, format="png")
    return content.getvalue()


def _fan(outline: Floats) -> Floats:
    """Triangles from the middle of an outline to its edges, (n, 3, 3)."""
    middle = np.broadcast_to(outline.mean(axis=0), outline.shape)
    return np.stack([middle, outline, np.roll(outline, -1, axis=0)], axis=1)


def _paint(axes: Axes, listed: FaceList, surface: Surface, camera: Camera) -> None:
    corners, order = surface.back_to_front(camera)
    made = [face for face in listed.faces if not face.fault]
    colours = [hsv_to_rgb((HUE * k % 1.0, 0.28, 1.0)) for k in range(len(made))]
    fills = [colour for face, colour in zip(made, colours) for _ in face.outline]
    brightness = surface.light(camera)[0] if len(made) else np.ones(0)
    ink = np.tile(INK, (len(surface.boundaries), 1))
    paint = np.concatenate([np.reshape(fills, (-1, 3)) * (0.4 + 0.6 * brightness[:, None]), ink])[order]
    widths = np.concatenate([np.full(len(fills), 0.4), np.full(len(ink), 1.0)])[order]
    axes.add_collection(PolyCollection(list(corners[order]), facecolors=paint, edgecolors=paint, linewidths=widths))
    low, high = corners.reshape(-1, 2).min(axis=0), corners.reshape(-1, 2).max(axis=0)
    margin = 0.03 * float((high - low).max())
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    scale = min(0.48 * WIDTH, HEIGHT - HEAD) / float((high - low).max() + 2.0 * margin) / POINT
    for stretch in listed.stretches.values():
        _name_curve(axes, stretch, camera)
    for face in listed.faces:
        _name_face(axes, face, camera, scale)


def _name_face(axes: Axes, face: ListedFace, camera: Camera, scale: float) -> None:
    """In the middle of the faces that are seen from their outside, as large as they leave room for."""
    seen = camera.project(face.outline)
    if not _faces_viewer(seen):
        return
    x, y = seen[:, :2].mean(axis=0)
    room = float(np.ptp(seen[:, :2], axis=0).min()) * scale
    size = float(np.clip(1.5 * room / len(face.name), SMALLEST_NAME, LARGEST_NAME))
    colour, halo = ("#777777" if face.fault else "black"), [withStroke(linewidth=1.5, foreground="white")]
    axes.text(x, y, face.name, fontsize=size, color=colour, weight="bold", ha="center", va="center", path_effects=halo)


def _faces_viewer(seen: Floats) -> bool:
    x, y = seen[:, 0] - seen[0, 0], seen[:, 1] - seen[0, 1]
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) > 0.0


def _name_curve(axes: Axes, stretch: SampledStretch, camera: Camera) -> None:
    """Beside the middle edge of the curves whose normals there point at the viewer."""
    k = len(stretch.left_normals) // 2
    if camera.project(stretch.left_normals[k])[2] <= 0.0:
        return
    x, y, _ = camera.project(0.5 * (stretch.vertices[k] + stretch.vertices[k + 1]))
    halo = [withStroke(linewidth=1.0, foreground="white")]
    axes.text(x, y, stretch.name, fontsize=SMALLEST_NAME, color="#8a1c1c", ha="center", va="center", path_effects=halo)
