"""The output folder: what an earlier build left goes, what others put there stays, foreign folders are refused."""

import json

import pytest

from flatnet.export.output import REPORT, REPORT_FORMAT, OutputError, OutputFolder


def write(folder, **files):
    """A build of some files, and the report that lists them."""
    output = OutputFolder(folder)
    names = [name.replace("__", "/").replace("_", ".") for name in files]
    for name, text in zip(names, files.values(), strict=True):
        (output.staging / name).parent.mkdir(exist_ok=True)
        (output.staging / name).write_text(text)
    names.append(REPORT)
    (output.staging / REPORT).write_text(json.dumps({"format": REPORT_FORMAT, "files": names}))
    output.commit(names)


def files_in(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_nothing_of_an_earlier_build_survives_and_nothing_else_is_touched(tmp_path):
    out = tmp_path / "out"
    write(out, pieces__old_svg="1", network_json="1")
    (out / "notes.txt").write_text("mine")
    write(out, patches__new_obj="2", network_json="2")
    assert files_in(out) == ["network.json", "notes.txt", "patches/new.obj", REPORT]
    assert (out / "network.json").read_text() == "2"
    assert not (out / "pieces").exists()


def test_what_was_not_committed_leaves_the_earlier_build_as_it_was(tmp_path):
    write(tmp_path / "out", network_json="1")
    before = {name: (tmp_path / "out" / name).read_text() for name in files_in(tmp_path / "out")}
    output = OutputFolder(tmp_path / "out")
    (output.staging / "network.json").write_text("half")
    output.discard()
    assert {name: (tmp_path / "out" / name).read_text() for name in files_in(tmp_path / "out")} == before


def test_a_folder_with_foreign_files_is_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputError, match=r"holds files, but no report\.json"):
        OutputFolder(tmp_path)
    assert files_in(tmp_path) == ["thesis.tex"]
    with pytest.raises(OutputError, match="is a file"):
        OutputFolder(tmp_path / "thesis.tex")


def test_a_report_that_lists_files_elsewhere_deletes_none_of_them(tmp_path):
    out = tmp_path / "out"
    write(out, network_json="1")
    (tmp_path / "precious").write_text("keep")
    report = {"format": REPORT_FORMAT, "files": ["../precious", str(tmp_path / "precious"), "network.json"]}
    (out / REPORT).write_text(json.dumps(report))
    write(out, patches__p_obj="2")
    assert (tmp_path / "precious").read_text() == "keep"
    assert files_in(out) == ["patches/p.obj", REPORT]
