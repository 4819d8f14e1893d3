"""Tiles cover all that is printed, leave out the rest, and their glue marks fall on each other."""

import numpy as np
import pytest
import shapely

from flatnet.export.pdf import PAPERS, glue_marks
from flatnet.export.tiles import Paper, tile_sheet

A4 = PAPERS["a4"]


def windows(tiling):
    return {tile.name: shapely.box(*tile.corner, *(tile.corner + tiling.paper.window)) for tile in tiling.tiles}


def test_pages_without_a_piece_are_left_out():
    size = np.array([700.0, 900.0])
    pieces = [shapely.box(0, 850, 60, 900), shapely.box(650, 0, 700, 60)]
    tiling = tile_sheet(size, pieces, A4)
    assert [tile.name for tile in tiling.tiles] == ["A1", "D4"]  # at the top left and the bottom right, y up
    assert all(any(window.covers(piece) for window in windows(tiling).values()) for piece in pieces)
    assert not any(any(tile.neighbours) for tile in tiling.tiles)


def test_neighbours_overlap_by_what_the_paper_says():
    sheet = shapely.box(0, 0, 500, 600)
    tiling = tile_sheet(np.array([500.0, 600.0]), [sheet], A4)
    printed = windows(tiling)
    assert shapely.union_all(list(printed.values())).covers(sheet)
    overlap = printed["A1"].intersection(printed["B1"]).bounds
    assert overlap[2] - overlap[0] == pytest.approx(A4.overlap)
    overlap = printed["A1"].intersection(printed["A2"]).bounds
    assert overlap[3] - overlap[1] == pytest.approx(A4.overlap)


def test_glue_marks_of_neighbours_fall_on_each_other():
    tiling = tile_sheet(np.array([500.0, 600.0]), [shapely.box(0, 0, 500, 600)], A4)
    marks = {}
    for tile in tiling.tiles:
        crosses = (line.points.mean(axis=0) - A4.margin + tile.corner for line in glue_marks(tile, tiling.paper))
        marks[tile.name] = {tuple(cross.round(6)) for cross in crosses}
    assert (tiling.columns, tiling.rows) == (2, 4)
    assert len(marks["A1"]) == 4 and len(marks["B2"]) == 6  # two at each edge with a neighbour
    for one, other in (("A1", "B1"), ("A1", "A2"), ("B1", "B2")):
        assert len(marks[one] & marks[other]) == 2


def test_the_paper_is_turned_where_that_saves_pages():
    wide = tile_sheet(np.array([270.0, 180.0]), [shapely.box(0, 0, 270, 180)], A4)
    assert (wide.paper.width, wide.paper.height, len(wide.tiles)) == (297.0, 210.0, 1)


def test_columns_beyond_z_have_two_letters():
    paper = Paper("strip", 30.0, 30.0, margin=0.0, overlap=5.0)
    names = [tile.name for tile in tile_sheet(np.array([700.0, 20.0]), [shapely.box(0, 0, 700, 20)], paper).tiles]
    assert names[:2] == ["A1", "B1"] and names[25:28] == ["Z1", "AA1", "AB1"]
