"""Coarse to fine and on fresh tessellations: the shape found on the coarse mesh stays as fair on the fine one."""

import numpy as np
from benchmark.boundaries import case

from flatnet.fitting.fair import fit_fair
from flatnet.fitting.levels import fit_in_levels
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.remesh import carried_over, flat_boundary, placed_on
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.unfold import unfold
from flatnet.fitting.warp import warp
from flatnet.geometry.triangles import bending
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters


def test_a_smooth_sheet_stays_smooth_on_a_finer_mesh():
    """Bending of a smooth sheet does not depend on the mesh; crumples took it from 55 at 570 vertices to 80."""
    boundary, edge_length = case("saddle", 180)
    planar_boundary = fit_planar_boundary(boundary)
    planar = tessellate(planar_boundary, edge_length)
    assert 1200 < len(planar.positions) < 1600
    patch = Patch("saddle", boundary, edge_length, "sheet")
    mesh = fit_in_levels(warp(planar, boundary), planar, planar_boundary, patch, FairParameters())
    assert mesh.status == "converged"
    assert bending(mesh.vertices, mesh.triangles) <= 60.0


def test_a_carried_sheet_keeps_its_boundary_and_place_and_loses_the_bends_at_the_facets():
    boundary, edge_length = case("cylinder", 60)
    planar_boundary = fit_planar_boundary(boundary)
    planar = tessellate(planar_boundary, edge_length)
    coarse = fit_fair(warp(planar, boundary), boundary, planar, FairParameters())
    flat = unfold(coarse)
    finer = tessellate(flat_boundary(flat, planar_boundary), 0.4 * edge_length)
    placed, carried = placed_on(coarse, flat, finer), carried_over(coarse, flat, finer, normal_weight=1.0)
    assert np.array_equal(carried.vertices[: finer.boundary_count], boundary.vertices)
    # A facet of edge L on a surface of curvature k lies k L^2 / 8 off it; here k is at most 16 * 0.15 / 100 mm.
    off = np.linalg.norm(carried.vertices - placed, axis=1).max()
    assert off <= (16.0 * 0.15 / 100.0) * (2.0 * edge_length) ** 2 / 8.0
    bent = bending(coarse.vertices, coarse.triangles)
    assert bending(placed, finer.triangles) >= 1.5 * bent
    assert bending(carried.vertices, finer.triangles) <= 1.05 * bent
