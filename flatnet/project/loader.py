"""A project file -> `Project`: read, checked against docs/project-file.md, lengths in mm."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, cast

import numpy as np
import yaml

from flatnet.parameters import EXPORT_FORMATS, STROKES, FairParameters, Limits, NestingParameters
from flatnet.project.curves import CurveSetting, read_curves
from flatnet.project.faces import FaceSetting, face_problems, read_openings, read_patches
from flatnet.project.hides import read_hides
from flatnet.project.imports import read_imports
from flatnet.project.mirror import curve_image, image_problems, node_image, patch_image, read_mirror, take_images
from flatnet.project.model import PLAIN_NUMBERS, FormSurface, Material, MeshSurface, Project
from flatnet.project.nodes import cut_at_fractions, read_nodes
from flatnet.project.parameters import parameter_names, read_fitting, read_parameters
from flatnet.project.patch_specs import PatchSpec
from flatnet.project.problems import Problem, ProjectError
from flatnet.project.section import Section
from flatnet.project.sewing import notch_problems, sewn_problems
from flatnet.project.values import (
    WrongValueError,
    between,
    colour,
    integer,
    length_in,
    name,
    number,
    one_of,
    scalar,
    title,
    unit,
    wrong,
)
from flatnet.project.yaml_nodes import compose, describe, is_number, mark_of, read_text, tree_problems

_FORMAT = 1
_TOP_KEYS = (
    "flatnet",
    "name",
    "size",
    "units",
    "edge_length",
    "chord_tolerance",
    "surface",
    "import",
    "mirror",
    "nodes",
    "curves",
    "join",
    "patches",
    "openings",
    "rest",
    "materials",
    "fitting",
    "nesting",
    "limits",
    "strokes",
    "exports",
)
_MESH_KEYS = ("mesh", "units", "up", "outer", "clearance")
_MESH_FILES = (".obj", ".stl", ".ply")
_MATERIAL_KEYS = ("width", "length", "sheets", "hides", "rotations", "gap", "allowance", "strain", "thickness")
_MOST_SHEETS = 1000
#: Rotations by the kind of material: with a grain, with a grain that has a direction, without.
_ROTATIONS: dict[str, tuple[float, ...] | None] = {"woven": (0.0, 180.0), "nap": (0.0,), "free": None}
#: The most that `strain` may be: beyond it edge lengths say little about cloth.
_MOST_STRAIN = 0.2
#: Stands in where a file names no material.
_DEFAULT_MATERIAL = Material("default", width=1500.0)
#: chord_tolerance where the file says none, in edge lengths.
_CHORD_TOLERANCE = 1.0 / 50.0
#: clearance of a surface where the file says none, in edge lengths.
_CLEARANCE = 0.5


def load_project(path: str | Path) -> Project:
    """Read and check a project file.

    Raises
    ------
    ProjectError
        With every problem of the file that it shows without its geometry.
    """
    file = Path(path)
    return parse_project(file, read_text(file))


def parse_project(file: Path, text: str) -> Project:
    """Read and check the text of a project file that stands, or is to stand, at `file`.

    Raises
    ------
    ProjectError
        As `load_project`.
    """
    root = compose(file, text)
    problems = tree_problems(root)
    top = Section(root, "", mark_of(root), _TOP_KEYS, problems)
    hint = f"the version of the format; write 'flatnet: {_FORMAT}'"
    version = top.require("flatnet", integer, _FORMAT, hint)
    if version != _FORMAT:
        message = f"flatnet: this program reads version {_FORMAT} of the format, got {version}"
        raise ProjectError(file, [Problem(mark_of(top.values["flatnet"]), message)])
    project = _project(file, top)
    if problems:
        raise ProjectError(file, problems)
    return project


def load_materials(path: str | Path) -> dict[str, Material]:
    """Read and check a file that has materials alone (`units`, `materials`), as in a project file.

    Raises
    ------
    ProjectError
        With every problem of the file.
    """
    file = Path(path)
    root = compose(file, read_text(file))
    problems = tree_problems(root)
    top = Section(root, "", mark_of(root), ("units", "materials"), problems)
    materials = _materials(file, top.section("materials", None), top.get("units", unit, 1.0))
    if "materials" not in top.values:
        top.problem(top.mark, "'materials' is missing")
    if problems:
        raise ProjectError(file, problems)
    return materials


def _project(file: Path, top: Section) -> Project:
    mm_per_unit = top.get("units", unit, 1.0)
    size = length_in(mm_per_unit, positive=True)
    edge_length = top.require("edge_length", size, np.nan, "the target length of mesh edges")
    has_surface = "surface" in top.values
    already = len(top.problems)
    imports = read_imports(file, top, mm_per_unit, edge_length, has_surface)
    if len(top.problems) > already:  # every curve of it would be missed, one by one
        raise ProjectError(file, top.problems)
    mirror = read_mirror(top, mm_per_unit)
    node_sections = top.section("nodes", None)
    node_images = take_images(node_sections, mirror, "node", imports.nodes)
    across = node_images.both_ways()
    nodes = node_images.added(read_nodes(node_sections, mm_per_unit, has_surface, imports.nodes), mirror, node_image)
    curve_setting = CurveSetting(file, mm_per_unit, has_surface, edge_length, nodes)
    curve_sections = top.section("curves", None)
    curve_images = take_images(curve_sections, mirror, "curve", imports.curves)
    curves, problems = cut_at_fractions(nodes, read_curves(curve_sections, curve_setting, imports.curves))
    curves_across = curve_images.both_ways()
    curves = curve_images.added(curves, mirror, lambda spec, plane: curve_image(spec, plane, across, curves_across))
    top.problems += problems + image_problems(nodes, curves) + sewn_problems(curves)
    joins_crossings = top.get("join", one_of("crossings"), "") == "crossings"
    top.problems += [] if joins_crossings else notch_problems(curves)  # crossings have names of their own
    if not curves and curve_sections.is_mapping:
        top.problem(curve_sections.mark, "there are no curves, and without them nothing to make")
    already = len(top.problems)
    materials = _materials(file, top.section("materials", None), mm_per_unit)
    materials_are_good = len(top.problems) == already
    fitting = read_fitting(top, FairParameters())
    face_setting = FaceSetting(mm_per_unit, edge_length, curves, tuple(materials), fitting, joins_crossings)
    patch_sections = top.section("patches", None)
    patch_images = take_images(patch_sections, mirror, "patch", ())
    patches = patch_images.added(
        read_patches(patch_sections, face_setting),
        mirror,
        lambda spec, plane: patch_image(spec, plane, curves_across, across),
    )
    top.problems += _zone_problems(patches, materials) if materials_are_good else []
    openings = read_openings(top.section("openings", None), curves, joins_crossings)
    rest_is_open = top.get("rest", one_of("openings"), "") == "openings"
    if rest_is_open and not patches:
        top.problem(top.keys["rest"], "rest: openings, and no patches: nothing is left to make")
    top.problems += face_problems(patches, openings, curves, joins_crossings)
    return Project(
        file=file,
        name=top.require("name", title, ""),
        mm_per_unit=mm_per_unit,
        edge_length=edge_length,
        chord_tolerance=top.get("chord_tolerance", size, edge_length * _CHORD_TOLERANCE),
        surface=_surface(file, top, mm_per_unit, edge_length) if has_surface else None,
        findings=imports.findings,
        nodes=nodes,
        curves=curves,
        patches=patches,
        openings=openings,
        rest_is_open=rest_is_open,
        materials=materials,
        size=top.get("size", title, ""),
        nesting=read_parameters(top.section("nesting", parameter_names(NestingParameters)), NestingParameters()),
        limits=read_parameters(top.section("limits", parameter_names(Limits)), Limits()),
        joins_crossings=joins_crossings,
        mirror=mirror,
        strokes=_strokes(top.section("strokes", STROKES)),
        exports=_exports(top),
    )


def _zone_problems(patches: Mapping[str, PatchSpec], materials: Mapping[str, Material]) -> list[Problem]:
    """Patches that ask for a zone which no hide of their material has."""
    problems = []
    for patch in patches.values():
        material = materials.get(patch.material)  # one that there is not is named already
        if patch.zone and material and patch.zone not in material.zones:
            message = f"patch {patch.name!r}: no hide of material {patch.material!r} has a zone {patch.zone!r}"
            problems.append(Problem(patch.mark, message))
    return problems


def _strokes(section: Section) -> dict[str, str]:
    return {key: section.get(key, colour, usual) for key, usual in STROKES.items()}


def _exports(top: Section) -> tuple[str, ...]:
    if "exports" not in top.values:
        return ()
    items = top.items("exports", top.values["exports"], "a list of formats, such as [pdf-a4, dxf-astm]")
    formats = (top.read(label, item, one_of(*EXPORT_FORMATS), "") for label, item in items)
    return tuple(dict.fromkeys(formats))


def _surface(
    file: Path, top: Section, mm_per_unit: float, edge_length: float
) -> FormSurface | MeshSurface | None:
    node, mark = top.values["surface"], mark_of(top.keys["surface"])
    section = Section(node, "surface", mark, None, top.problems)
    clearance = section.get("clearance", length_in(mm_per_unit, negative=False), edge_length * _CLEARANCE)
    if "form" in section.values and "mesh" in section.values:
        section.problem(mark, "'form' and 'mesh' exclude each other; keep one")
    elif "form" in section.values:
        return _form(section, mm_per_unit, clearance)
    elif "mesh" in section.values:
        section = Section(node, "surface", mark, _MESH_KEYS, top.problems)
        return MeshSurface(
            path=section.get("mesh", lambda path: _mesh_file(file, path), Path()),
            mm_per_unit=section.get("units", unit, mm_per_unit),
            up=cast(Literal["x", "y", "z"], section.get("up", one_of("x", "y", "z"), "z")),
            outer=cast(
                Literal["outside", "inside"], section.get("outer", one_of("outside", "inside"), "outside")
            ),
            mark=mark,
            clearance=clearance,
        )
    elif section.is_mapping:
        section.problem(mark, "needs 'form: <name>' or 'mesh: <file>'")
    return None


def _form(section: Section, mm_per_unit: float, clearance: float) -> FormSurface:
    length = length_in(mm_per_unit)

    def measurement(node: yaml.Node) -> float | str:
        if is_number(node):
            return length(node)
        text = scalar("a length or a word")(node)
        if not text.isidentifier():
            raise wrong(node, "a length or a word")
        return text

    placeholder: float | str = 0.0
    return FormSurface(
        form=section.get("form", name, ""),
        measurements={
            key: section.get(key, number if key in PLAIN_NUMBERS else measurement, placeholder)
            for key in section.values
            if key not in ("form", "clearance")
        },
        mark=section.mark,
        clearance=clearance,
    )


def _mesh_file(file: Path, node: yaml.Node) -> Path:
    path = file.parent / scalar("the path of a mesh file")(node)
    if path.suffix.lower() not in _MESH_FILES:
        raise WrongValueError(node, f"expected a mesh file ({', '.join(_MESH_FILES)}), got {describe(node)}")
    if not os.path.isfile(path):  # unlike Path.is_file it takes any text without raising
        raise WrongValueError(node, f"there is no file {str(path)!r}; a path is relative to the project file")
    return path


def _materials(file: Path, sections: Section, mm_per_unit: float) -> dict[str, Material]:
    positive = length_in(mm_per_unit, positive=True)
    not_negative = length_in(mm_per_unit, negative=False)
    materials = {}
    for key, mark, node in sections.named():
        section = Section(node, f"material {key!r}", mark, _MATERIAL_KEYS, sections.problems)
        hides = read_hides(file, section, mm_per_unit)
        if "hides" in section.values:
            for other in [each for each in ("width", "length", "sheets") if each in section.values]:
                section.problem(section.keys[other], f"'hides' and {other!r} exclude each other; keep one")
            length: float | None = max((hide.size[0] for hide in hides), default=1.0)
            width = max((hide.size[1] for hide in hides), default=1.0)
        else:
            length = section.get("length", positive, None)
            width = section.require("width", positive, 1.0, "the width of the roll or sheet, or give 'hides'")
        if "sheets" in section.values and "length" not in section.values and not hides:
            section.problem(section.keys["sheets"], "sheets: a sheet has a 'length' too; without one it is a roll")
        materials[key] = Material(
            name=key,
            width=width,
            length=length,
            sheets=section.get("sheets", between(integer, 1, _MOST_SHEETS), None),
            hides=hides,
            rotations=_rotations(section),
            gap=section.get("gap", not_negative, 0.0),
            allowance=section.get("allowance", not_negative, 0.0),
            strain=section.get("strain", between(number, 0.0, _MOST_STRAIN), 0.0),
            thickness=section.get("thickness", not_negative, 0.0),
        )
    return materials or {_DEFAULT_MATERIAL.name: _DEFAULT_MATERIAL}


def _rotations(section: Section) -> tuple[float, ...] | None:
    if "rotations" not in section.values:
        return Material.rotations
    node = section.values["rotations"]
    expected = "a list of angles in degrees, or 'woven', 'nap' or 'free'"
    if isinstance(node, yaml.ScalarNode):
        word = section.read("rotations", node, scalar(expected), "free")
        if word not in _ROTATIONS:
            section.problem(node, f"rotations: {wrong(node, expected).message}")
        return _ROTATIONS.get(word)
    items = section.items("rotations", node, expected)
    if not items and isinstance(node, yaml.SequenceNode):
        section.problem(node, "rotations: names no angle; 0 keeps pieces as their grain lies")
    angle = between(number, -360.0, 360.0)
    return tuple(section.read(label, item, angle, 0.0) for label, item in items)
