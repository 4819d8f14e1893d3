"""Every format of two shipped projects, read back by readers that are not ours and compared with the OBJ files.

Tolerances are those of docs/exports.md.
"""

import csv
import json
import re
import struct
from pathlib import Path

import ezdxf
import jsonschema
import numpy as np
import pypdf
import pytest
import trimesh
from golden import same_lines
from scipy.spatial.transform import Rotation
from svgelements import SVG, Group
from svgelements import Path as SvgPath
from written import READER_SCALE

from flatnet.export.formats import EXPORTERS
from flatnet.parameters import EXPORT_FORMATS

SCHEMA = Path(__file__).parents[2] / "docs" / "sewing.schema.json"
MM = 25.4 / 72.0
#: All digits of coordinates below 10 m.
EXACT = 1e-9


def test_every_format_that_a_project_may_name_is_written(golden):
    assert tuple(EXPORTERS) == EXPORT_FORMATS
    assert len([file for file in golden.folder.iterdir() if file.is_file()]) == 17


# --- drawings


def test_svg_has_a_layer_for_each_meaning_with_every_piece(golden):
    svg = SVG.parse(str(golden.folder / f"{golden.sheet}.svg"), ppi=25.4)
    layers = {g.values["id"]: g for g in svg.elements() if isinstance(g, Group) and "id" in g.values["attributes"]}
    for kind, lines in (("sew", golden.sew_lines), ("cut", golden.cut_lines)):
        paths = [path for path in layers[kind].select() if isinstance(path, SvgPath)]
        assert {path.values["class"] for path in paths} == {kind}
        assert {path.stroke.hexrgb for path in paths} == {{"sew": "#0000ff", "cut": "#ff0000"}[kind]}
        found = [np.array([[s.end.x, s.end.y] for s in path * path.transform][:-1]) / READER_SCALE for path in paths]
        width = golden.layout["sheet_width_mm"]
        same_lines(found, [line * [1.0, -1.0] + [0.0, width] for line in lines.values()], 0.002)


def test_svg_says_which_vertices_belong_to_which_seam(golden):
    text = (golden.folder / "pieces" / f"{golden.layout['pieces'][0]['patch']}.svg").read_text()
    svg = SVG.parse(str(golden.folder / "pieces" / f"{golden.layout['pieces'][0]['patch']}.svg"), ppi=25.4)
    (path,) = [e for e in svg.elements() if isinstance(e, SvgPath) and e.values.get("class") == "sew"]
    assert "data-seams" in text
    said = json.loads(path.values["data-seams"])
    piece = golden.pieces[golden.layout["pieces"][0]["patch"]]
    wanted = [(s["number"], s["name"], s["vertices"][0], s["vertices"][-1]) for s in piece["seams"]]
    assert [(s["number"], s["name"], s["from"], s["to"]) for s in said] == wanted


def test_dxf_has_a_layer_for_each_meaning_in_mm(golden):
    document = ezdxf.readfile(golden.folder / f"{golden.sheet}.dxf")
    assert not document.audit().errors and document.units == ezdxf.units.MM
    page = document.modelspace()
    for kind, lines in (("sew", golden.sew_lines), ("cut", golden.cut_lines)):
        drawn = page.query(f'LWPOLYLINE[layer=="{kind}"]')
        assert all(line.closed for line in drawn)
        same_lines([np.array(line.get_points("xy")) for line in drawn], list(lines.values()), EXACT)
        assert document.layers.get(kind).rgb == {"sew": (0, 0, 255), "cut": (255, 0, 0)}[kind]
    groups = {name for name, _ in document.groups}
    assert groups == {f"{patch}-{copy}" for patch, copy in golden.sew_lines}


def hpgl_lines(text):
    """Pen -> its polylines, in units."""
    lines, pen, points = {}, 0, []
    for command in re.sub(r"LB[^\x03]*\x03", "", text).split(";"):
        word, numbers = command[:2], [int(n) for n in re.findall(r"-?\d+", command[2:])]
        if word in ("PU", "SP") and len(points) > 1:
            lines.setdefault(pen, []).append(np.array(points))
        if word == "SP":
            pen, points = numbers[0], []
        elif word == "PU":
            points = [numbers] if numbers else []
        elif word == "PD":
            points += [numbers[i : i + 2] for i in range(0, len(numbers), 2)]
    return lines


def test_hpgl_draws_each_meaning_with_its_pen_and_cuts_last(golden):
    text = (golden.folder / f"{golden.sheet}.plt").read_bytes().decode("ascii")
    assert text.startswith("IN;") and text.endswith("PU;SP0;")
    lines = hpgl_lines(text)
    for pen, wanted in ((2, golden.sew_lines), (1, golden.cut_lines)):
        assert all((line[0] == line[-1]).all() for line in lines[pen])
        same_lines([line[:-1] / 40.0 for line in lines[pen]], list(wanted.values()), 0.0125 + EXACT)
    assert [int(pen) for pen in re.findall(r"SP(\d)", text)][-2:] == [1, 0]


# --- PDF


def pdf_lines(page):
    """The polylines of a page by their stroke colour, in mm from its lower left corner."""
    lines, state = {}, {"colour": None, "points": []}

    def operator(name, operands, matrix, _):
        numbers = [float(each) for each in operands] if name in (b"RG", b"m", b"l") else []
        a, b, c, d, e, f = matrix
        if name == b"RG":
            state["colour"] = tuple(numbers)
        elif name == b"m":
            state["points"] = [numbers]
        elif name == b"l":
            state["points"].append(numbers)
        elif name in (b"S", b"n", b"s"):
            if name != b"n" and state["points"]:
                points = np.array(state["points"]) @ np.array([[a, b], [c, d]]) + [e, f]
                lines.setdefault(state["colour"], []).append(points * MM)
            state["points"] = []

    page.extract_text(visitor_operand_before=operator)
    return lines


def test_pdf_is_one_page_in_true_scale(golden):
    reader = pypdf.PdfReader(golden.folder / f"{golden.sheet}.pdf")
    (page,) = reader.pages
    assert reader.viewer_preferences["/PrintScaling"] == "/None"
    lines = pdf_lines(page)
    for colour, wanted in (((0, 0, 1), golden.sew_lines), ((1, 0, 0), golden.cut_lines)):
        low = np.min([line.min(axis=0) for line in lines[colour]], axis=0)
        truly_low = np.min([line.min(axis=0) for line in wanted.values()], axis=0)
        same_lines([line - low + truly_low for line in lines[colour]], list(wanted.values()), 0.001)


PAPERS = {"a4": (210, 297), "letter": (215.9, 279.4), "a3": (297, 420), "a0": (841, 1189)}


@pytest.mark.parametrize("paper", PAPERS)
def test_tiles_show_all_of_every_piece_and_none_is_empty(golden, paper):
    reader = pypdf.PdfReader(golden.folder / f"{golden.sheet}-{paper}.pdf")
    assert reader.viewer_preferences["/PrintScaling"] == "/None"
    cover, *pages = reader.pages
    width, height = (float(each) * MM for each in cover.mediabox[2:])
    assert sorted((width, height)) == pytest.approx(sorted(PAPERS[paper]), abs=1e-3)
    window = np.array([width, height]) - 20.0
    step = window - 10.0
    top = golden.layout["sheet_width_mm"]
    named = {re.search(r"([A-Z]+)(\d+) · \d+ of (\d+)", page.extract_text()).groups(): page for page in pages}
    assert {int(total) for _, _, total in named} == {len(pages)}
    seen = {key: np.zeros(len(line), bool) for key, line in golden.cut_lines.items()}
    for (letters, row, _), page in named.items():
        column = ord(letters) - ord("A")
        corner = np.array([column * step[0], top - int(row) * step[1] - 10.0])
        lines = [line - 10.0 + corner for line in pdf_lines(page)[1, 0, 0]]
        inside_any = False
        for key, wanted in golden.cut_lines.items():
            inside = ((wanted >= corner - EXACT) & (wanted <= corner + window + EXACT)).all(axis=1)
            near = [line for line in lines if line.shape == wanted.shape and np.abs(line - wanted).max() <= 0.001]
            if near:
                seen[key] |= inside
            assert near or not inside.any()
            inside_any |= bool(near)
        assert inside_any
    assert all(each.all() for each in seen.values())


# --- patterns for other programs


@pytest.mark.parametrize("dialect", ["astm", "aama"])
def test_dxf_pattern_has_every_piece_with_its_lines_and_points(golden, dialect):
    file = golden.folder / f"pattern-{dialect}.dxf"
    file.read_bytes().decode("ascii")
    document = ezdxf.readfile(file)
    assert document.dxfversion == "AC1009" and not document.audit().errors
    layers = set()
    for name, piece in golden.pieces.items():
        block = document.blocks.get(f"{name}_ONE")
        assert block.block.dxf.flags & 64
        assert {entity.dxftype() for entity in block} <= {"POLYLINE", "LINE", "POINT", "TEXT"}
        layers |= {int(entity.dxf.layer) for entity in block}
        lines = {}
        for entity in block.query("POLYLINE"):
            assert entity.is_closed
            lines[entity.dxf.layer] = np.array([vertex.dxf.location.vec2 for vertex in entity.vertices])
        assert np.abs(lines["14"] - golden.flat[piece["patch"]]).max() <= EXACT
        assert np.abs(lines["1"] - piece["cut_line"]).max() <= EXACT
        points = {tuple(point.dxf.location.vec2) for point in block.query('POINT[layer=="2" | layer=="3"]')}
        vertices = {tuple(vertex) for key in ("1", "14") for vertex in lines[key].tolist()}
        assert vertices <= {(point[0], point[1]) for point in points}
        (grain,) = block.query('LINE[layer=="7"]')
        assert grain.dxf.start.y == pytest.approx(grain.dxf.end.y, abs=EXACT)
        said = dict(text.dxf.text.split(": ", 1) for text in block.query('TEXT[layer=="1"]'))
        quantity = f"{piece['cut']},{piece['mirrored']}" if dialect == "astm" else str(piece["cut"] + piece["mirrored"])
        assert (said["Piece Name"], said["Quantity"], said["Material"]) == (name, quantity, piece["material"])
    assert (max(layers) > 14) == (dialect == "astm")
    inserted = {entity.dxf.name for entity in document.modelspace().query("INSERT")}
    assert inserted == {f"{name}_ONE" for name in golden.pieces}


def test_sewing_json_fits_its_schema_and_joins_equal_edges(golden):
    record = json.loads((golden.folder / "sewing.json").read_text())
    jsonschema.validate(record, json.loads(SCHEMA.read_text()))
    assert [seam["name"] for seam in record["seams"]] == [seam["curve"] for seam in golden.report["seams"]]
    for seam in record["seams"]:
        steps = [np.linalg.norm(np.diff(golden.flat[s["patch"]][s["vertices"]], axis=0), axis=1) for s in seam["sides"]]
        assert steps[0].sum() == pytest.approx(seam["length"], abs=1e-6)
        assert np.abs(steps[0] - steps[-1]).max() <= 1e-6
        for side, step in zip(seam["sides"], steps):
            assert np.diff(side["arclengths"]) == pytest.approx(step, abs=1e-9)
            (piece,) = side["pieces"]
            assert len(piece["allowances"]) == len(step) and min(piece["allowances"]) >= 0


def test_garmentcode_panels_lie_near_their_patches_and_stitches_join_equal_edges(golden):
    record = json.loads((golden.folder / f"{golden.report['project']}_specification.json").read_text())
    panels = record["pattern"]["panels"]
    assert record["properties"]["units_in_meter"] == 100
    for name, panel in panels.items():
        vertices = np.array(panel["vertices"])
        assert np.abs(10.0 * vertices - golden.flat[name]).max() <= EXACT
        ends = [edge["endpoints"] for edge in panel["edges"]]
        assert [b for _, b in ends] == [a for a, _ in ends[1:] + ends[:1]]
        rotation = Rotation.from_euler("xyz", panel["rotation"], degrees=True)
        in_space, flat, _ = golden.meshes[name]
        to_its_axes = 0.1 * in_space[:, [0, 2, 1]] * [-1.0, 1.0, 1.0]  # x to the left, y up, z to the front, cm
        flat = 0.1 * np.column_stack([flat, np.zeros(len(flat))])
        nearest, _ = Rotation.align_vectors(to_its_axes - to_its_axes.mean(axis=0), flat - flat.mean(axis=0))
        assert (rotation * nearest.inv()).magnitude() < 1e-6
        middle = rotation.apply(flat.mean(axis=0)) + panel["translation"]
        assert middle == pytest.approx(to_its_axes.mean(axis=0), abs=1e-9)
    lengths = {
        name: np.linalg.norm(np.roll(panel["vertices"], -1, axis=0) - panel["vertices"], axis=1)
        for name, panel in panels.items()
    }
    stitches = record["pattern"]["stitches"]
    for a, b in stitches:
        assert lengths[a["panel"]][a["edge"]] == pytest.approx(lengths[b["panel"]][b["edge"]], abs=1e-7)
    edges = [(side["panel"], side["edge"]) for stitch in stitches for side in stitch]
    assert len(set(edges)) == len(edges)
    two_sided = [len(s["sides"][0]["vertices"]) - 1 for s in golden.report["seams"] if len(s["sides"]) == 2]
    assert len(stitches) == sum(two_sided)


# --- the model


def test_obj_holds_every_patch_bit_by_bit(golden):
    scene = trimesh.load(golden.folder / "model.obj", process=False, maintain_order=True)
    text = (golden.folder / "model.obj").read_text()
    assert re.findall(r"^o (.*)$", text, re.M) == list(golden.meshes)
    vertices = np.array([line.split()[1:] for line in text.splitlines() if line.startswith("v ")], float)
    flat = np.array([line.split()[1:] for line in text.splitlines() if line.startswith("vt ")], float)
    assert np.array_equal(vertices, np.concatenate([mesh[0] for mesh in golden.meshes.values()]))
    assert np.array_equal(flat, np.concatenate([mesh[1] for mesh in golden.meshes.values()]))
    parts = scene.geometry.values() if isinstance(scene, trimesh.Scene) else [scene]
    assert sum(part.area for part in parts) == pytest.approx(
        sum(trimesh.Trimesh(v, f, process=False).area for v, _, f in golden.meshes.values()), rel=1e-6)


def test_ply_holds_all_patches_with_their_flat_coordinates(golden):
    data = (golden.folder / "model.ply").read_bytes()
    header, _, body = data.partition(b"end_header\n")
    count = int(re.search(rb"element vertex (\d+)", header)[1])
    kinds = {b"float": "<f4", b"float32": "<f4", b"double": "<f8", b"float64": "<f8", b"uchar": "u1", b"uint8": "u1"}
    properties = re.search(rb"element vertex.*?(?=element face)", header, re.S)[0]
    fields = [(name.decode(), kinds[kind]) for kind, name in re.findall(rb"property (\w+) (\w+)", properties)]
    rows = np.frombuffer(body, dtype=fields, count=count)
    vertices = np.concatenate([mesh[0] for mesh in golden.meshes.values()])
    flat = np.concatenate([mesh[1] for mesh in golden.meshes.values()])
    assert np.abs(np.column_stack([rows[k] for k in "xyz"]) - vertices).max() <= 0.001
    assert np.abs(np.column_stack([rows[k] for k in "st"]) - flat).max() <= EXACT
    assert (rows["blue"] == 255).mean() > 0.99 and rows["red"].max() == 0  # flattenable throughout
    assert len(trimesh.load(golden.folder / "model.ply", process=False).faces) == sum(
        len(mesh[2]) for mesh in golden.meshes.values())


def glb_arrays(path):
    """The JSON of a GLB and a function from an accessor's index to its array."""
    data = path.read_bytes()
    magic, version, total = struct.unpack_from("<4sII", data)
    assert (magic, version, total) == (b"glTF", 2, len(data))
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    content, body = json.loads(data[20 : 20 + length]), data[28 + length :]

    def array(index):
        accessor = content["accessors"][index]
        view = content["bufferViews"][accessor["bufferView"]]
        dtype = {5126: "<f4", 5125: "<u4", 5121: "u1"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view.get("byteOffset", 0)
        return np.frombuffer(body, dtype, accessor["count"] * width, start).reshape(-1, width)

    return content, array


def test_glb_shows_every_patch_and_its_morph_target_lays_it_flat(golden):
    content, array = glb_arrays(golden.folder / "model.glb")
    assert [node["name"] for node in content["nodes"]] == list(golden.meshes)
    first = {p["patch"]: p for p in reversed(golden.layout["pieces"]) if not p["mirrored"]}
    for node in content["nodes"]:
        mesh = content["meshes"][node["mesh"]]
        (primitive,) = mesh["primitives"]
        assert mesh["extras"]["targetNames"] == ["flat"]
        vertices, flat, faces = golden.meshes[node["name"]]
        places = array(primitive["attributes"]["POSITION"]).astype(float)
        seen = 1000.0 * places * [1, 1, -1]
        assert np.abs(seen[:, [0, 2, 1]] - vertices).max() <= 0.001
        assert np.array_equal(array(primitive["indices"]).reshape(-1, 3), faces)
        laid = 1000.0 * (places + array(primitive["targets"][0]["POSITION"]))
        assert np.abs(laid[:, 1]).max() <= 0.001
        wanted = golden.placed(flat, first[node["name"]])
        assert np.abs(laid[:, [0, 2]] * [1.0, -1.0] - wanted).max() <= 0.001
    scene = trimesh.load(golden.folder / "model.glb", process=False)
    assert set(scene.geometry) == set(golden.meshes)


# --- lists


def test_cut_list_and_material_list_say_what_there_is(golden):
    with (golden.folder / "cut-list.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["piece"] for row in rows] == list(golden.pieces)
    for row in rows:
        copies = [p for p in golden.layout["pieces"] if p["patch"] == row["patch"]]
        assert int(row["cut"]) == sum(not p["mirrored"] for p in copies)
        assert int(row["mirrored"]) == sum(p["mirrored"] for p in copies)
        x, y = np.array(golden.pieces[row["piece"]]["cut_line"]).T
        area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        assert float(row["area_mm2"]) == pytest.approx(area, abs=0.5)
    with (golden.folder / "materials.csv").open(encoding="utf-8-sig", newline="") as file:
        (row,) = csv.DictReader(file)
    assert float(row["used_length_mm"]) == pytest.approx(golden.layout["used_length_mm"], abs=0.05)
    assert int(row["copies"]) == len(golden.layout["pieces"])
