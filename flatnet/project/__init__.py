"""The project file: its model and its loader."""

from flatnet.project.curve_specs import CurveSpec, NodeSpec, NormalList, NormalSpec
from flatnet.project.loader import load_project
from flatnet.project.model import FormSurface, Material, MeshSurface, Project
from flatnet.project.patch_specs import AlsoSpec, OpeningSpec, PatchSpec, SignedCurve
from flatnet.project.problems import Mark, Problem, ProjectError
from flatnet.project.seam_specs import DartSpec, Ends, NickSpec, NotchSpec, SeamSpec, SewnTo

__all__ = [
    "AlsoSpec",
    "CurveSpec",
    "DartSpec",
    "Ends",
    "FormSurface",
    "Mark",
    "Material",
    "MeshSurface",
    "NickSpec",
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
    "SewnTo",
    "SignedCurve",
    "load_project",
]
