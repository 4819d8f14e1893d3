"""Readers of what a build writes, of the tests' own: they know the formats, not the program."""

import json
from pathlib import Path

import numpy as np
from svgelements import SVG, Group
from svgelements import Path as SvgPath

#: svgelements takes 0.0393701 inches for a mm: what it reads is too long by this factor.
READER_SCALE = 25.4 * 0.0393701


def read_obj(path: Path):
    """Vertices (m, 3), flat coordinates (m, 2), triangles (t, 3) of an OBJ whose faces say `f v/vt`, v = vt."""
    vertices, flat, triangles = [], [], []
    for line in path.read_text().splitlines():
        kind, *words = line.split()
        if kind == "v":
            vertices.append([float(word) for word in words])
        elif kind == "vt":
            flat.append([float(word) for word in words])
        elif kind == "f":
            pairs = [word.split("/") for word in words]
            assert all(v == vt for v, vt in pairs)
            triangles.append([int(v) - 1 for v, _ in pairs])
    return np.array(vertices), np.array(flat), np.array(triangles)


def angle_sums(vertices, triangles):
    """Angle sum at every vertex by the law of cosines in extended precision, no formula of the program's."""
    sums = np.zeros(len(vertices), dtype=np.longdouble)
    points = vertices.astype(np.longdouble)[triangles]
    for k in range(3):
        u = points[:, (k + 1) % 3] - points[:, k]
        v = points[:, (k + 2) % 3] - points[:, k]
        cosine = (u * v).sum(axis=1) / np.sqrt((u * u).sum(axis=1) * (v * v).sum(axis=1))
        np.add.at(sums, triangles[:, k], np.arccos(cosine))
    return sums


def boundary_vertices(triangles):
    """Vertices on edges that only one triangle has."""
    edges = {}
    for a, b, c in triangles:
        for edge in ((a, b), (b, c), (c, a)):
            key = tuple(sorted(edge))
            edges[key] = edges.get(key, 0) + 1
    return sorted({v for edge, count in edges.items() if count == 1 for v in edge})


def edges(triangles):
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(pairs, axis=0)


def lengths(points, pairs):
    return np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)


def read_report(out: Path):
    return json.loads((out / "report.json").read_text())


def sewn_outlines(svg_file: Path):
    """(patch, copy) -> (k, 2) vertices of the sew line where the drawing shows them, mm, y down."""
    svg = SVG.parse(str(svg_file), ppi=25.4)
    outlines = {}
    for group in svg.elements():
        if not (isinstance(group, Group) and group.values.get("class") == "piece"):
            continue
        (path,) = [e for e in group.select() if isinstance(e, SvgPath) and e.values.get("class") == "sew"]
        path = path * path.transform if not path.transform.is_identity() else path
        key = group.values["data-patch"], int(group.values["data-copy"])
        outlines[key] = np.array([[s.end.x, s.end.y] for s in path][:-1]) / READER_SCALE
    return outlines
