"""`flatnet.build` from Python."""

import threading

import pytest
from test_cli import SQUARE
from written import read_report

import flatnet


@pytest.fixture
def square(tmp_path):
    file = tmp_path / "project.yaml"
    file.write_text(SQUARE.replace("cloth: {width: 500}", "cloth: {width: 500}\nnesting: {seconds: 1}"))
    return file


def test_paths_may_be_text_and_the_progress_counts_the_patches(square, tmp_path):
    told = []
    result = flatnet.build(str(square), str(tmp_path / "out"), lambda *news: told.append(news))
    assert result.exit_status == 0
    assert result.report == read_report(tmp_path / "out")
    assert told[0] == ("top", 1, 1)
    assert all((done, total) == (1, 1) for _, done, total in told)
    assert len(repr(result)) < 1000  # a notebook shows it


def test_a_build_in_a_thread(square, tmp_path):
    """Signals can be set in the main thread only."""
    results = []
    worker = threading.Thread(target=lambda: results.append(flatnet.build(square, tmp_path / "out")))
    worker.start()
    worker.join()
    assert [result.exit_status for result in results] == [0]


def test_a_folder_that_is_refused_raises_what_the_package_names(square, tmp_path):
    with pytest.raises(flatnet.OutputError, match="holds files"):
        flatnet.build(square, tmp_path)


def test_an_error_of_the_caller_leaves_nothing_behind(square, tmp_path):
    def stop(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        flatnet.build(square, tmp_path / "out", stop)
    assert not (tmp_path / "out").exists()
