"""Reference surfaces: a parametric form from its measurements, or a user's mesh."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from flatnet.forms.mannequin import mannequin
from flatnet.forms.measurements import MeasurementError
from flatnet.forms.mesh_file import MeshFileError, read_mesh
from flatnet.forms.shoe_last import shoe_last
from flatnet.forms.surface import ReferenceSurface
from flatnet.project.model import FormSurface, MeshSurface, Project
from flatnet.project.problems import Problem, ProjectError
from flatnet.project.values import nearest

__all__ = ["FORMS", "ReferenceSurface", "make_surface"]

#: Name in the project file -> the form made from measurements in mm; raises `MeasurementError`.
FORMS: dict[str, Callable[[Mapping[str, float | str]], ReferenceSurface]] = {
    "mannequin": mannequin,
    "shoe_last": shoe_last,
}


def make_surface(project: Project) -> ReferenceSurface | None:
    """The reference surface that the project names; None where it names none.

    Raises
    ------
    ProjectError
        No such form, no such measurement, measurements that no body has, a mesh file that is no surface.
    """
    source = project.surface
    if source is None:
        return None
    try:
        return read_mesh(source) if isinstance(source, MeshSurface) else _make_form(source)
    except MeasurementError as error:
        messages = error.messages
    except MeshFileError as error:
        messages = [str(error)]
    raise ProjectError(project.file, [Problem(source.mark, f"surface: {message}") for message in messages])


def _make_form(source: FormSurface) -> ReferenceSurface:
    if source.form not in FORMS:
        raise MeasurementError([f"unknown form {source.form!r}; {nearest(source.form, FORMS, 'forms')}"])
    return FORMS[source.form](source.measurements)
