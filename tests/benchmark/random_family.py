"""Two hundred random boundaries: how many are made, what the others failed with, how fair they come out."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flatnet.fitting.results import SurfaceMesh
from tests.benchmark.fits import fit, shortcomings
from tests.benchmark.pictures import mesh_sheet
from tests.benchmark.random_boundaries import EACH, KINDS, random_case
from tests.benchmark.run import Options, map_in_children

#: Boundaries of each kind in a quick run; columns of the contact sheets.
EACH_QUICK, COLUMNS = 4, 16
QUANTITIES = {"E": "bending E", "dihedral": "worst dihedral, degrees", "normals": "mean normal deviation, degrees"}


def run(options: Options) -> dict[str, Any]:
    each = EACH_QUICK if options.quick else EACH
    cases = [(kind, number) for kind in KINDS for number in range(each)]
    results = map_in_children(fitted_case, cases)
    records = [record for record, _ in results]
    rows = []
    for kind in [*KINDS, "all"]:
        of_kind = [record for record in records if kind in (record["kind"], "all")]
        made = [record for record in of_kind if record["status"] == "ok"]
        short = Counter(word for record in made for word in record["short"])
        missed = Counter(record["status"] for record in of_kind if record["status"] != "ok")
        medians = [float(np.median([r[key] for r in made])) if made else None for key in ("vertices", *QUANTITIES)]
        worst = [max((r[key] for r in made), default=None) for key in ("c", "strain", "seconds_all")]
        rows.append([kind, f"{len(made)} / {len(of_kind)}", *medians, *worst, counted(missed), counted(short)])
    columns = ["kind", "made", "V", "E", "dih", "nrm", "worst c", "worst strain", "worst s", "missed", "but short"]
    options.table("Random boundaries (medians of V, E, dihedral, normals)", columns, rows)
    misses = [record for record in records if record["status"] != "ok"]
    for record in misses:
        options.say(f"  {record['name']}: {record['status']}: {record['message']}")
    for record in records:
        if record["status"] == "ok" and record["short"]:
            options.say(f"  {record['name']}: made, but short in {', '.join(record['short'])}")
    sheets = {
        kind: str(mesh_sheet(options.folder / f"random_{kind}.png", [
            (f"{record['name']}: E {record['E']:.0f}", mesh)
            for record, mesh in results if mesh is not None and record["kind"] == kind
        ], COLUMNS))
        for kind in KINDS
    }  # fmt: skip
    return {
        "fits": records,
        "success_rate": 1.0 - len(misses) / len(records),
        "misses": {record["name"]: record["status"] for record in misses},
        "histogram": histogram(options, records),
        "sheets": sheets,
    }


def fitted_case(named: tuple[str, int]) -> tuple[dict[str, Any], SurfaceMesh | None]:
    """One boundary of the family; its record and mesh."""
    kind, number = named
    one = fit(f"{kind}-{number:02}", *random_case(kind, number))
    more = {"kind": kind, "short": shortcomings(one.record), "seconds_all": one.seconds}
    return one.record | more, one.fitted.mesh if one.fitted is not None else None


def counted(words: Counter[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in sorted(words.items())) or "-"


def histogram(options: Options, records: list[dict[str, Any]]) -> str:
    """Of E, dihedrals and normals, stacked by kind."""
    figure = Figure(figsize=(12, 3.2), layout="constrained")
    for axes, (key, label) in zip(figure.subplots(1, len(QUANTITIES)), QUANTITIES.items()):
        values = [[r[key] for r in records if r["status"] == "ok" and r["kind"] == kind] for kind in KINDS]
        axes.hist(values, bins=30, stacked=True, label=list(KINDS))
        axes.set_xlabel(label)
    axes.legend(fontsize=8)
    file = options.folder / "random_histogram.png"
    figure.savefig(file, dpi=110)
    return str(file)
