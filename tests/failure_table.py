"""Run every case, then its remedy, and write what came of both into docs/failures.md, with pictures: `make failures`.

`python tests/failure_table.py CODE ...` runs and draws these codes alone; the other rows stay.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from failure_cases import CASES, Case, project, square
from failure_pictures import draw, outlines
from misfitting import fit

from flatnet.build import build
from flatnet.diagnosis import diagnose_project
from flatnet.failure import CODES, Finding
from flatnet.fitting.run import run_patch
from flatnet.network.boundaries import open_gap
from flatnet.network.graph import Dart
from flatnet.network.network import SampledStretch
from flatnet.network.patch import BoundaryCurve, Patch, Stretch
from flatnet.parameters import FairParameters
from flatnet.project import ProjectError
from flatnet.project.drawings import FileCurve
from flatnet.project.drawings.joining import join_curves
from flatnet.remedies.paste import paste

PAGE = Path(__file__).parents[1] / "docs" / "failures.md"
PICTURES = PAGE.parent / "pictures" / "failures"
BEGIN, END = "<!-- table: make failures -->", "<!-- end of table -->"
HEAD = "| code | case | detected | remedy tried | result after it |\n|---|---|---|---|---|"


@dataclass(frozen=True)
class Row:
    """What the table says of one code."""

    code: str
    case: str
    detected: str
    remedy: str
    result: str

    def __str__(self) -> str:
        return f"| `{self.code}` | {self.case} | {self.detected} | {self.remedy} | {self.result} |"


@dataclass(frozen=True)
class Outcome:
    """A build: its report, or why there is none."""

    report: dict[str, Any] | None
    problems: str = ""

    def findings(self) -> Iterator[dict[str, Any]]:
        """Failures, warnings of patches and of seams, and those of imports and nesting."""
        if self.report is None:
            return
        for patch in self.report["patches"]:
            yield from ([patch["failure"]] if patch["failure"] else [])
            yield from patch["warnings"]
        for seam in (*self.report["seams"], *self.report["seam_walk"]):
            yield from seam["warnings"]
        yield from self.report["findings"]

    @property
    def failed(self) -> list[str]:
        """The patches that could not be made."""
        return [patch["name"] for patch in self.report["patches"] if patch["failure"]] if self.report else []

    def of(self, code: str) -> list[dict[str, Any]]:
        return [finding for finding in self.findings() if finding["code"] == code]

    def detected(self, code: str) -> str:
        """Where it was found and how much, or that it was not."""
        if self.report is None:
            return "project file, exit status 2" if f"{code}: " in self.problems else f"not found: {self.problems}"
        found = self.of(code)
        if not found:
            return "not found"
        return said(found[0]["stage"], found[0]["amount"], found[0]["unit"])

    def result(self, code: str) -> str:
        """What was made, and what is left to be said."""
        if self.report is None:
            return self.problems
        patches = self.report["patches"]
        made = sum(patch["status"] == "ok" for patch in patches)
        # Whether the engine is done in its second depends on what else the machine does.
        left = [one["code"] for one in self.findings() if one["code"] not in (code, "draft_layout")]
        words = [f"{made} of {len(patches)} made"]
        if self.of(code):
            words.append(f"`{code}` remains: {self.detected(code)}")
        if left:
            words.append(f"with {', '.join(f'`{name}`' for name in dict.fromkeys(left))}")
        return "; ".join(words)


def said(stage: str, amount: float | None, unit: str) -> str:
    return stage if amount is None else f"{stage}, {amount:.3g} {unit}".rstrip()


def row(code: str, pictures: bool = False) -> Row:
    """Run the case of a code, then its remedy; draw both where the page shows them."""
    if code in BY_HAND:
        return BY_HAND[code](code)
    with tempfile.TemporaryDirectory() as name:
        folder, case = Path(name), CASES[code]
        content = case.content(folder)
        before = built(folder / "before", content, case.split)
        failed = outlines(folder / "project.yaml", before.failed)
        after = cured(folder / "after", case, content)
        found = Row(code, case.words, before.detected(code), case.remedy, after.result(code))
        picture = PICTURES / f"{code}.png"
        if pictures and f"({picture.relative_to(PAGE.parent).as_posix()})" in PAGE.read_text(encoding="utf-8"):
            draw(picture, folder / "before", folder / "after", failed)
    return found


def built(out: Path, content: dict[str, Any], split: bool = False, **rest: Any) -> Outcome:
    file = out.with_name("project.yaml")
    file.write_text(yaml.safe_dump(content, sort_keys=False))
    try:
        return Outcome(build(file, out, workers=1, split=split, **rest).report)
    except ProjectError as error:
        return Outcome(None, error.problems[0].message)


def cured(out: Path, case: Case, content: dict[str, Any]) -> Outcome:
    if case.cure == "split":
        content["patches"] = {
            name: {key: value for key, value in patch.items() if key != "planar_boundary"}
            for name, patch in content["patches"].items()
        }
        return built(out, content, split=True)
    if case.cure in ("cut", "seam"):
        return built(out, pasted(out.parent, content))
    assert callable(case.cure)
    return built(out, case.cure(content))


def pasted(folder: Path, content: dict[str, Any]) -> dict[str, Any]:
    """The project with what `flatnet diagnose --patch` prints of its last patch."""
    name = list(content["patches"])[-1]
    (folder / "project.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    found = diagnose_project(folder / "project.yaml", [name], workers=1)
    [one] = [*found.diagnoses, *found.rings]
    lines = yaml.safe_load(paste(found.project, one))
    patches = {key: patch for key, patch in content["patches"].items() if key != name}
    return content | {
        "nodes": content.get("nodes", {}) | lines.get("nodes", {}),
        "curves": content["curves"] | lines["curves"],
        "patches": patches | lines["patches"],
        "rest": "openings",
    }


def open_boundary(code: str) -> Row:
    """No project file leads to it, whose curves end at nodes: two stretches as another program may give them."""

    def stretch(name: str, *points: tuple[float, float, float]) -> SampledStretch:
        normals = np.tile([0.0, 0.0, 1.0], (len(points) - 1, 1))
        return SampledStretch(name, name, None, None, np.array(points, float), normals, normals)

    def gap(height: float) -> Finding | None:
        there = stretch("a", (0, 0, 0), (3, 0, 0), (3, 4, 0))
        back = stretch("b", (0, 0, 0), (0, 4, 0), (3, height, 0))
        return open_gap("bad", (Dart("a", False), Dart("b", True)), {"a": there, "b": back})

    found = gap(4.25)
    assert found is not None
    result = "closed" if gap(4.0) is None else "open"
    words = "two curves of a network, not of a project file, whose ends miss each other"
    return Row(code, words, said(found.stage, found.amount, found.unit), "both end at one node", result)


def opposed_normals(code: str) -> Row:
    """A project file is refused before: `normal turns by more than 120 degrees`."""
    corners = np.array([[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0.0]])
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))

    def codes(normals: Any) -> list[Finding]:
        rim = (Stretch("rim", 0, 4, False),)
        patch = Patch("bad", BoundaryCurve(corners.copy(), normals, rim, np.zeros(4)), 12.0, "cloth")
        return list(run_patch(patch, FairParameters()).warnings)

    found = next(one for one in codes(normals * [[1], [-1], [1], [1]]) if one.code == code)
    left = [one.code for one in codes(normals)]
    words = "a square of a network, not of a project file, with one normal upside down"
    detected = said(found.stage, found.amount, found.unit)
    return Row(code, words, detected, "all normals on one side", f"1 of 1 made{'; with ' * bool(left)}{left or ''}")


def internal_error(code: str) -> Row:
    content = project({"crash_in_c": square()}, {"crash_in_c": {"around": ["crash_in_c"]}})
    with tempfile.TemporaryDirectory() as name:
        outcome = built(Path(name) / "out", content, fit=fit)
    words = "the process that fits a patch reads at address 0, beside a good patch"
    return Row(code, words, outcome.detected(code), "none", outcome.result(code).split(";")[0])


def sides(gap: float) -> list[FileCurve]:
    """Those of a square, each beginning `gap` mm beyond the end of the one before it."""
    corners = np.array([(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0.0)])
    ends = np.roll(corners, -1, axis=0)
    points = [np.array([a + gap * (b - a) / 100, 0.5 * (a + b), b]) for a, b in zip(corners, ends, strict=True)]
    return [FileCurve(f"side{i}", side) for i, side in enumerate(points)]


def line(name: str, *points: tuple[float, float, float]) -> FileCurve:
    return FileCurve(name, np.array(points, float))


#: Code -> words, curves and options of `join_curves`; the same of the remedy.
DRAWINGS: dict[str, tuple[str, list[FileCurve], dict[str, Any], str, list[FileCurve], dict[str, Any]]] = {
    "snapped_end": (
        "a drawn square whose sides miss each other by 0.3 mm, `snap: 0.4`", sides(0.3), {"snap": 0.4},
        "drawn end on end", sides(0.0), {"snap": 0.4},
    ),
    "near_miss": (
        "the same by 0.5 mm", sides(0.5), {"snap": 0.4}, "`snap: 0.6`", sides(0.5), {"snap": 0.6},
    ),
    "crossing_curves": (
        "two drawn lines that pass each other by 0.2 mm",
        [line("a", (-50, 0, 0), (50, 0, 0), (60, 1, 0)), line("b", (0, -50, 0.2), (0, 50, 0.2))], {"snap": 0.3},
        "`join: crossings`",
        [line("a", (-50, 0, 0), (50, 0, 0), (60, 1, 0)), line("b", (0, -50, 0.2), (0, 50, 0.2))],
        {"snap": 0.3, "join_crossings": True},
    ),
    "trimmed_end": (
        "a line that ends inside a drawn square, `trim: true`",
        [*sides(0.0), line("tail", (50, 0, 0), (50, 20, 0))], {"snap": 0.01, "trim": True},
        "drawn to the other side", [*sides(0.0), line("tail", (50, 0, 0), (50, 100, 0))], {"snap": 0.01, "trim": True},
    ),
}  # fmt: skip


def drawing(code: str) -> Row:
    words, before, options, remedy, after, others = DRAWINGS[code]
    found = next(one for one in join_curves(before, **options).findings if one.code == code)
    joined = join_curves(after, **others)
    left = ", ".join(f"`{one}`" for one in dict.fromkeys(one.code for one in joined.findings))
    result = f"{len(joined.curves)} curves, {len(joined.nodes)} nodes{'; with ' * bool(left)}{left}"
    return Row(code, words, said(found.stage, found.amount, found.unit), remedy, result)


BY_HAND: dict[str, Callable[[str], Row]] = {
    "open_boundary": open_boundary,
    "opposed_normals": opposed_normals,
    "internal_error": internal_error,
    **dict.fromkeys(DRAWINGS, drawing),
}


def committed() -> dict[str, Row]:
    """The rows of the page, by code."""
    lines = PAGE.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0].strip().splitlines()[2:]
    cells = [line.removeprefix("| `").removesuffix(" |").replace("` | ", " | ", 1).split(" | ") for line in lines]
    return {code: Row(code, *rest) for code, *rest in cells}


def main(codes: Sequence[str]) -> None:
    rows = committed()
    for code in codes or CODES:
        rows[code] = row(code, pictures=True)
        print(rows[code], flush=True)
        text = PAGE.read_text(encoding="utf-8")
        before, after = text.split(BEGIN)[0], text.split(END)[1]
        table = "\n".join([HEAD, *(str(rows[one]) for one in CODES if one in rows)])
        PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
