"""Unit normals of the edges of sampled curves: given per point, per segment, for all, or from the surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.triangles import dot, unit
from flatnet.network.curves import ControlPolygon, CurveSamples, StretchSamples
from flatnet.network.network import GeometryError
from flatnet.project.curve_specs import CurveSpec, NormalList

Floats = NDArray[np.float64]

#: A unit normal whose part orthogonal to its edge is shorter than this points along the edge.
ALONG_EDGE = 1e-3


def surface_normals(
    stretches: Sequence[StretchSamples], surface: ReferenceSurface | None
) -> dict[StretchSamples, Floats]:
    """The surface's normals at the middles of the stretches' edges, (k, 3) each; one query, which has its price."""
    if not stretches:
        return {}
    assert surface is not None, "a project that takes normals from a surface has one"
    middles = [0.5 * (stretch.vertices[:-1] + stretch.vertices[1:]) for stretch in stretches]
    _, normals = surface.nearest(np.concatenate(middles))
    return dict(zip(stretches, np.split(normals, np.cumsum([len(each) for each in middles])[:-1]), strict=True))


def stretch_normals(
    curve: CurveSpec, samples: CurveSamples, stretch: StretchSamples, of_surface: Mapping[StretchSamples, Floats]
) -> tuple[Floats, Floats]:
    """Left and right normals of a stretch's edges, both (k, 3), unit, orthogonal to the edges.

    They are one array off creases, and zero where the curve has no normals or takes them from the curves
    (`tangents`), which only the whole network can give.

    Parameters
    ----------
    of_surface : `surface_normals` of the stretches that take theirs from there.

    Raises
    ------
    GeometryError
        A normal points along its edge or vanishes between two opposed ones.
    """
    spec = curve.normals
    vertices = stretch.vertices
    if spec.source in ("none", "curves"):
        none = np.zeros((len(vertices) - 1, 3))
        return none, none
    if spec.source == "surface":
        normals = _orthogonal(curve, stretch, of_surface[stretch])
        return normals, normals
    assert spec.left is not None and spec.right is not None, "given normals are given on both sides"
    middles = 0.5 * (stretch.arclengths[:-1] + stretch.arclengths[1:])
    left = _orthogonal(curve, stretch, _given(spec.left, samples, middles))
    right = _orthogonal(curve, stretch, _given(spec.right, samples, middles)) if spec.crease else left
    return left, right


def _given(normals: NormalList, samples: CurveSamples, middles: Floats) -> Floats:
    """Given normals at arclengths: interpolated between points, constant along segments; at most 1 long."""
    values = normals.values
    if normals.per == "curve":
        return np.broadcast_to(values[0], (len(middles), 3))
    arcs = samples.control_arclengths
    values = _from_control_start(values, samples.control)
    if normals.per == "segment":
        segment = np.searchsorted(arcs, middles, side="right") - 1
        return np.array(values[np.clip(segment, 0, len(arcs) - 2)])
    return np.stack([np.interp(middles, arcs, column) for column in values.T], axis=1)


def _from_control_start(values: Floats, control: ControlPolygon) -> Floats:
    """A list's values from the control polygon's start on; round a closed curve to the first value again."""
    if not control.closed:
        return values
    segments = len(control.positions) - 1
    if len(values) > segments:  # one for `from` and one for `to`, the same node
        return values
    values = np.roll(values, -control.shift, axis=0)
    return np.vstack([values, values[:1]])


def _orthogonal(curve: CurveSpec, stretch: StretchSamples, normals: Floats) -> Floats:
    """Normals, at most 1 long, made orthogonal to their edges and scaled to unit length."""
    vertices = stretch.vertices
    edges = unit(np.diff(vertices, axis=0))
    across = normals - dot(normals, edges)[:, None] * edges
    length = np.linalg.norm(across, axis=1, keepdims=True)
    bad = np.flatnonzero(length[:, 0] < ALONG_EDGE)
    if len(bad):
        at = stretch.arclengths[bad[0] : bad[0] + 2].mean()
        raise GeometryError(
            curve.normals.mark or curve.mark,
            f"curve '{curve.name}': the normal at {at:.1f} mm along it points along the curve or vanishes "
            f"between opposed ones ({len(bad)} of {len(edges)} edges); give normals that stand off the curve",
        )
    return across / length
