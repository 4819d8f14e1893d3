"""Write the assembled model, every fitted mesh in its place, as one OBJ, PLY or GLB."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.export.missing_library import needs
from flatnet.export.obj import obj_lines
from flatnet.export.written_build import FittedMesh, WrittenBuild
from flatnet.geometry.chains import boundary_edges
from flatnet.geometry.triangles import angle_defects, vertex_normals

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

#: A vertex that is off flattenable by this or more, rad, is red; one at 0 is blue.
RED = 0.02
_SCALE = np.array([[0, 0, 255], [0, 255, 255], [0, 255, 0], [255, 255, 0], [255, 0, 0]], float)
#: GLB is in metres with y up: from our mm with z up.
TO_Y_UP = 1e-3 * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def write_model_obj(path: Path, build: WrittenBuild) -> None:
    """One object for each patch; `v` in mm, `vt` its flat coordinates in mm, 17 significant digits."""
    lines = ["# mm; vt: flat coordinates in mm, of each object in its piece's frame"]
    first = 1
    for mesh in build.meshes:
        lines += [f"o {mesh.patch}", *obj_lines(mesh.vertices, mesh.triangles, mesh.flat, first)]
        first += len(mesh.vertices)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_model_ply(path: Path, build: WrittenBuild) -> None:
    """All patches as one mesh in mm, coloured by flattenability; properties s, t: flat coordinates, in mm too."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in build.meshes)])
    model = trimesh.Trimesh(
        np.concatenate([mesh.vertices for mesh in build.meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(build.meshes, starts)]),
        vertex_colors=np.concatenate([_colours(mesh) for mesh in build.meshes]),
        process=False,
    )
    flat = np.concatenate([mesh.flat for mesh in build.meshes])
    model.vertex_attributes.update(s=flat[:, 0], t=flat[:, 1])
    path.write_bytes(trimesh.exchange.ply.export_ply(model, vertex_normal=False))


def write_model_glb(path: Path, build: WrittenBuild) -> None:
    """A node for each patch, coloured by flattenability; its morph target `flat` lays it out as on its sheet.

    Metres, float32, y up; the sheets lie side by side on the floor.
    """
    gltf = needs("pygltflib", "GLB")
    writer = _GlbWriter(gltf)
    spread = _spread(build)
    for mesh in build.meshes:
        laid = spread.get(mesh.patch, mesh.flat)
        writer.add(mesh, np.column_stack([laid, np.zeros(len(laid))]))
    writer.save(path)


def _spread(build: WrittenBuild) -> Mapping[str, Floats]:
    """Flat coordinates of every patch with a plain copy, where the first of them lies on its sheet."""
    flat = {mesh.patch: mesh.flat for mesh in build.meshes}
    spread: dict[str, Floats] = {}
    start = 0.0
    for sheet in build.sheets:
        for placement in sheet.layout.placements:
            name = placement.piece.name
            if not placement.mirrored and name not in spread:
                spread[name] = placement.place(flat[name]) + (start, 0.0)
        start += sheet.layout.size[0]
    return spread


def _colours(mesh: FittedMesh) -> Bytes:
    """(m, 4), from blue to red by the distance from flattenable; the boundary, which need not be, is blue."""
    off = np.abs(angle_defects(mesh.vertices, mesh.triangles))
    off[np.unique(boundary_edges(mesh.triangles))] = 0.0
    part = np.minimum(off / RED, 1.0) * (len(_SCALE) - 1)
    channels = [np.interp(part, np.arange(len(_SCALE)), _SCALE[:, k]) for k in range(3)]
    return np.rint(np.column_stack([*channels, np.full(len(off), 255.0)])).astype(np.uint8)


class _GlbWriter:
    """A GLB being written: arrays one after the other in one buffer, each seen through an accessor."""

    def __init__(self, gltf: Any) -> None:
        self.gltf = gltf
        asset = gltf.Asset(version="2.0", generator="flatnet")
        self.file = gltf.GLTF2(asset=asset, scene=0, scenes=[gltf.Scene(nodes=[])])
        matte = gltf.PbrMetallicRoughness(metallicFactor=0.0, roughnessFactor=0.8)
        self.file.materials = [gltf.Material(doubleSided=True, pbrMetallicRoughness=matte)]
        self.data = b""

    def add(self, mesh: FittedMesh, laid: Floats) -> None:
        """A node for one patch.

        Parameters
        ----------
        laid : (m, 3) mm, z up; where the morph target has its vertices.
        """
        gltf = self.gltf
        places = (mesh.vertices @ TO_Y_UP.T).astype(np.float32)
        moved = (laid @ TO_Y_UP.T - places).astype(np.float32)
        normals = (vertex_normals(mesh.vertices, mesh.triangles) @ (1e3 * TO_Y_UP).T).astype(np.float32)
        attributes = gltf.Attributes(
            POSITION=self._accessor(places, "VEC3", gltf.FLOAT, bounds=True),
            NORMAL=self._accessor(normals, "VEC3", gltf.FLOAT),
            COLOR_0=self._accessor(_colours(mesh), "VEC4", gltf.UNSIGNED_BYTE, normalized=True),
        )
        primitive = gltf.Primitive(
            attributes=attributes,
            indices=self._accessor(mesh.triangles.astype(np.uint32).ravel(), "SCALAR", gltf.UNSIGNED_INT),
            material=0,
            targets=[{"POSITION": self._accessor(moved, "VEC3", gltf.FLOAT, bounds=True)}],
        )
        self.file.nodes.append(gltf.Node(name=mesh.patch, mesh=len(self.file.meshes)))
        self.file.meshes.append(
            gltf.Mesh(name=mesh.patch, primitives=[primitive], weights=[0.0], extras={"targetNames": ["flat"]})
        )
        self.file.scenes[0].nodes.append(len(self.file.nodes) - 1)

    def _accessor(
        self, values: NDArray[Any], kind: str, component: int, bounds: bool = False, normalized: bool = False
    ) -> int:
        gltf = self.gltf
        target = gltf.ELEMENT_ARRAY_BUFFER if kind == "SCALAR" else gltf.ARRAY_BUFFER
        view = gltf.BufferView(buffer=0, byteOffset=len(self.data), byteLength=values.nbytes, target=target)
        self.data += values.tobytes()  # all are of four bytes, so that each begins at a multiple of four
        self.file.bufferViews.append(view)
        accessor = gltf.Accessor(
            bufferView=len(self.file.bufferViews) - 1,
            componentType=component,
            count=len(values),
            type=kind,
            normalized=normalized,
        )
        if bounds:
            accessor.min, accessor.max = values.min(axis=0).tolist(), values.max(axis=0).tolist()
        self.file.accessors.append(accessor)
        return len(self.file.accessors) - 1

    def save(self, path: Path) -> None:
        """Write the file."""
        self.file.buffers = [self.gltf.Buffer(byteLength=len(self.data))]
        self.file.set_binary_blob(self.data)
        self.file.save_binary(str(path))
