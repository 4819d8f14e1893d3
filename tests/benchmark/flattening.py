"""The other way to a pattern on the same boundaries: the smooth surface M^0, flattened by LSCM and ARAP."""

from __future__ import annotations

from typing import Any

import numpy as np

from flatnet.fitting.results import WarpedMesh
from flatnet.geometry.triangles import edge_lengths, edge_strain, edges_of
from tests.benchmark.boundaries import CASES, HOOKED
from tests.benchmark.fits import fit, initial_meshes, sized_case
from tests.benchmark.run import Options

VERTICES = 650
ARAP_STEPS = 200


def run(options: Options) -> dict[str, Any]:
    try:
        import igl  # noqa: F401
    except ModuleNotFoundError:
        options.say("skipped: needs libigl: pip install flatnet[bench]")
        return {"skipped": "libigl is not installed"}
    records = [compared(name) for name in CASES | HOOKED]
    columns = ["case", "V"]
    for method in ("LSCM", "ARAP", "ours"):
        columns += [f"{method}: seam %", "mean %", "strain %"]
    options.table(
        "A smooth surface flattened, and ours: worst and mean error of a boundary edge, worst strain of any edge",
        columns,
        [
            [r["name"], r["vertices"], *(v for m in ("lscm", "arap", "ours") for v in percents(r[m]))]
            for r in records
        ],
    )
    return {"fits": records}


def percents(errors: dict[str, float] | None) -> list[float | None]:
    keys = ("seam_worst", "seam_mean", "strain_worst")
    return [100.0 * errors[key] if errors else None for key in keys]


def compared(name: str) -> dict[str, Any]:
    boundary, edge_length = sized_case(name, VERTICES)
    _, warped = initial_meshes(boundary, edge_length)
    conformal = lscm(warped)
    one = fit(name, boundary, edge_length)
    ours = None
    if one.fitted is not None:
        mesh = one.fitted.mesh
        ours = errors(mesh.vertices, one.fitted.flat, mesh.triangles, mesh.boundary_count)
    flattened = {"lscm": conformal, "arap": arap(warped, conformal)}
    theirs = {
        method: errors(warped.vertices, flat, warped.triangles, warped.boundary_count)
        for method, flat in flattened.items()
    }
    return {"name": name, "vertices": len(warped.vertices), "ours": ours, **theirs}


def lscm(mesh: WarpedMesh) -> np.ndarray:
    """Least-squares conformal map by libigl, in the size that keeps the length of all edges together."""
    import igl

    rim = mesh.vertices[: mesh.boundary_count]
    far = int(np.argmax(np.linalg.norm(rim - rim[0], axis=1)))
    held = np.array([[0.0, 0.0], [float(np.linalg.norm(rim[far] - rim[0])), 0.0]])
    flat, _ = igl.lscm(mesh.vertices, mesh.triangles, np.array([0, far]), held)
    edges = edges_of(mesh.triangles)
    return flat * (edge_lengths(mesh.vertices, edges).sum() / edge_lengths(flat, edges).sum())


def arap(mesh: WarpedMesh, start: np.ndarray) -> np.ndarray:
    """As-rigid-as-possible map by libigl, from a flat start."""
    import igl

    data = igl.ARAPData()
    data.max_iter = ARAP_STEPS
    igl.arap_precomputation(mesh.vertices, mesh.triangles, 2, np.zeros(1, dtype=np.int32), data)
    return igl.arap_solve(start[:1].copy(), data, start.copy())


def errors(vertices: np.ndarray, flat: np.ndarray, triangles: np.ndarray, boundary_count: int) -> dict[str, float]:
    """Of the boundary edges and of all, |flat length / length - 1|."""
    ends = np.arange(boundary_count)
    rim = np.stack([ends, np.roll(ends, -1)], axis=1)
    seam = np.abs(edge_lengths(flat, rim) / edge_lengths(vertices, rim) - 1.0)
    strain = np.abs(edge_strain(vertices, flat, triangles))
    return {
        "seam_worst": float(seam.max()),
        "seam_mean": float(seam.mean()),
        "strain_worst": float(strain.max()),
        "strain_mean": float(strain.mean()),
    }
