"""The project file: its model and its loader."""

from flatnet.project.loader import load_project
from flatnet.project.model import (
    CurveSpec,
    FormSurface,
    Mark,
    Material,
    MeshSurface,
    NodeSpec,
    NormalList,
    NormalSpec,
    OpeningSpec,
    PatchSpec,
    Problem,
    Project,
    ProjectError,
    SignedCurve,
)

__all__ = [
    "CurveSpec",
    "FormSurface",
    "Mark",
    "Material",
    "MeshSurface",
    "NodeSpec",
    "NormalList",
    "NormalSpec",
    "OpeningSpec",
    "PatchSpec",
    "Problem",
    "Project",
    "ProjectError",
    "SignedCurve",
    "load_project",
]
