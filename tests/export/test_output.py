"""The output folder: what an earlier build left goes, what others put there stays, foreign folders are refused."""

import json
import os
import signal

import pytest

from flatnet.export.output import REPORT, REPORT_FORMAT, OutputError, OutputFolder


def write(folder, **files):
    """A build of some files, and the report that lists them."""
    with OutputFolder(folder) as output:
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
    with pytest.raises(KeyboardInterrupt), OutputFolder(tmp_path / "out") as output:
        (output.staging / "network.json").write_text("half")
        raise KeyboardInterrupt
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


def test_a_first_build_that_was_not_committed_leaves_no_folder(tmp_path):
    with pytest.raises(KeyboardInterrupt), OutputFolder(tmp_path / "out"):
        raise KeyboardInterrupt
    assert not (tmp_path / "out").exists()


def test_a_build_killed_while_files_are_moved_is_cleared_up_by_the_next(tmp_path):
    """The report is gone, one old and one new file lie there, and the manifest tells that they are ours."""
    out = tmp_path / "out"
    write(out, pieces__old_svg="1", network_json="1")
    staging = out / ".flatnet-unfinished-x"
    staging.mkdir()
    (staging / "manifest.json").write_text(json.dumps(["pieces/old.svg", "network.json", "pieces/new.svg", REPORT]))
    (out / REPORT).unlink()
    (out / "pieces" / "new.svg").write_text("2")
    write(out, network_json="3")
    assert [name for name in files_in(out) if not name.startswith(".flatnet")] == ["network.json", REPORT]


def test_two_builds_at_once_leave_one_of_them_whole(tmp_path):
    """Neither sees the other's unfinished files, and nothing is left of the one that ends first."""
    out = tmp_path / "out"
    with OutputFolder(out) as slow:
        write(out, pieces__quick_svg="quick", network_json="quick")
        names = ["pieces/slow.svg", "network.json", REPORT]
        (slow.staging / "pieces").mkdir()
        for name in names:
            (slow.staging / name).write_text(json.dumps({"format": REPORT_FORMAT, "files": names}))
        slow.commit(names)
    assert files_in(out) == sorted(names)
    assert "quick" not in (out / "network.json").read_text()


def test_an_empty_folder_or_a_link_to_one_stays_where_nothing_was_committed(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "link").symlink_to("empty")
    for name in ("empty", "link"):
        with pytest.raises(KeyboardInterrupt), OutputFolder(tmp_path / name):
            raise KeyboardInterrupt
        assert files_in(tmp_path / name) == [] and (tmp_path / name).is_dir()


@pytest.mark.skipif(os.name == "nt", reason="signals sent to this process")
@pytest.mark.parametrize("ending", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_does_not_stop_the_moving_of_files_half_way(tmp_path, monkeypatch, ending):
    out = tmp_path / "out"
    write(out, network_json="1")
    replace = os.replace

    def interrupted_replace(source, target):
        os.kill(os.getpid(), getattr(signal, ending))
        replace(source, target)

    monkeypatch.setattr(os, "replace", interrupted_replace)
    write(out, layout_json="2", network_json="2")
    assert files_in(out) == ["layout.json", "network.json", REPORT]


def test_what_the_system_says_is_passed_on(tmp_path):
    with pytest.raises(OutputError, match="can't be written: No space left"), OutputFolder(tmp_path / "out"):
        raise OSError(28, "No space left on device")
