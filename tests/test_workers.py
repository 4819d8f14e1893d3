"""Worker processes: one that hangs, crashes or eats memory is replaced, and the other tasks do not notice."""

import os
import subprocess
import sys
import time

import numpy as np
import psutil
import pytest
import yaml
from failure_cases import closed, project, square
from misbehaving import do, read_only
from misfitting import fit
from threadpoolctl import threadpool_limits
from written import read_report

from flatnet import build, check
from flatnet.export.obj import write_obj
from flatnet.fitting.run import run_patch
from flatnet.parameters import FairParameters, Limits
from flatnet.workers import Lost, Workers

SHORT = Limits(seconds=3, memory=300)


def results_of(function, tasks, count=2, limits=SHORT):
    with Workers(function, count, limits) as crew:
        found = dict(crew.run(tasks))
    assert sorted(found) == list(range(len(tasks)))
    return [found[i] for i in range(len(tasks))]


#: Deed -> why its task is lost, and what is said about how its process ended.
REASONS = {
    "hang": ("time", ""),
    "crash_in_c": ("itself", ""),
    "eat": ("memory", ""),
    "leave": ("itself", "exit status 3"),
    "refuse": ("itself", "exit status 1"),
}
if os.name != "nt":
    REASONS["crash"] = ("itself", "signal SIGSEGV")


@pytest.mark.parametrize("count", [1, 2])
def test_a_lost_task_costs_no_other(count):
    tasks = [task for i, deed in enumerate(REASONS) for task in (("", 2 * i), (deed, -1), ("", 2 * i + 1))]
    results = results_of(do, tasks, count)
    kept = [result[0] for (deed, _), result in zip(tasks, results, strict=True) if not deed]
    assert kept == list(range(2 * len(REASONS)))
    lost = {deed: result for (deed, _), result in zip(tasks, results, strict=True) if deed}
    assert all(isinstance(result, Lost) for result in lost.values())
    for deed, (reason, words) in REASONS.items():
        assert lost[deed].reason == reason and words in lost[deed].ending
    assert "RuntimeError: not today" in lost["refuse"].details
    assert "misbehaving.py" in lost["crash_in_c"].details  # the place in the Python code
    assert SHORT.seconds <= lost["hang"].seconds < SHORT.seconds + 2
    assert SHORT.memory < lost["eat"].megabytes < SHORT.memory + 1500


def test_processes_are_kept_and_what_is_printed_gets_not_among_the_answers():
    results = results_of(do, [("chatter" if i % 2 else "", i) for i in range(20)])
    assert [value for value, _ in results] == list(range(20))
    assert 1 <= len({process for _, process in results}) <= 2


def test_read_only_arrays_come_and_go_as_they_are():
    array = np.arange(12.0).reshape(3, 4).T
    array.setflags(write=False)
    ((came_read_only, returned),) = results_of(read_only, [(array,)])
    assert came_read_only and not returned.flags.writeable
    assert np.array_equal(returned, array)


def test_a_function_that_cannot_be_had_loses_its_tasks_and_says_why():
    """A module that the parent knows and a new process doesn't."""
    module = type(sys)("gone")
    exec("def f(x): return x", module.__dict__)
    sys.modules["gone"] = module
    try:
        results = results_of(module.f, [(1,), (2,)])
    finally:
        del sys.modules["gone"]
    assert all("No module named 'gone'" in lost.details for lost in results)


def test_no_process_is_left_when_the_work_is_broken_off():
    me = psutil.Process()
    with pytest.raises(KeyboardInterrupt), Workers(do, 2, SHORT) as crew:
        started = time.monotonic()
        for _ in crew.run([("", 0), ("hang", 1), ("hang", 2)]):
            assert len(me.children()) == 2
            started = time.monotonic()
            raise KeyboardInterrupt
    assert time.monotonic() - started < 1
    assert me.children() == []


@pytest.mark.skipif(os.name == "nt", reason="kill -9")
def test_a_parent_that_is_killed_takes_its_processes_along():
    code = (
        "from misbehaving import do; from flatnet.workers import *\n"
        "with Workers(do, 1, Limits()) as crew:\n"
        "    for i, result in crew.run([('', 1), ('hang', 2)]): print(result[1], flush=True)\n"
    )
    path = os.pathsep.join([os.path.dirname(__file__), *filter(None, sys.path)])
    parent = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": path}
    )
    assert parent.stdout is not None
    child = psutil.Process(int(parent.stdout.readline()))
    parent.kill()
    parent.communicate()
    child.wait(timeout=5)


def saddle(x):
    t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.c_[x + 50 * np.cos(t), 50 * np.sin(t), 15 * np.cos(2 * t)]
    return closed(ring, np.c_[-0.6 * np.cos(t), 0.6 * np.sin(t), np.ones(40)])


GOOD = {"a": saddle(200), "b": square(80.0, 400.0), "c": saddle(600)}


def write_project(folder, bad=(), **rest):
    curves = GOOD | {name: square(90.0, 1000.0 + 200 * i) for i, name in enumerate(bad)}
    text = yaml.safe_dump(project(curves, {name: {"around": [name]} for name in curves}, **rest), sort_keys=False)
    (folder / "project.yaml").write_text(text)
    return folder / "project.yaml"


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The good patches, fitted in this process."""
    _, network = check(write_project(tmp_path_factory.mktemp("good")))
    with threadpool_limits(limits=1, user_api="blas"):  # as in a worker: sums depend on the number of threads
        return {patch.name: run_patch(patch, FairParameters()) for patch in network.patches}


@pytest.mark.parametrize("count", [1, 3])
def test_every_other_patch_is_delivered_the_same_to_the_last_bit(alone, count, tmp_path):
    """As fitted in this process, whatever happens beside it and however many processes there are."""
    bad = ("hang", "crash_in_c", "eat")
    file = write_project(tmp_path, bad, limits={"seconds": 5, "memory": 300})
    result = build(file, tmp_path / "out", workers=count, fit=fit)
    report = read_report(tmp_path / "out")
    assert (result.exit_status, report["status"]) == (1, "partial")
    records = {record["name"]: record for record in report["patches"]}
    assert list(records) == ["good", "a", "b", "c", *bad]
    codes = {name: record["failure"]["code"] for name, record in records.items() if record["failure"]}
    assert codes == {"hang": "time_limit", "crash_in_c": "internal_error", "eat": "internal_error"}
    hang, eat = records["hang"]["failure"], records["eat"]["failure"]
    assert (hang["unit"], eat["unit"]) == ("s", "MB")
    assert 5 <= hang["amount"] < 8 and "limits: {seconds" in hang["remedy"]
    assert eat["amount"] > 300 and "limits: {memory" in eat["remedy"]
    for name, fitted in alone.items():
        write_obj(tmp_path / "expected.obj", fitted.mesh.vertices, fitted.mesh.triangles, fitted.flat)
        assert (tmp_path / "out/patches" / f"{name}.obj").read_bytes() == (tmp_path / "expected.obj").read_bytes()


def test_no_workers_are_refused(tmp_path):
    with pytest.raises(ValueError, match="workers must be at least 1, got 0"):
        build(write_project(tmp_path), tmp_path / "out", workers=0)


def test_a_plain_script_can_build(tmp_path):
    """Without `if __name__ == "__main__"`, and where the working directory has a module called like one of Python's."""
    file = write_project(tmp_path)
    (tmp_path / "queue.py").write_text("raise SystemExit('the wrong queue')")
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts" / "script.py").write_text(f"import flatnet\nprint(flatnet.build({str(file)!r}, 'out'))\n")
    path = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [sys.executable, tmp_path / "scripts" / "script.py"], capture_output=True, text=True, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path}, check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert read_report(tmp_path / "out")["status"] == "ok"
