"""What is decided once for a seam and carried to every piece along it."""

from __future__ import annotations

from dataclasses import dataclass

from flatnet.network.network import CurveNetwork
from flatnet.project.model import Project, SeamSpec


@dataclass(frozen=True, eq=False)
class Seam:
    """A stretch of a curve that at least one patch runs along.

    Attributes
    ----------
    number : seams count from 1, in the order of the project; printed where the name is too long.
    curve : the curve that it is a stretch of.
    spec : how pieces are cut along it.
    """

    name: str
    number: int
    curve: str
    spec: SeamSpec


def plan_seams(project: Project, network: CurveNetwork) -> dict[str, Seam]:
    """The seams of a project by name, in its order."""
    used = {stretch.seam for patch in network.patches for stretch in patch.boundary.stretches}
    names = [name for name in network.stretches if name in used]
    seams = {}
    for number, name in enumerate(names, start=1):
        curve = network.stretches[name].curve
        seams[name] = Seam(name, number, curve, project.curves[curve].seam)
    return seams
