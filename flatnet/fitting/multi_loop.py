"""Algorithm 1 of the paper, as printed: M^0 to a flattenable Laplacian mesh (paper 4, Eq. 5-10)."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags, identity, kron

from flatnet.fitting.results import FlattenableMesh, PlanarMesh, WarpedMesh
from flatnet.geometry.angle_sums import AngleSums
from flatnet.geometry.triangles import edge_lengths, edges_of
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import MultiLoopParameters
from flatnet.solvers.kkt import KktStatus, kkt_step

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
MERIT="c"; NUMODE="mono"
LOG=[]

def multi_loop(
    warped: WarpedMesh, boundary: BoundaryCurve, planar: PlanarMesh, parameters: MultiLoopParameters
) -> FlattenableMesh:
    n, m = warped.boundary_count, len(warped.vertices)
    edges = edges_of(warped.triangles)
    unit = float(edge_lengths(planar.positions, edges_of(planar.triangles)).mean())
    vertices = warped.vertices / unit
    free = np.arange(n, m)
    sums = AngleSums(warped.triangles, free, m)
    i, j = np.concatenate([edges, edges[:, ::-1]]).T
    adjacency = coo_matrix((np.ones(len(i)), (i, j)), shape=(m, m)).tocsr()
    valence = np.asarray(adjacency.sum(axis=1)).ravel()
    laplacian = (identity(m) - diags(1 / valence) @ adjacency).tocsr()[n:]
    # tan
    tri = warped.triangles
    pts, nrm = {}, {}
    key = {}
    for t in tri:
        for k in range(3):
            key[(t[k], t[(k + 1) % 3])] = t[(k + 2) % 3]
    P = np.zeros((m, 3)); N = np.zeros((m, 3)); C = np.zeros(m)
    bv = boundary.vertices / unit
    for e in range(n):
        p = key[(e, (e + 1) % n)]
        if p >= n:
            P[p] += 0.5 * (bv[e] + bv[(e + 1) % n]); N[p] += boundary.normals[e]; C[p] += 1
    tan = np.flatnonzero(C)
    point = P[tan] / C[tan][:, None]; normal = N[tan] / np.linalg.norm(N[tan], axis=1)[:, None]
    def project(x):
        return x - np.einsum('ij,ij->i', x - point, normal)[:, None] * normal
    w1, w2, w3 = parameters.w1, parameters.w2, parameters.w3
    istan = np.zeros(m - n); istan[tan - n] = 1
    H = kron(w1 * laplacian[:, n:] + diags(w2 + w3 * istan), identity(3)).tocsr()
    D = valence[n:]
    x = vertices.copy()
    steps = 0; status = "outer loop limit"
    nu = 0.0
    for outer in range(parameters.max_outer_loops):
        if NUMODE=="outer": nu = 0.0
        x0 = x[n:].copy(); xp = project(x[tan])
        def grad(x):
            g = w1 * (laplacian @ x) + w2 * (x[n:] - x0)
            g[tan - n] += w3 * (x[tan] - xp)
            return g
        def energy(x):
            d = x[edges[:, 0]] - x[edges[:, 1]]
            return 0.5 * w1 * (d**2).sum() + 0.5 * w2 * (D[:, None] * (x[n:] - x0)**2).sum() + 0.5 * w3 * (D[tan - n][:, None] * (x[tan] - xp)**2).sum()
        for inner in range(parameters.inner_steps):
            c = sums.values(x); J = sums.jacobian(x)[:, 3 * n:]
            g = grad(x)
            k = kkt_step(H, J, g.ravel(), c)
            d = k.step.reshape(-1, 3); steps += 1
            if MERIT == "c":
                def merit(x): return 0.5 * (sums.values(x)**2).sum()
                slope = -(c @ c)
            else:
                slope_e = (D[:, None] * g * d).sum()
                nu = max(nu if NUMODE!="fresh" else 0.0, 2 * np.abs(D*k.multipliers).max(), 2 * slope_e / max(np.abs(c).sum(), 1e-30) if slope_e > 0 else 0)
                def merit(x): return energy(x) + nu * np.abs(sums.values(x)).sum()
                slope = slope_e - nu * np.abs(c).sum()
            m0 = merit(x); f = 1.0
            while f > 1e-6:
                y = x.copy(); y[n:] += f * d
                if merit(y) <= m0 + 1e-4 * f * slope: break
                f *= 0.5
            LOG.append((np.abs(c).max(), np.linalg.norm(d), f, k.status.value))
            if f > 1e-6: x = y
            if np.linalg.norm(d) < parameters.step_tolerance: break
        if np.abs(sums.values(x)).max() < parameters.tolerance:
            status = "converged"; break
    return FlattenableMesh(x * unit, warped.triangles, n, "multi_loop", asdict(parameters), status, steps)
