"""Write network.json: nodes and sampled curves with their edge normals, what the patches were fitted to."""

from __future__ import annotations

import json
from pathlib import Path

from flatnet.network.network import CurveNetwork


def write_network(path: Path, network: CurveNetwork) -> None:
    """mm; `right_normals` stands only where the curve is a crease."""
    curves = []
    for stretch in network.stretches.values():
        record = {
            "name": stretch.name,
            "curve": stretch.curve,
            "from": stretch.start,
            "to": stretch.end,
            "slit": stretch.slit,
            "vertices": stretch.vertices.tolist(),
            "normals": stretch.left_normals.tolist(),
        }
        if stretch.crease:
            record["right_normals"] = stretch.right_normals.tolist()
        curves.append(record)
    nodes = {name: position.tolist() for name, position in network.nodes.items()}
    content = {"format": "flatnet-network/1", "units": "mm", "nodes": nodes, "curves": curves}
    path.write_text(json.dumps(content) + "\n", encoding="utf-8")
