"""The project file: its model and its loader."""

from flatnet.project.loader import load_project
from flatnet.project.model import (
    CurveSpec,
    Ends,
    FormSurface,
    Mark,
    Material,
    MeshSurface,
    NodeSpec,
    NormalList,
    NormalSpec,
    NotchSpec,
    OpeningSpec,
    PatchSpec,
    Problem,
    Project,
    ProjectError,
    SeamSpec,
    SignedCurve,
)

__all__ = [
    "CurveSpec",
    "Ends",
    "FormSurface",
    "Mark",
    "Material",
    "MeshSurface",
    "NodeSpec",
    "NormalList",
    "NormalSpec",
    "NotchSpec",
    "OpeningSpec",
    "PatchSpec",
    "Problem",
    "Project",
    "ProjectError",
    "SeamSpec",
    "SignedCurve",
    "load_project",
]
