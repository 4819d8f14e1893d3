"""The truth that exports are held against: a build's OBJ and report, read by the tests' own readers."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from written import boundary_vertices, read_obj


@dataclass
class Golden:
    """A build, and the folder with all exports of it."""

    out: Path
    folder: Path

    def __post_init__(self):
        self.report = json.loads((self.out / "report.json").read_text())
        self.pieces = {piece["name"]: piece for piece in json.loads((self.out / "pieces.json").read_text())["pieces"]}
        self.meshes = {
            patch["name"]: read_obj(self.out / "patches" / f"{patch['name']}.obj") for patch in self.report["patches"]
        }
        self.flat = {name: flat[boundary_vertices(faces)] for name, (_, flat, faces) in self.meshes.items()}
        (self.layout,) = self.report["layouts"]
        self.sheet = Path(self.layout["file"]).stem

    def placed(self, points, placement):
        """Points of a piece where the report lays it, y up."""
        turn = np.radians(placement["rotation_deg"])
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        mirror = np.diag([1.0, -1.0 if placement["mirrored"] else 1.0])
        return np.asarray(points) @ (rotation @ mirror).T + [placement["x_mm"], placement["y_mm"]]

    @property
    def sew_lines(self):
        """(patch, copy) -> its sew line on the sheet, from the OBJ."""
        return {(p["patch"], p["copy"]): self.placed(self.flat[p["patch"]], p) for p in self.layout["pieces"]}

    @property
    def cut_lines(self):
        """(patch, copy) -> its cut line on the sheet."""
        pieces = self.layout["pieces"]
        return {(p["patch"], p["copy"]): self.placed(self.pieces[p["patch"]]["cut_line"], p) for p in pieces}


def same_lines(found, wanted, tolerance):
    """Two sets of closed lines are the same, vertex by vertex from the same start; each found line is used once."""
    assert len(found) == len(wanted)
    left = list(found)
    for line in wanted:
        gaps = [np.abs(other - line).max() if other.shape == line.shape else np.inf for other in left]
        best = int(np.argmin(gaps))
        assert gaps[best] <= tolerance, gaps[best]
        del left[best]
