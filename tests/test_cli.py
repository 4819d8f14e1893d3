"""The command as a user runs it: exit statuses, messages without tracebacks, Ctrl-C."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
import trimesh
from written import read_report

from flatnet import ProjectError, build, check
from flatnet.cli import main

ROOT = Path(__file__).parents[1]
SQUARE = """\
flatnet: 1
name: square
edge_length: 20
curves:
  rim: {closed: true, points: [[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0]], normals: [0, 0, 1]}
patches:
  top: {around: [rim], grain: [1, 0, 0]}
materials:
  cloth: {width: 500}
"""


@pytest.fixture
def square(tmp_path):
    file = tmp_path / "square project.yaml"
    file.write_text(SQUARE)
    return file


def files_in(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_good_project(square, tmp_path, capsys):
    assert main(["build", str(square), "-o", str(tmp_path / "out")]) == 0
    assert "ok: 1 of 1 patches made" in capsys.readouterr().out


def test_the_api_does_the_same(square, tmp_path):
    result = build(square, tmp_path / "out")
    assert result.exit_status == 0
    assert result.report == read_report(tmp_path / "out")
    _, network = check(square)
    assert [patch.name for patch in network.patches] == ["top"]
    square.write_text(SQUARE.replace("around", "arround"))
    with pytest.raises(ProjectError, match="did you mean 'around'"):
        build(square, tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_how_many_workers_is_a_number_from_1(square, capsys):
    for text in ("0", "-1", "two"):
        with pytest.raises(SystemExit) as ended:
            main(["build", str(square), "--workers", text])
        assert ended.value.code == 2
        assert "--workers: expected a whole number from 1" in capsys.readouterr().err


def test_check_fits_and_writes_nothing(square, tmp_path, capsys):
    before = files_in(tmp_path)
    assert main(["check", str(square)]) == 0
    assert "top: 20 boundary edges along rim" in capsys.readouterr().out
    assert files_in(tmp_path) == before


@pytest.mark.parametrize(
    "old, new, place, words",
    [
        ("edge_length: 20", "edge_lenght: 20", ":3:1:", "did you mean 'edge_length'?"),
        ("around: [rim]", "around: [rin]", ":7:", "did you mean 'rim'?"),
        ("width: 500", "width: wide", ":9:", "expected"),
        ("name: square", "name: [", ":", ""),
        ("curves:", "\tcurves:", ":4:", ""),
    ],
)
def test_a_bad_project_is_explained_and_nothing_is_written(square, tmp_path, capsys, old, new, place, words):
    square.write_text(SQUARE.replace(old, new))
    assert main(["build", str(square), "-o", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert f"{square}{place}" in message and words in message and "Traceback" not in message
    assert not (tmp_path / "out").exists()


def test_a_project_that_is_not_there(tmp_path, capsys):
    assert main(["build", str(tmp_path / "none.yaml"), "-o", str(tmp_path / "out")]) == 2
    assert "none.yaml" in capsys.readouterr().err


def test_an_output_folder_with_foreign_files_is_refused(square, tmp_path, capsys):
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "letter.txt").write_text("dear")
    assert main(["build", str(square), "-o", str(tmp_path / "home")]) == 2
    assert "letter" not in capsys.readouterr().out
    assert files_in(tmp_path / "home") == {"letter.txt": b"dear"}


def test_a_second_build_leaves_nothing_of_the_first(square, tmp_path):
    out = tmp_path / "out"
    assert main(["build", str(square), "-o", str(out)]) == 0
    square.write_text(SQUARE.replace("top:", "lid:"))
    assert main(["build", str(square), "-o", str(out)]) == 0
    assert sorted(files_in(out)) == sorted(read_report(out)["files"])
    assert "pieces/lid.svg" in files_in(out) and "pieces/top.svg" not in files_in(out)


def test_materials_whose_sheets_would_share_a_file_name_keep_all_their_pieces(tmp_path):
    """Two sheets of `denim`, the second drawn in layout-denim-2.svg, and a material called `denim-2`."""
    other = "{closed: true, points: [[300, 0, 0], [400, 0, 0], [400, 90, 0]], normals: [0, 0, 1]}"
    text = SQUARE.replace("[rim], grain", "[rim], material: denim, cut: 2, grain")
    text = text.replace("cloth: {width: 500}", "denim: {width: 120, length: 150}\n  denim-2: {width: 500}")
    text = text.replace("patches:\n", f"  other: {other}\npatches:\n")
    side = "  side: {around: [other], material: denim-2, grain: [1, 0, 0]}\nrest: openings\n"
    text = text.replace("materials:\n", f"{side}materials:\n") + "nesting: {seconds: 1}\n"
    (tmp_path / "project.yaml").write_text(text)
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    layouts = read_report(tmp_path / "out")["layouts"]
    assert len({layout["file"] for layout in layouts}) == len(layouts) == 3
    drawn = [(tmp_path / "out" / layout["file"]).read_text().count('class="piece"') for layout in layouts]
    assert drawn == [1, 1, 1]


def command(*arguments):
    return [sys.executable, "-m", "flatnet", *map(str, arguments)]


@pytest.mark.skipif(os.name == "nt", reason="signals of a process group")
@pytest.mark.parametrize(
    "moment, ending, to_all",
    [
        ("[1/7]", signal.SIGINT, True),
        ("[1/7]", signal.SIGINT, False),
        ("nesting", signal.SIGINT, True),
        ("nesting", signal.SIGINT, False),
        ("[1/7]", signal.SIGTERM, False),
        ("nesting", signal.SIGTERM, False),
    ],
)
def test_an_interrupted_build_leaves_the_earlier_one_as_it_was(square, tmp_path, moment, ending, to_all):
    """While processes of their own fit patches, and while the nesting engine works in one, which end too.

    Ctrl-C on a terminal reaches the whole group of processes; `kill` reaches one.
    """
    out = tmp_path / "out"
    assert main(["build", str(square), "-o", str(out)]) == 0
    before = files_in(out)
    process = subprocess.Popen(
        command("build", ROOT / "projects/bag/project.yaml", "-o", out),
        stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True,
    )
    assert process.stderr is not None
    for line in process.stderr:
        if moment in line:
            break
    time.sleep(0.5 if moment == "nesting" else 0.05)
    (os.killpg if to_all else os.kill)(process.pid, ending)
    stopped = time.monotonic()
    _, message = process.communicate(timeout=20)
    assert process.returncode == 130
    assert time.monotonic() - stopped < 3  # a second, on a machine that does nothing else
    assert "interrupted" in message and "Traceback" not in message
    assert files_in(out) == before
    assert ends_within(5, process.pid)


@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("moment", ["numpy", "scipy", "networkx", "trimesh", "flatnet.build"])
def test_an_interrupt_while_libraries_are_imported_ends_with_one_line(square, tmp_path, moment, ending):
    """Some of them swallow the exception that Ctrl-C is, others end in a traceback. `-v` tells what is imported."""
    process = subprocess.Popen(
        [sys.executable, "-v", *command("build", square, "-o", tmp_path / "out")[1:]],
        stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("# code object from") and f"{moment.replace('.', '/')}" in line:
            break
    process.send_signal(ending)
    _, rest = process.communicate(timeout=20)
    assert process.returncode == 130
    assert rest.splitlines()[-1] == "interrupted; nothing was written." and "Traceback" not in rest
    assert not (tmp_path / "out").exists()


def test_build_is_a_function_whatever_was_imported_before():
    """Of the package, although its module has the same name; and nothing heavy comes with the package alone."""
    lines = (
        "import sys, flatnet; assert 'numpy' not in sys.modules",
        "from flatnet.build import check; import flatnet.build; assert callable(flatnet.build)",
        "from flatnet import ProjectError, build; assert build is flatnet.build",
        "import flatnet as f; f.check; f.OutputError; f.BuildResult; f.no_such_name",
    )
    done = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1] == "AttributeError: module 'flatnet' has no attribute 'no_such_name'"


def ends_within(seconds, group):
    """Whether no process of a group is left; one that was killed is there until the system has cleared it up."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def test_two_builds_at_once_into_one_folder_leave_one_whole_build(square, tmp_path):
    out = tmp_path / "out"
    other = tmp_path / "other.yaml"
    other.write_text(SQUARE.replace("top:", "lid:"))
    builds = [
        subprocess.Popen(command("build", file, "-o", out), stderr=subprocess.PIPE, stdout=subprocess.PIPE)
        for file in (square, other)
    ]
    said = [build.communicate(timeout=60)[1] for build in builds]
    assert [build.returncode for build in builds] == [0, 0], said
    (patch,) = read_report(out)["patches"]
    assert sorted(files_in(out)) == sorted(read_report(out)["files"])
    assert (out / "pieces" / f"{patch['name']}.svg").exists()


@pytest.mark.skipif(os.name == "nt", reason="pipes of a shell")
def test_nobody_listening_stops_no_build(square, tmp_path):
    """`flatnet build ... 2>&1 | head -0`: the reader goes, the pieces come."""
    reader, writer = os.pipe()
    os.close(reader)
    build = subprocess.run(command("build", square, "-o", tmp_path / "out"), stdout=writer, stderr=writer, check=False)
    os.close(writer)
    assert build.returncode == 0
    assert sorted(files_in(tmp_path / "out")) == sorted(read_report(tmp_path / "out")["files"])


def test_a_console_that_lacks_a_letter_shows_its_number(tmp_path):
    file = tmp_path / "Kissen für Zoë.yaml"
    file.write_text(SQUARE.replace("name: square", "name: Größe").replace("\n", "\r\n"), encoding="utf-8", newline="")
    console = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command("check", file), capture_output=True, text=True, env=console, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Gr\\xf6\\xdfe: " in done.stdout


def test_a_mesh_is_looked_for_beside_the_project(tmp_path, monkeypatch, capsys):
    """Wherever the command is run."""
    (tmp_path / "project").mkdir()
    trimesh.creation.box([300, 300, 1]).export(tmp_path / "project" / "table.stl")
    text = SQUARE.replace("curves:", "surface: {mesh: table.stl}\ncurves:")
    (tmp_path / "project" / "project.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    assert main(["check", "project/project.yaml"]) == 0
    (tmp_path / "project" / "table.stl").rename(tmp_path / "table.stl")
    assert main(["check", "project/project.yaml"]) == 2
    assert "a path is relative to the project file" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["biuld", "x.yaml"], ["build"], ["draw"]])
def test_a_command_that_is_none_shows_how_it_goes(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert "usage: flatnet" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="terminals of Unix")
def test_on_a_terminal_a_bar_moves_and_is_gone_at_the_end(square, tmp_path):
    import pty

    screen, terminal = pty.openpty()
    build = subprocess.Popen(
        command("build", square, "-o", tmp_path / "out"), stderr=terminal, stdout=subprocess.PIPE,
        env={**os.environ, "TERM": "xterm"},
    )
    os.close(terminal)
    parts = []
    with suppress(OSError):  # nobody writes any more
        while part := os.read(screen, 1 << 20):
            parts.append(part)
    os.close(screen)
    build.communicate(timeout=60)
    shown = b"".join(parts).decode()
    assert build.returncode == 0
    assert "\u2501" in shown and "[1/1]" not in shown
    assert shown.rstrip().endswith("\x1b[2K")  # the bar's line is cleared
