"""How full layouts get: published strips against the engine alone, and a hide filled with the pieces of a shoe."""

from __future__ import annotations

import json
import os
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import spyrrow

from flatnet.build import build
from flatnet.export.pieces_json import read_pieces
from flatnet.nesting import check_layouts, nest
from flatnet.nesting.instance import read_instance
from flatnet.nesting.layout import copies_of
from flatnet.parameters import NestingParameters
from flatnet.pattern.piece import Piece
from flatnet.project.hides import Hide, Ring
from flatnet.project.model import Material
from tests.benchmark.run import Options, in_child

ROOT = Path(__file__).parents[2]
#: Where the published problems lie, one JSON file each; see `flatnet nest`.
PUBLISHED = ROOT.parent / "shared" / "data" / "nesting"
NAMES = ("shirts", "trousers", "swim", "albano", "marques")
SECONDS, SECONDS_QUICK = 10, 2
#: The engine works against the clock: two runs of one seed differ by up to a point. So means of runs are compared.
RUNS, RUNS_QUICK = 4, 1
#: Points that a layout may be less dense than the engine's own, %.
SHORT = 0.5
#: The hide: seed of its outline, mean radii, mm; density wanted in 30 s, %; what the engine has of them, s; gap, mm.
SEED, RADII, HIDE_WANTED, HIDE_ENGINE, HIDE_GAP = 5, (650.0, 450.0), 65.0, 22, 1.0
#: Sets of the shoe's pieces, left and right, that are offered: more than go on it.
SETS = 10


def run(options: Options) -> dict[str, Any]:
    strips = _strips(options) if PUBLISHED.is_dir() else []
    if not strips:
        options.say(f"no published problems in {PUBLISHED}")
    return {"strips": strips, "hide": _hide(options)}


def _strips(options: Options) -> list[dict[str, Any]]:
    seconds = SECONDS_QUICK if options.quick else SECONDS
    records = []
    for name in NAMES:
        file = PUBLISHED / f"{name}.json"
        pieces, material = read_instance(file)
        alone, ours, valid = [], [], True
        for seed in range(RUNS_QUICK if options.quick else RUNS):
            alone.append(in_child(engine_alone, str(file), seconds, seed).result)
            (layout,), findings = nest(pieces, material, NestingParameters(seconds=seconds, seed=seed))
            ours.append(100.0 * layout.utilisation)
            valid &= not check_layouts([layout], pieces) and not findings
        record = {"name": name, "alone": alone, "ours": ours, "valid": valid, "load": os.getloadavg()[0]}
        record["good"] = valid and float(np.mean(ours)) >= float(np.mean(alone)) - SHORT
        records.append(record)
    options.table(
        f"Published strips, {seconds} s each, {len(alone)} seeds: mean density (least to most), %",
        ["problem", "engine alone", "flatnet", "valid", f"alone - {SHORT:g} or more", "load"],
        [[r["name"], _spread(r["alone"]), _spread(r["ours"]), r["valid"], r["good"], r["load"]] for r in records],
    )
    return records


def _spread(values: list[float]) -> str:
    return f"{np.mean(values):.1f} ({min(values):.1f} to {max(values):.1f})"


def engine_alone(file: str, seconds: int, seed: int) -> float:
    """Density that the engine says it reached with the file's own numbers, %."""
    content = json.loads(Path(file).read_text(encoding="utf-8"))
    outlines = [[tuple(point) for point in item["shape"]["data"][:-1]] for item in content["items"]]
    items = [
        spyrrow.Item(str(i), outlines[i], item["demand"], item["allowed_orientations"])
        for i, item in enumerate(content["items"])
    ]
    instance = spyrrow.StripPackingInstance(content["name"], content["strip_height"] * 1.0001, items)
    solution = instance.solve(
        spyrrow.StripPackingConfig(early_termination=False, total_computation_time=seconds, num_workers=2, seed=seed)
    )
    area = sum(item["demand"] * shapely.Polygon(item["shape"]["data"]).area for item in content["items"])
    return 100.0 * area / (content["strip_height"] * solution.width)


def a_hide() -> Hide:
    """A smooth outline with two defects, a round and a long one."""
    random = np.random.default_rng(SEED)
    angle = 2.0 * np.pi * np.arange(90) / 90.0
    radius = 1.0 + sum(
        random.uniform(0.03, 0.08) * np.cos(k * angle + random.uniform(0.0, 2.0 * np.pi)) for k in (2, 3, 4, 7)
    )
    outline = np.column_stack([np.cos(angle), np.sin(angle)]) * radius[:, None] * RADII
    outline -= outline.min(axis=0)
    length, width = outline.max(axis=0)
    scar = np.column_stack([70.0 * np.cos(angle[::6]), 30.0 * np.sin(angle[::6])])
    brand = np.column_stack([40.0 * np.cos(angle[::6]), 40.0 * np.sin(angle[::6])])
    return Hide(
        _ring(outline),
        (_ring(brand + (0.28 * length, 0.56 * width)), _ring(scar + (0.6 * length, 0.35 * width))),
    )


def _ring(points: Any) -> Ring:
    return tuple((float(x), float(y)) for x, y in points)


def shoe_pieces(folder: Path) -> list[Piece]:
    """Of one shoe and, mirrored, the other."""
    build(ROOT / "projects" / "shoe_2" / "project.yaml", folder)
    return list(read_pieces(folder / "pieces.json").pieces.values())


def _hide(options: Options) -> dict[str, Any]:
    hide = a_hide()
    length, width = hide.size
    material = Material("leather", width, length, None, HIDE_GAP, hides=(hide,))
    with tempfile.TemporaryDirectory() as folder:
        made = shoe_pieces(Path(folder) / "out")
    pieces = [replace(piece, cut=SETS, mirrored=SETS, material="leather") for piece in made]
    engine = SECONDS_QUICK if options.quick else HIDE_ENGINE
    start, cpu = time.perf_counter(), time.process_time()
    (layout,), _ = nest(pieces, material, NestingParameters(seconds=engine))
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    placed = {(p.piece.name, p.copy) for p in layout.placements}
    left = [copy for copy in copies_of(pieces) if (copy.piece.name, copy.number) not in placed]
    record = {
        "reached": 100.0 * layout.utilisation,
        "pieces": len(layout.placements),
        "valid": not check_layouts([layout], pieces, left) and not layout.draft,
        "engine_seconds": engine,
        "seconds": seconds,
        "own_cpu_seconds": cpu,
        "load": os.getloadavg()[0],
    }
    options.table(
        f"A hide of {hide.area / 1e6:.2f} m^2 with two defects, filled with the pieces of shoe_2, gap {HIDE_GAP:g} mm",
        ["", "reached, %", "wanted, %", "pieces", "valid", "s in all", "s of the engine", "own CPU s", "load"],
        [["hide", f"{record['reached']:.1f}", HIDE_WANTED, *list(record.values())[1:3],
          seconds, engine, cpu, record["load"]]],
    )  # fmt: skip
    return record
