"""`flatnet verify` passes a good build, and finds every error that is planted in a file, with place and amount."""

import hashlib
import json
import re
import shutil
from functools import partial

import numpy as np
import pytest

from flatnet.cli import main
from flatnet.export.output import REPORT, OutputFolder
from flatnet.verify import NotABuildError, verify

BACK, LAYOUT, WALL = "patches/back.obj", "layout-cloth.svg", "patches/wall.obj"


def edit(out, name, change):
    """Change the text of a file, which is then another."""
    text = (out / name).read_text(encoding="utf-8")
    changed = change(text)
    assert changed != text, "nothing was planted"
    (out / name).write_text(changed, encoding="utf-8")


def edit_json(out, name, change):
    content = json.loads((out / name).read_text())
    change(content)
    (out / name).write_text(json.dumps(content))


def record(report, part, key, value):
    (found,) = [one for one in report[part] if one[key] == value]
    return found


def move(out, name, kind, index, by):
    """Move the vertex `index` of an OBJ, or its flat place, along x."""

    def change(text):
        lines = text.splitlines(keepends=True)
        at = [number for number, line in enumerate(lines) if line.startswith(kind + " ")][index]
        words = lines[at].split()
        words[1] = repr(float(words[1]) + by)
        lines[at] = " ".join(words) + "\n"
        return "".join(lines)

    edit(out, name, change)


def scale(text, kinds, factors):
    def one(line):
        kind, *words = line.split()
        if kind not in kinds:
            return line
        return " ".join([kind, *(repr(float(word) * factor) for word, factor in zip(words, factors))])

    return "\n".join(map(one, text.splitlines())) + "\n"


def piece_of(text, patch, copy):
    """Where the group of a copy stands in an SVG."""
    start = re.search(rf'<g class="piece" data-copy="{copy}"[^>]*data-patch="{patch}"[^>]*>', text).start()
    return start, text.index("</g>", start) + len("</g>")


def edit_piece(out, change, patch="back", copy=1, file=LAYOUT):
    def whole(text):
        start, end = piece_of(text, patch, copy)
        return text[:start] + change(text[start:end]) + text[end:]

    edit(out, file, whole)


def matrix(text):
    return [float(word) for word in re.search(r'transform="matrix\(([^)]*)\)"', text).group(1).split(",")]


def with_matrix(text, numbers):
    return re.sub(r"matrix\([^)]*\)", f"matrix({','.join(map(repr, numbers))})", text, count=1)


def placed(out, change, patch="back", copy=1):
    """Move a copy in the drawing and in both lists of placements: only the geometry tells."""
    report = json.loads((out / "report.json").read_text())
    for layout in report["layouts"]:
        for piece in layout["pieces"]:
            if (piece["patch"], piece["copy"]) == (patch, copy):
                change(piece)
                angle, width = np.radians(piece["rotation_deg"]), layout["sheet_width_mm"]
                c, s, side = np.cos(angle), np.sin(angle), -1.0 if piece["mirrored"] else 1.0
                new = [float(v) for v in (c, -s, -s * side, -c * side, piece["x_mm"], width - piece["y_mm"])]
                edit_piece(out, partial(with_matrix, numbers=new), patch, copy, layout["file"])
    (out / "report.json").write_text(json.dumps(report))
    pieces = [layout["pieces"] for layout in report["layouts"]]

    def store(content):
        content["layouts"] = {str(number): {"seconds": 1, "sheets": [sheet]} for number, sheet in enumerate(pieces)}

    edit_json(out, "layout.json", store)


def place_of(out, patch):
    """Where its first copy lies."""
    report = json.loads((out / "report.json").read_text())
    found = next(piece for layout in report["layouts"] for piece in layout["pieces"] if piece["patch"] == patch)
    return {key: found[key] for key in ("rotation_deg", "x_mm", "y_mm")}


def turned(piece):
    piece["rotation_deg"] = (piece["rotation_deg"] + 90.0) % 360.0


def mirror_image(text):
    a, b, c, d, x, y = matrix(text)
    return with_matrix(text, [a, b, -c, -d, x, y])


def beside_another(out):
    """The layout with its gap, but for 0.1 mm: `back` moved towards its nearest neighbour."""
    import shapely

    from flatnet.verify.drawing import read_drawing

    pieces = {(p.patch, p.copy): p.region for p in read_drawing(LAYOUT, (out / LAYOUT).read_text()).pieces}
    mine = pieces.pop(("back", 1))
    other = min(pieces.values(), key=mine.distance)
    near, far = (np.array(point.coords[0]) for point in shapely.ops.nearest_points(mine, other))
    step = (far - near) / np.linalg.norm(far - near) * (np.linalg.norm(far - near) - 2.9)

    def change(piece):
        piece["x_mm"] += step[0]
        piece["y_mm"] -= step[1]

    placed(out, change)


def shift(point, by=0.01):
    """Move a point of a JSON file along x."""
    point[0] += by


def bend(index, by):
    """Change one of the stored dihedral angles."""
    return lambda content: content["angles"].__setitem__(index, content["angles"][index] + by)


def swap_sides(report):
    first, second = (record(report, "seams", "curve", name) for name in ("left_back", "right_back"))
    first["sides"], second["sides"] = second["sides"], first["sides"]


def shrink_drawn(text):
    """The piece's paths by a thousandth, its place as before."""
    return re.sub(
        r'd="([^"]*)"',
        lambda found: 'd="' + re.sub(r"-?\d+\.\d+", lambda n: f"{float(n.group()) * 0.999:.3f}", found.group(1)) + '"',
        text,
    )


def patches_metric(key, value):
    return lambda report: record(report, "patches", "name", "back")["metrics"].update({key: value})


#: What is planted, and what must be said: the check, the file, the place, and the amount with its part of tolerance.
PLANTED = {
    "an inner vertex moved by 0.01 mm": (
        lambda out: move(out, BACK, "v", -1, 0.01), "angle sums", BACK, "back", (2e-4, 0.9)),
    "an inner vertex moved by 0.01 mm: lengths": (
        lambda out: move(out, BACK, "v", -1, 0.01), "edge strain", BACK, "back", (4e-4, 0.7)),
    "an inner vertex moved by 0.01 mm: folded": (
        lambda out: move(out, BACK, "v", -1, 0.01), "folded piece on the mesh", "patches/back.folds.json", "back",
        (0.01, 0.1)),
    "a boundary vertex moved by 0.01 mm": (
        lambda out: move(out, BACK, "v", 1, 0.01), "boundary on the network", BACK, "back along", (0.01, 1e-6)),
    "a flat vertex moved by 0.01 mm": (
        lambda out: move(out, BACK, "vt", -1, 0.01), "edge strain", BACK, "back", (4e-4, 0.7)),
    "a flat boundary vertex moved by 0.01 mm": (
        lambda out: move(out, BACK, "vt", 1, 0.01), "sew line is the flat outline", LAYOUT, "back copy 1", (0.01, 0.2)),
    "a vertex of a piece that is strained, moved by 0.01 mm": (
        lambda out: move(out, WALL, "v", -1, 0.01), "figures of the report", "report.json", "wall, mean_edge_strain",
        (1e-5, 0.9)),
    "a vertex of the network moved by 0.01 mm": (
        lambda out: edit_json(out, "network.json", lambda content: shift(
            record(content, "curves", "name", "eaves")["vertices"][3])),
        "boundary on the network", "patches/front.obj", "front along 'eaves'", (0.01, 1e-6)),
    "a dihedral angle changed by 0.001 rad": (
        lambda out: edit_json(out, "patches/back.folds.json", bend(9, 1e-3)),
        "folded piece closes", "patches/back.folds.json", "back", (0.02, 0.5)),
    "a dihedral angle changed by 0.001 rad: the mesh's": (
        lambda out: edit_json(out, "patches/wall.folds.json", bend(9, 1e-3)),
        "stored dihedral angles", "patches/wall.folds.json", "wall", (1e-3, 1e-6)),
    "a mirrored flat mesh": (
        lambda out: edit(out, BACK, lambda text: scale(text, {"vt"}, (-1.0, 1.0))), "flipped triangles", BACK, "back",
        (None, 0)),
    "a mirrored piece": (
        lambda out: edit_piece(out, mirror_image), "mirrored as it says", LAYOUT, "back copy 1", (1, 0)),
    "a piece that says that it is mirrored": (
        lambda out: edit_piece(out, lambda text: text.replace('mirrored="false"', 'mirrored="true"')),
        "copies", LAYOUT, "back copy 1 (mirrored)", (1, 0)),
    "a flat mesh 0.1 % too small": (
        lambda out: edit(out, BACK, lambda text: scale(text, {"vt"}, (0.999, 0.999))), "edge strain", BACK, "back",
        (0.001, 1e-6)),
    "a mesh in cm": (
        lambda out: edit(out, BACK, lambda text: scale(text, {"v", "vt"}, (0.1, 0.1, 0.1))),
        "boundary on the network", BACK, "back along 'ridge'", (None, 0)),
    "a page 0.1 % too wide": (
        lambda out: edit(out, LAYOUT, lambda text: re.sub(
            r'width="([\d.]+)mm"', lambda found: f'width="{float(found.group(1)) * 1.001}mm"', text)),
        "one unit is 1 mm", LAYOUT, "", (None, 0)),
    "a piece drawn 0.1 % too small": (
        lambda out: edit_piece(out, shrink_drawn), "sew line is the flat outline", LAYOUT, "back copy 1", (0.1, 0.5)),
    "a piece of which the matrix is 0.1 % too large": (
        lambda out: edit_piece(out, lambda text: with_matrix(text, [
            number * factor for number, factor in zip(matrix(text), [1.001] * 4 + [1.0] * 2)])),
        "pieces neither stretched nor sheared", LAYOUT, "back copy 1", (0.002, 0.01)),
    "a copy that is missing": (
        lambda out: edit_piece(out, lambda text: "", "front", 2), "copies", LAYOUT, "front copy 2 (mirrored)", (1, 0)),
    "a copy that is there twice": (
        lambda out: edit_piece(out, lambda text: text + text), "copies", LAYOUT, "back copy 1", (1, 0)),
    "two seams swapped": (
        lambda out: edit_json(out, "report.json", swap_sides), "boundary on the network", BACK,
        "back along 'left_back'",
        (np.hypot(200.0, np.hypot(140.0, 60.0)), 1e-9)),
    "one side of a seam turned round": (
        lambda out: edit_json(out, "report.json", lambda report:
            record(report, "seams", "curve", "ridge")["sides"][1]["vertices"].reverse()),
        "seams join opposite sides", "patches/front.obj, patches/back.obj", "'ridge' of front and back", (1, 0)),
    "a seam that is not listed": (
        lambda out: edit_json(out, "report.json", lambda report: report["seams"].pop(0)), "boundary all seams",
        "patches/front.obj", "front", (None, 0)),
    "a flipped triangle": (
        lambda out: edit(out, BACK, lambda text: re.sub(r"f (\S+) (\S+) (\S+)\n$", r"f \2 \1 \3\n", text)),
        "a disk", BACK, "flipped", (None, 0)),
    "a triangle that is missing": (
        lambda out: edit(out, BACK, lambda text: re.sub(r"f \S+ \S+ \S+\n$", "", text)), None, BACK, "back", (None, 0)),
    "nan in a mesh": (
        lambda out: edit(out, BACK, lambda text: re.sub(r"v \S+", "v nan", text, count=1)), "files whole", BACK,
        "line 2: 'nan", (1, 0)),
    "nan in a drawing": (
        lambda out: edit_piece(out, lambda text: re.sub(r"M \S+,", "M nan,", text, count=1)), "files whole", LAYOUT,
        "'nan' is no number", (1, 0)),
    "nan in the report": (
        lambda out: edit_json(out, "report.json", patches_metric("max_edge_strain", float("nan"))),
        "figures of the report", "report.json", "back, max_edge_strain", (None, 0)),
    "nan in the network": (
        lambda out: edit_json(out, "network.json", lambda content: content["curves"][0]["vertices"][0].__setitem__(
            0, float("nan"))), "files whole", "network.json", "not finite", (1, 0)),
    "pieces that overlap": (
        lambda out: placed(out, lambda piece: piece.update(place_of(out, "front"))),
        "no overlap", LAYOUT, "back copy 1", (None, 0)),
    "a gap that is 0.1 mm too narrow": (beside_another, "gap kept", LAYOUT, "back copy 1", (0.1, 0.01)),
    "a piece turned against the grain": (
        lambda out: placed(out, turned), "rotations allowed", LAYOUT, "back copy 1", (90.0, 1e-9)),
    "a piece beyond the edge": (
        lambda out: placed(out, lambda piece: piece.update(y_mm=piece["y_mm"] + 1000.0)), "inside the sheet", LAYOUT,
        "back copy 1", (None, 0)),
    "a piece drawn elsewhere than reported": (
        lambda out: edit_piece(out, lambda text: with_matrix(text, [*matrix(text)[:4], matrix(text)[4] + 0.01,
            matrix(text)[5]])), "pieces where the report says", LAYOUT, "back copy 1", (0.01, 1e-6)),
    "a single piece that is another than on the sheet": (
        lambda out: edit_piece(out, lambda text: re.sub(r'(class="cut" d="M )(\S+),', lambda f:
            f"{f.group(1)}{float(f.group(2)) - 0.01:.3f},", text), "back", 1, "pieces/back.svg"),
        "piece alone as on the sheet", "pieces/back.svg", "back", (0.01, 1e-6)),
    "a half on the fold that is another": (
        lambda out: edit_piece(out, lambda text: re.sub(r'(class="sew" d="M )(\S+),', lambda f:
            f"{f.group(1)}{float(f.group(2)) - 0.01:.3f},", text), "wall", 1, "pieces/wall_on_fold.svg"),
        "halves on the fold", "pieces/wall_on_fold.svg", "wall", (0.01, 0.1)),
    "a placement stored otherwise": (
        lambda out: edit_json(
            out, "layout.json",
            lambda content: next(iter(content["layouts"].values()))["sheets"][0][0].update(x_mm=1.0)),
        "placements stored", "layout.json", "layout-", (1, 0)),
    "a piece listed otherwise than it is drawn": (
        lambda out: edit_json(out, "pieces.json", lambda content: record(content, "pieces", "name", "back")["cut_line"][
            0].__setitem__(0, 0.0)), "pieces as they are drawn", "pieces.json", "back", (None, 0)),
    "a sew line listed 0.0001 mm beside the mesh": (
        lambda out: edit_json(out, "pieces.json", lambda content: shift(
            record(content, "pieces", "name", "back")["sew_line"][0], 1e-4)),
        "sew lines bit by bit", "pieces.json", "back", (1e-4, 1e-6)),
    "a notch moved by 0.01 mm": (
        lambda out: edit_json(out, "pieces.json", lambda content: shift(
            record(content, "pieces", "name", "back")["notches"][0]["position"])),
        "notches on both sides", "pieces.json", "back, notch 1 of 'ridge'", (0.01, 1e-6)),
    "a node moved by 0.01 mm": (
        lambda out: edit_json(out, "network.json", lambda content: shift(content["nodes"]["a"])),
        "curves end in their nodes", "network.json", "eaves", (0.01, 1e-6)),
    "a report that lies about flattenability": (
        lambda out: edit_json(out, "report.json", patches_metric("max_flattenability_rad", 1e-6)),
        "figures of the report", "report.json", "back, max_flattenability_rad", (1e-6, 1e-3)),
    "a report that lies about the area": (
        lambda out: edit_json(out, "report.json", patches_metric("area_mm2", 1e4)), "figures of the report",
        "report.json", "back, area_mm2", (None, 0)),
    "a report that lies about a seam": (
        lambda out: edit_json(out, "report.json", lambda report: record(report, "seams", "curve", "ridge").update(
            length_b_mm=200.0)), "figures of the report", "report.json", "seam 'ridge', length_b_mm", (None, 0)),
    "a walk along a seam that is not as long": (
        lambda out: edit_json(out, "report.json", lambda report: record(report, "seam_walk", "a", "ridge")["legs"][
            1].update(b_mm=60.1)), "figures of the report", "report.json", "walk along 'ridge', b", (None, 0)),
    "a report that lies about the use of the sheet": (
        lambda out: edit_json(out, "report.json", lambda report: report["layouts"][0].update(utilisation=0.99)),
        "figures of layouts", "report.json", "layout-cloth.svg, utilisation", (None, 0)),
    "a report that says that a patch failed": (
        lambda out: edit_json(out, "report.json", lambda report: report["patches"][0].update(status="failed")),
        "status of the report", "report.json", "'partial'", (1, 0)),
    "a file that is missing": (
        lambda out: (out / "pieces" / "back.svg").unlink(), "files of the report", "pieces/back.svg", "can't be read",
        (1, 0)),
    "a piece of an earlier build": (
        lambda out: shutil.copy(out / "pieces/back.svg", out / "pieces/sleeve.svg"), "nothing unlisted",
        "pieces/sleeve.svg", "might be cut", (1, 0)),
    "a file elsewhere": (
        lambda out: edit_json(out, "report.json", lambda report: report["files"].append("../project.yaml")),
        "files of the report", "../project.yaml", "outside the folder", (1, 0)),
}  # fmt: skip


@pytest.mark.parametrize("planted", PLANTED)
def test_a_planted_error_is_found(out, planted):
    plant, check, file, words, (amount, part) = PLANTED[planted]
    plant(out)
    certificate = verify(out)
    found = [one for one in certificate.problems if check in (None, one.check) and file == one.file]
    said = [one for one in found if words in str(one)]
    assert said, "\n".join(map(str, certificate.problems))
    if amount is not None:
        assert max(one.amount for one in said) == pytest.approx(amount, rel=part, abs=0.0)
    written = json.loads((out / "certificate.json").read_text())
    assert not written["passed"] and str(said[0]) in written["problems"]


def test_a_good_build_passes_and_its_files_are_named_with_their_hashes(out, capsys):
    assert main(["verify", str(out)]) == 0
    assert "FAILED" not in (said := capsys.readouterr().out) and "verified: 19 files" in said
    certificate = json.loads((out / "certificate.json").read_text())
    report = json.loads((out / "report.json").read_text())
    assert certificate["passed"] and certificate["problems"] == []
    assert certificate["sha256"] == {
        name: hashlib.sha256((out / name).read_bytes()).hexdigest() for name in sorted(report["files"])
    }
    assert {"angle sums", "folded piece on the network", "no overlap"} - {
        check["check"] for check in certificate["checks"]
    } == {"no overlap"}  # a pair that does not overlap is measured as a gap


def test_the_certificate_is_the_same_for_the_same_files(out):
    verify(out)
    first = (out / "certificate.json").read_bytes()
    verify(out)
    assert (out / "certificate.json").read_bytes() == first


def test_a_failure_is_printed_and_the_exit_status_is_1(out, capsys):
    move(out, BACK, "v", 1, 0.01)
    assert main(["verify", str(out)]) == 1
    said = capsys.readouterr().out
    assert re.search(r"^boundary on the network +\d+ +0\.01 mm +1e-06 +\d FAILED", said, re.MULTILINE)
    assert re.search(r"^patches/back\.obj: back along '\w+': boundary on the network: .*0\.01 mm", said, re.MULTILINE)


def test_every_file_is_looked_at_and_none_may_be_cut_short(built, tmp_path):
    """Whatever is lost at the end of whatever file: found in that file, and no traceback."""
    for name in json.loads((built / "report.json").read_text())["files"]:
        out = shutil.copytree(built, tmp_path / name.replace("/", "-"))
        content = (out / name).read_bytes()
        (out / name).write_bytes(content[: len(content) // 2])
        problems = verify(out).problems
        assert any(one.file == name and one.check in ("files whole", "a disk") for one in problems), name
        assert not json.loads((out / "certificate.json").read_text())["passed"]


@pytest.mark.parametrize("key", ["patches", "seams", "seam_walk", "layouts", "files", "project", "status"])
@pytest.mark.parametrize("value", [None, 3, [3], {"name": 3}])
def test_a_report_of_another_shape_is_damage_and_no_traceback(out, key, value):
    edit_json(out, "report.json", lambda report: report.update({key: value}))
    assert any(one.file == "report.json" for one in verify(out).problems)


def test_a_folder_without_a_build_is_refused_and_left_alone(tmp_path, capsys):
    assert main(["verify", str(tmp_path / "nowhere")]) == 2
    assert "is no folder" in capsys.readouterr().err
    assert main(["verify", str(tmp_path)]) == 2
    assert "holds no report.json of a build" in capsys.readouterr().err
    (tmp_path / "report.json").write_text("{}")
    with pytest.raises(NotABuildError, match="no report of the format"):
        verify(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["report.json"]


def test_the_next_build_removes_the_certificate(out):
    """It was of other files."""
    verify(out)
    with OutputFolder(out) as output:
        (output.staging / REPORT).write_text("{}")
        output.commit([REPORT])
    assert [path.name for path in out.iterdir()] == [REPORT]
