"""What the terminal shows of a build or a check: one line per patch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flatnet.network.network import CurveNetwork
from flatnet.pattern.seams import plan_seams
from flatnet.project.model import Project

#: Warnings of one code that the terminal shows, those with the largest amounts.
MOST_SHOWN = 20


def summary_lines(report: dict[str, Any], folder: Path) -> list[str]:
    """One line per patch, failures with what to do, then the layouts and where everything is."""
    width = max((len(patch["name"]) for patch in report["patches"]), default=0)
    lines = [_patch_line(patch, width) for patch in report["patches"]]
    for patch in report["patches"]:
        lines += [f"{patch['name']}: warning {_told(warning)}" for warning in patch["warnings"]]
    for seam in report["seams"]:
        lines += [f"{seam['curve']}: warning {_told(warning)}" for warning in seam["warnings"]]
    lines += _walk_lines(report["seam_walk"])
    lines += _warnings([finding for finding in report["findings"] if not finding["patch"]])
    lines += report.get("export_notes", [])
    lines += [_sheet_line(layout, folder) for layout in report["layouts"]]
    made = sum(patch["status"] == "ok" for patch in report["patches"])
    lines.append(f"{report['status']}: {made} of {len(report['patches'])} patches made; {folder / 'report.json'}")
    return lines


def layout_lines(report: dict[str, Any], folder: Path) -> list[str]:
    """What could not be laid, then the layouts, of a report of layouts alone."""
    lines = [f"{finding['patch']}: FAILED {_told(finding)}" for finding in report["findings"] if finding["patch"]]
    lines += _warnings([finding for finding in report["findings"] if not finding["patch"]])
    lines += [_sheet_line(layout, folder) for layout in report["layouts"]]
    return [*lines, f"{report['status']}: {folder / 'report.json'}"]


def _sheet_line(layout: dict[str, Any], folder: Path) -> str:
    length, width = sheet_size(layout)
    return (
        f"{folder / layout['file']}: {counted(len(layout['pieces']), 'piece')} on "
        f"{'a hide of ' if layout['hide'] else ''}{round(width, 1):g} x {length:.0f} mm, "
        f"{100 * layout['utilisation']:.1f} % used" + (" (draft)" if layout["draft"] else "")
    )


def sheet_size(layout: Mapping[str, Any]) -> tuple[float, float]:
    """Length and width of what is drawn of a layout of the report, mm: the used length of a roll, all of a hide."""
    hide = layout.get("hide")
    length = max(x for x, _ in hide["outline"]) if hide else layout["used_length_mm"]
    return length, layout["sheet_width_mm"]


def _patch_line(patch: dict[str, Any], width: int) -> str:
    name = patch["name"].ljust(width)
    if patch["failure"]:
        return f"{name}  FAILED {_told(patch['failure'])}"
    figures = patch["metrics"]
    strained = (
        f"  strain {100 * figures['max_edge_strain']:.1f} of {100 * figures['strain_limit']:g} %"
        if figures.get("strain_limit")
        else ""
    )
    return (
        f"{name}  ok  {figures['vertices']:5d} V  flat to {figures['max_flattenability_rad']:.0e} rad  "
        f"normals {figures['mean_normal_deviation_deg']:4.1f} deg  bending {figures['bending']:7.1f}  "
        f"wrinkles {figures['wrinkles']['turning_deg']:3.0f} deg  "
        f"fold {figures['max_dihedral_deg']:3.0f} deg  {sum(patch['seconds'].values()):5.2f} s{strained}"
    )


def _walk_lines(walks: Sequence[dict[str, Any]]) -> list[str]:
    """What the walk along both sides of the seams shows: one line for all seams, one for each curve sewn to others."""
    seams = [walk for walk in walks if walk["a"] == walk["b"]]
    lines = []
    if seams:
        worst = max(seams, key=lambda walk: walk["largest_difference_mm"])
        legs = counted(sum(len(walk["legs"]) for walk in seams), "length")
        lines.append(
            f"seam walk: {counted(len(seams), 'seam')}, {legs} from notch to notch, both sides alike to "
            f"{worst['largest_difference_mm']:.1g} mm"
        )
    for walk in walks:
        if walk["a"] != walk["b"]:
            lines.append(f"seam walk: {_eased(walk['a'], walk['length_a_mm'], walk['b'], walk['length_b_mm'])}")
        lines += [f"{walk['a']}: warning {_told(warning)}" for warning in walk["warnings"]]
    return lines


def _eased(first: str, length: float, second: str, plain: float) -> str:
    """A curve on what it is sewn to, and its ease, mm."""
    ease = f"ease {length - plain:.1f} mm ({100.0 * (length / plain - 1.0):.1f} %)"
    return f"{first} {length:.1f} mm on {second} {plain:.1f} mm, {ease}"


def _warnings(findings: Sequence[dict[str, Any]]) -> list[str]:
    """A line for every finding, but for what there are many of: those of the largest amounts."""
    lines = []
    for code in dict.fromkeys(finding["code"] for finding in findings):
        alike = [finding for finding in findings if finding["code"] == code]
        shown = sorted(alike, key=lambda finding: -(finding.get("amount") or 0.0))[:MOST_SHOWN]
        lines += [f"warning {_told(finding)}" for finding in alike if finding in shown]
        if len(alike) > len(shown):
            lines.append(f"warning {code}: {len(alike) - len(shown)} more, all smaller, are in report.json")
    return lines


def _told(finding: dict[str, Any]) -> str:
    return f"{finding['code']}: {finding['message']} {finding['remedy']}".rstrip()


def network_lines(project: Project, network: CurveNetwork) -> list[str]:
    """What `flatnet check` found."""
    lines = []
    for patch in network.patches:
        seams = ", ".join(("-" if s.reversed else "") + s.seam for s in patch.boundary.stretches)
        lines.append(f"{patch.name}: {len(patch.boundary.vertices)} boundary edges along {seams}")
    lines += [str(finding) for finding in network.failed]
    lines += [f"warning {finding}" for finding in project.findings]
    joins = dict.fromkeys(join for seam in plan_seams(project, network).values() for join in seam.joins)
    lines += [
        f"{_eased(str(join.eased), join.eased.length, str(join.plain), join.plain.length)}, declared {join.ease:.1f} mm"
        for join in joins
    ]
    curves = {stretch.curve for stretch in network.stretches.values()}
    euler = ", ".join(map(str, network.euler_characteristics))
    not_fitted = f", of which {len(network.failed)} can't be made" if network.failed else ""
    lines.append(
        f"{project.name}: {counted(len(network.nodes), 'node')}, {counted(len(curves), 'curve')} in "
        f"{counted(len(network.stretches), 'stretch', 'stretches')}, {counted(network.face_count, 'face')} "
        f"({counted(len(project.patches), 'patch', 'patches')}{not_fitted}, "
        f"{counted(len(network.openings), 'opening')}{' and the rest' * project.rest_is_open}), V - E + F = {euler}"
    )
    return lines


def counted(number: int, thing: str, things: str = "") -> str:
    """`1 piece`, `2 pieces`."""
    return f"{number} {thing if number == 1 else things or thing + 's'}"
