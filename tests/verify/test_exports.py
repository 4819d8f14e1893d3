"""What `flatnet export` wrote is congruent with the build, whatever the format; an error in any of them is found."""

import json
import re
import shutil
import struct
import sys
from io import BytesIO

import pypdf
import pytest
from pypdf.generic import DecodedStreamObject, NameObject

from flatnet.cli import main
from flatnet.verify import verify

FORMATS = "svg,dxf,dxf-astm,dxf-aama,pdf,pdf-a4,hpgl,obj,glb,ply,sewing,garmentcode,cutlist"


@pytest.fixture(scope="module")
def exported(built, tmp_path_factory):
    """The small build with exports; nobody changes it."""
    folder = shutil.copytree(built, tmp_path_factory.mktemp("exported") / "out")
    assert main(["export", str(folder), "--format", FORMATS]) == 0
    return folder


@pytest.fixture
def out(exported, tmp_path):
    return shutil.copytree(exported, tmp_path / "out")


def edit(out, name, change):
    path = out / "exports" / name
    content = path.read_bytes()
    changed = change(content)
    assert changed != content, "nothing was planted"
    path.write_bytes(changed)


def of_text(change):
    return lambda content: change(content.decode()).encode()


def of_json(change):
    def changed(content):
        record = json.loads(content)
        change(record)
        return json.dumps(record).encode()

    return changed


def test_every_export_is_looked_into_and_passes(out):
    certificate = verify(out)
    assert certificate.passed, "\n".join(map(str, certificate.problems))
    kinds = {check.split(":")[0] for check in certificate.checks if ":" in check}
    assert kinds == {
        "SVG", "DXF", "DXF of the trade", "PDF", "HPGL", "OBJ", "GLB", "PLY", "sewing map", "GarmentCode", "cut list",
    }  # fmt: skip
    files = {one.file for one in certificate.measured if ":" in one.check or one.check == "material list"}
    listed = {name for name in json.loads((out / "report.json").read_text())["files"] if name.startswith("exports/")}
    assert listed <= files


def moved_vertex(layer):
    """In a DXF, the second vertex of the first polyline on a layer, moved by 0.01 mm along x."""

    def change(text):
        match = re.search(rf"\n *0\n(LWPOLYLINE|VERTEX)\n(?:(?! *0\n).*\n)*? *8\n{layer}\n(?:.*\n)*?(?= *0\n)", text)
        start, end = match.span()
        entity = re.sub(
            r"(\n *10\n)(\S+)", lambda x: f"{x.group(1)}{float(x.group(2)) + 0.01!r}", text[start:end], count=1
        )
        return text[:start] + entity + text[end:]

    return of_text(change)


def moved_pen(text):
    """In HPGL, the second place of the first line that the pen of sew lines draws, by 2 units."""
    start = text.index("SP2;")
    return text[:start] + re.sub(
        r"PD(-?\d+),", lambda found: f"PD{int(found.group(1)) + 2},", text[start:], count=1
    )


def moved_float(content, layout="<f", at=0.01e-3):
    """In a GLB, the first coordinate of the first vertex, by 0.01 mm."""
    (length,) = struct.unpack_from("<I", content, 12)
    start = 28 + length
    (x,) = struct.unpack_from(layout, content, start)
    return content[:start] + struct.pack(layout, x + at) + content[start + struct.calcsize(layout) :]


def moved_ply(content):
    start = content.index(b"end_header\n") + len(b"end_header\n")
    kind = "<d" if b"property double x" in content else "<f"
    (x,) = struct.unpack_from(kind, content, start)
    return content[:start] + struct.pack(kind, x + 0.01) + content[start + struct.calcsize(kind) :]


def smaller_page(content):
    """A PDF whose every line is drawn 0.1 % too small."""
    writer = pypdf.PdfWriter(clone_from=BytesIO(content))
    for page in writer.pages:
        stream = DecodedStreamObject()
        stream.set_data(b"q 0.999 0 0 0.999 0 0 cm\n" + page.get_contents().get_data() + b"\nQ")
        page[NameObject("/Contents")] = writer._add_object(stream)
    target = BytesIO()
    writer.write(target)
    return target.getvalue()


PLANTED = {
    "SVG": ("layout-cloth.svg", of_text(lambda text: re.sub(
        r'(class="sew" d="M )(\S+),', lambda found: f"{found.group(1)}{float(found.group(2)) + 0.01:.3f},", text,
        count=1)), "SVG: outlines", 0.01),
    "DXF": ("layout-cloth.dxf", moved_vertex("sew"), "DXF: outlines", 0.01),
    "DXF of the trade": ("pattern-astm.dxf", moved_vertex("14"), "DXF of the trade: outlines", 0.01),
    "PDF": ("layout-cloth.pdf", smaller_page, "PDF: outlines", 0.1),
    "HPGL": ("layout-cloth.plt", of_text(moved_pen), "HPGL: outlines", 0.05),
    "GLB": ("model.glb", moved_float, "GLB: in space", 0.01),
    "PLY": ("model.ply", moved_ply, "PLY: in space", 0.01),
    "OBJ": ("model.obj", of_text(lambda text: re.sub(
        r"v (\S+)", lambda found: f"v {float(found.group(1)) + 0.01!r}", text, count=1)), "OBJ: in space", 0.01),
    "sewing map": ("sewing.json", of_json(lambda record: record["seams"][0]["sides"][0]["vertices"].reverse()),
        "sewing map: sides", 1.0),
    "GarmentCode": ("roof_specification.json", of_json(
        lambda record: record["pattern"]["panels"]["back"]["vertices"][3].__setitem__(
            0, record["pattern"]["panels"]["back"]["vertices"][3][0] + 0.001)), "GarmentCode: outlines", 0.01),
    "cut list": ("cut-list.csv", of_text(lambda text: text.replace("front,front,cloth,1,1", "front,front,cloth,2,0")),
        "cut list: copies", 1.0),
}  # fmt: skip


@pytest.mark.parametrize("kind", PLANTED)
def test_an_error_in_an_export_is_found(out, kind):
    name, change, check, amount = PLANTED[kind]
    edit(out, name, change)
    found = [one for one in verify(out).problems if one.check == check and one.file == f"exports/{name}"]
    assert found
    # A congruent figure lies where the error is spread over all its vertices; of HPGL the rounding comes on top.
    assert 0.5 * amount <= max(one.amount for one in found) <= 2.0 * amount


def in_dxf(layer, kind, change):
    """The first entity of a kind on a layer of a DXF, changed: its text in and out."""
    entity = rf" *0\n{kind}\n(?:(?! *0\n).*\n.*\n)*? *8\n{layer}\n(?:(?! *0\n).*\n.*\n)*"
    return of_text(lambda text: re.sub(entity, lambda found: change(found.group()), text, count=1))


def shifted(entity):
    """The first x of an entity of a DXF, by 0.01 mm."""
    return re.sub(r"(\n *10\n)(\S+)", lambda x: f"{x.group(1)}{float(x.group(2)) + 0.01!r}", entity, count=1)


def moved_in_hpgl(pen):
    """The last place of the first open line of a pen, by 4 units."""

    def change(text):
        start = text.index(f"SP{pen};")
        line = r"PU(-?\d+,-?\d+);PD(?!\1|\S*,\1;)((?:-?\d+,)*)(-?\d+);"
        return text[:start] + re.sub(
            line, lambda m: f"PU{m.group(1)};PD{m.group(2)}{int(m.group(3)) + 4};", text[start:], count=1
        )

    return of_text(change)


def moved_in_svg(kind):
    """The first x of the first line of a class, by 0.01 mm."""
    return of_text(lambda text: re.sub(
        rf'(class="{kind}" d="M )(\S+),', lambda found: f"{found.group(1)}{float(found.group(2)) + 0.01:.3f},", text,
        count=1))  # fmt: skip


def without_short_lines(content):
    """A PDF in which no open line of two points is stroked."""
    writer = pypdf.PdfWriter(clone_from=BytesIO(content))
    for page in writer.pages:
        stream = DecodedStreamObject()
        drawn = page.get_contents().get_data().decode("latin-1")
        kept = re.sub(r"(\nn \S+ \S+ m \S+ \S+ l)\s+S\n", r"\1\n", drawn)
        assert kept != drawn
        stream.set_data(kept.encode("latin-1"))
        page[NameObject("/Contents")] = writer._add_object(stream)
    target = BytesIO()
    writer.write(target)
    return target.getvalue()


#: Errors in what is drawn inside and at the rim of a piece; the amount, mm or lines.
PLANTED_LINES = [
    *(("layout-cloth.svg", moved_in_svg(kind), f"SVG: {what}", 0.01)
      for kind, what in (("notch", "notches"), ("nick", "nicks"), ("internal", "marks"), ("grain", "grain"))),
    *(("layout-cloth.dxf", in_dxf(kind, "LWPOLYLINE", shifted), f"DXF: {what}", 0.01)
      for kind, what in (("notch", "notches"), ("nick", "nicks"), ("internal", "marks"))),
    *(("layout-cloth.dxf", in_dxf(kind, "LWPOLYLINE", lambda entity: 2 * entity), f"DXF: as many {what}", 1.0)
      for kind, what in (("notch", "notches"), ("nick", "nicks"), ("internal", "marks"))),
    ("pattern-astm.dxf", in_dxf("4", "POINT", shifted), "DXF of the trade: notches", 0.01),
    ("pattern-aama.dxf", in_dxf("4", "POINT", lambda entity: ""), "DXF of the trade: as many notches", 1.0),
    ("pattern-astm.dxf", in_dxf("13", "POINT", shifted), "DXF of the trade: drill holes", 0.01),
    ("pattern-aama.dxf", in_dxf("13", "POINT", lambda entity: 2 * entity), "DXF of the trade: as many drill holes", 1),
    ("pattern-astm.dxf", in_dxf("8", "LINE", shifted), "DXF of the trade: marks", 0.01),
    ("pattern-aama.dxf", in_dxf("7", "LINE", shifted), "DXF of the trade: grain", 0.01),
    *(("layout-cloth.plt", moved_in_hpgl(pen), f"HPGL: {what}", 0.1)
      for pen, what in ((3, "notches"), (4, "marks"), (5, "grain"), (1, "nicks"))),
    ("layout-cloth.pdf", without_short_lines, "PDF: notches", float("inf")),
]  # fmt: skip


@pytest.mark.parametrize("name, change, check, amount", PLANTED_LINES)
def test_an_error_in_a_notch_a_mark_or_the_grain_is_found(out, name, change, check, amount):
    edit(out, name, change)
    found = [one for one in verify(out).problems if one.check == check and one.file == f"exports/{name}"]
    assert found, "\n".join(map(str, verify(out).problems))
    assert 0.8 * amount <= max(one.amount for one in found) <= 1.3 * amount


def test_a_pdf_that_can_not_be_read_is_not_passed_over(out, monkeypatch):
    monkeypatch.setitem(sys.modules, "pypdf", None)
    said = [str(one) for one in verify(out).problems]
    assert len(said) == 4 and all(".pdf: PDF: outlines: pypdf is not installed" in one for one in said)


def test_no_export_may_be_cut_short(exported, tmp_path):
    for path in sorted((exported / "exports").rglob("*")):
        name = path.relative_to(exported).as_posix()
        if path.is_dir() or name.endswith(".csv"):
            continue
        out = shutil.copytree(exported, tmp_path / name.replace("/", "-"))
        (out / name).write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        assert any(one.file == name for one in verify(out).problems), name
