"""List the faces of a network for a person to choose from: as `around`, and whether each can be a patch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from flatnet.forms.surface import ReferenceSurface
from flatnet.network.assembly import trace_network
from flatnet.network.boundaries import make_patch
from flatnet.network.faces import FaceMatcher, match_faces
from flatnet.network.graph import Dart
from flatnet.network.network import SampledStretch
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters
from flatnet.project.model import Project
from flatnet.project.patch_specs import PatchSpec
from flatnet.project.problems import Mark

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ListedFace:
    """One loop of the network.

    Attributes
    ----------
    name : of the patch or opening that it is, else `face_1`, `face_2` ...
    kind : `patch`, `opening`, or "" where the project lists it nowhere.
    around : as it is written in a project file.
    outline : (n, 3) float, mm; closed, anticlockwise seen against the normals.
    fault : why no patch can be made of it, in words; "" where one can.
    """

    name: str
    kind: str
    around: str
    outline: Floats
    fault: str

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.roll(self.outline, -1, axis=0) - self.outline, axis=1).sum())


@dataclass(frozen=True, eq=False)
class FaceList:
    """The faces of a network in the order of its curves, the curves, and how many parts hang together."""

    faces: tuple[ListedFace, ...]
    stretches: Mapping[str, SampledStretch]
    parts: int


def list_faces(project: Project, surface: ReferenceSurface | None) -> FaceList:
    """All faces of a project's network, whether it lists them or not.

    Raises
    ------
    ProjectError
        As `make_network`, but for what is wrong with patches and openings.
    """
    _, stretches, traced = trace_network(project, surface)
    matched, _ = match_faces(project, stretches, traced)
    owners = {
        frozenset(loop): (name, kind)
        for kind, found in (("patch", matched.patches), ("opening", matched.openings))
        for name, loops in found.items()
        for loop in loops
    }
    matcher = FaceMatcher(stretches, traced.faces)
    free = (name for name in (f"face_{i}" for i in count(1)) if name not in {*project.patches, *project.openings})
    faces = []
    for face in traced.faces:
        name, kind = owners.get(frozenset(face.darts)) or (next(free), "")
        outline = np.concatenate([_run(stretches[dart.stretch], dart)[:-1] for dart in face.darts])
        fault = _fault(project, name, face.darts, stretches)
        faces.append(ListedFace(name, kind, matcher.shortest_around(face.darts), outline, fault))
    return FaceList(tuple(faces), stretches, len(traced.euler_characteristics))


def _run(stretch: SampledStretch, dart: Dart) -> Floats:
    return stretch.vertices[::-1] if dart.reversed else stretch.vertices


def _fault(project: Project, name: str, darts: tuple[Dart, ...], stretches: Mapping[str, SampledStretch]) -> str:
    if not all(stretches[dart.stretch].left_normals.any() for dart in darts):
        return "it has curves without normals"
    material = next(iter(project.materials))
    spec = PatchSpec(name, (), material, 1, 0, None, project.edge_length, {}, FairParameters(), Mark(0, 0))
    made, problems = make_patch(spec, [darts], stretches, project.curves)
    if isinstance(made, Patch):
        return ""
    message = problems[0].message if made is None else made.message
    return message.split(":")[0].rstrip(".")  # what, without its figures
