"""A minimal case for every code of `flatnet.failure`, and the remedy that its message or its page recommends."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from crossing import as_project, omega, spiral

UP = [0.0, 0.0, 1.0]

Content = dict
#: What a remedy makes of a project; a string instead is a command: `split` builds with --auto-split, `cut` and `seam`
#: paste what `flatnet diagnose` prints.
Cure = Callable[[Content], Content] | str


def closed(points, normals):
    return {"closed": True, "points": np.asarray(points).tolist(), "normals": np.asarray(normals).tolist()}


def square(side=100.0, x=0.0):
    return closed([[x, 0, 0], [x + side, 0, 0], [x + side, side, 0], [x, side, 0]], UP)


def project(curves, patches, **rest):
    """A good square and whatever is added to it."""
    return {
        "flatnet": 1,
        "name": "case",
        "edge_length": 12,
        "curves": {"good": square(x=-500.0), **curves},
        "patches": {"good": {"around": ["good"]}, **patches},
        "rest": "openings",
        "materials": {"cloth": {"width": 1500}},
        "nesting": {"seconds": 1},
        **rest,
    }


def without_good(content):
    """A project less its good square."""
    del content["curves"]["good"], content["patches"]["good"]
    return content


def alone(curve, name="sheet", patch=None, **rest):
    """One patch inside one closed curve."""
    return without_good(project({name: curve}, {name: {"around": [name], **(patch or {})}}, **rest))


def given(vertices, normals, **rest):
    """One patch inside a closed curve with a normal per segment, mm."""
    normals = {"per": "segment", "values": np.asarray(normals).tolist()}
    return alone({"closed": True, "points": np.asarray(vertices).tolist(), "normals": normals}, **rest)


def saddle(height=30.0, lean=0.6, count=40):
    t = np.linspace(0, 2 * np.pi, count, endpoint=False)
    ring = np.c_[100 * np.cos(t), 100 * np.sin(t), height * np.cos(2 * t)]
    return closed(ring, np.c_[-lean * np.cos(t), lean * np.sin(t), np.ones(count)])


def lemma_2():
    """Corners that add up to more than a square has: 4 x 95 degrees."""
    nodes = {"a": [0, 0, 0], "b": [100, 0, 0], "c": [100, 100, 0], "d": [0, 100, 0]}
    names = list(nodes)
    curves = {
        f"{p}{q}": {"from": p, "to": q, "normals": UP} for p, q in zip(names, names[1:] + names[:1], strict=True)
    }
    bad = {"around": list(curves), "min_angle": dict.fromkeys(names, 95)}
    return project(curves, {"bad": bad}, nodes=nodes)


def self_intersection():
    """A ring cut open that climbs as it goes round once and a half: flat, it covers itself."""
    t = np.linspace(0, 3 * np.pi, 60)
    inner = np.c_[60 * np.cos(t), 60 * np.sin(t), 12 * t]
    outer = np.c_[100 * np.cos(t), 100 * np.sin(t), 12 * t]
    return project({"spiral": closed(np.r_[outer, inner[::-1]], UP)}, {"bad": {"around": ["spiral"]}})


def not_converged():
    """A saddle, and one step to get there."""
    return project({"ring": saddle()}, {"bad": {"around": ["ring"], "fitting": {"ramp_steps": 1, "max_steps": 1}}})


def stuck_vertex():
    """A saddle 10 km from the origin, where places are 2e-9 mm apart, and a tolerance below that round-off."""
    curve = saddle()
    curve["points"] = (np.array(curve["points"]) + [1e7, 0, 0]).tolist()
    return alone(curve, patch={"fitting": {"tolerance": 1e-12}})


def folded():
    """An accordion whose folds turn by 170 degrees, its normals held hard: exactly flat, and never made."""
    rise, run = 25 * np.cos(np.radians(5)), 25 * np.sin(np.radians(5))
    zigzag = np.array([[run * k, 0.0, rise * (k % 2)] for k in range(7)])
    side = np.array([[0.0, y, 0.0] for y in (25.0, 50.0, 75.0)])
    points = np.r_[zigzag, zigzag[-1] + side, zigzag[::-1] + [0, 100, 0], zigzag[0] + side[::-1]]
    flaps = np.array([[-rise, 0.0, run], [rise, 0.0, run]])[np.arange(6) % 2] / 25
    normals = np.r_[flaps, [flaps[-1]] * 4, flaps[::-1], [flaps[0]] * 4]
    curve = closed(points, normals) | {"edge_length": 26}
    bad = {"around": ["fold"], "edge_length": 25, "fitting": {"normal_weight": 3000, "stuck_rounds": 0}}
    return project({"fold": curve}, {"bad": bad})


def not_disk():
    """A square ring: two loops."""
    outer, inner = square(200.0), closed([[50, 50, 0], [150, 50, 0], [150, 150, 0], [50, 150, 0]], UP)
    return project({"outer": outer, "inner": inner}, {"bad": {"around": [["outer"], ["-inner"]]}})


def warp_singular():
    """Two corners a ten-thousandth of a millimetre apart: nothing tells their constraint points from each other."""
    points = [[0, 0, 0], [1e-4, 0, 0], [100, 0, 20], [100, 100, 0], [0, 100, 20]]
    return project({"spike": closed(points, UP)}, {"bad": {"around": ["spike"]}})


def sheet_too_small():
    """A piece of 200 x 200 mm on a ribbon."""
    materials = {"cloth": {"width": 1500}, "ribbon": {"width": 50}}
    bad = {"around": ["large"], "material": "ribbon"}
    case = project({"large": square(200.0)}, {"bad": bad}, materials=materials)
    case["patches"]["good"]["material"] = "cloth"
    return case


def out_of_material():
    """Two copies of a piece, and one sheet that has room for one."""
    materials = {"cloth": {"width": 1500}, "ply": {"width": 300, "length": 300, "sheets": 1}}
    bad = {"around": ["large"], "material": "ply", "cut": 2}
    case = project({"large": square(200.0)}, {"bad": bad}, materials=materials)
    case["patches"]["good"]["material"] = "cloth"
    return case


def degenerate_curve():
    """A corner that stands there twice."""
    return alone(closed([[0, 0, 0], [100, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0]], UP))


def ambiguous_faces():
    """Two closed curves that nothing joins, and one of them is a patch."""
    content = project({"hole": square(20.0, -460.0)}, {})
    del content["rest"]
    return content


def time_limit():
    """A saddle meshed with edges of 2.5 mm, which takes some seconds, and a limit of one."""
    return alone(saddle(), limits={"seconds": 1}, edge_length=2.5)


def wrinkled(radius=5.0, length=60.0, width=30.0, count=32):
    """A strip with a step: it bends up by 80 degrees and back at once, which is a wrinkle for the measure."""
    bend, edge = np.radians(80.0), length / count
    along = (np.arange(count) + 0.5) * edge - 0.5 * length
    heading = np.clip(bend - np.abs(along) / radius, 0.0, None)
    x = np.r_[0.0, np.cumsum(edge * np.cos(heading))]
    z = np.r_[0.0, np.cumsum(edge * np.sin(heading))]
    up, level = np.c_[-np.sin(heading), 0 * heading, np.cos(heading)], np.tile(UP, (count // 2, 1))
    y, none = np.linspace(0.0, width, count // 2 + 1), np.zeros(count + 1)
    near, far = np.c_[x, none, z], np.c_[x, none + width, z]
    right, left = np.c_[0 * y + x[-1], y, 0 * y + z[-1]], np.c_[0 * y, y, 0 * y]
    vertices = np.concatenate([near[:-1], right[:-1], far[:0:-1], left[:0:-1]])
    return given(vertices, np.concatenate([up, level, up[::-1], level]), edge_length=2)


#: Of the ball under `cut_off_cap`, mm, and of its rim, from the ball's top.
RADIUS, LATITUDE = 50.0, np.radians(40.0)


def cut_off_cap(folder, clearance=5):
    """A sheet over a circle of latitude of a ball: it is flat, and cuts the cap off."""
    trimesh.creation.icosphere(4, RADIUS).export(folder / "ball.stl")
    t = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = RADIUS * np.c_[np.sin(LATITUDE) * np.cos(t), np.sin(LATITUDE) * np.sin(t), np.cos(LATITUDE) + 0 * t]
    surface = {"mesh": "ball.stl", "clearance": clearance}
    rim = {"closed": True, "on": "surface", "kind": "spline", "points": ring.tolist()}
    return without_good(project({"rim": rim}, {"lid": {"around": ["rim"]}}, edge_length=6, surface=surface))


def beside(folder, x=5.0):
    """A lune beside the plane x = 0 of a ball round (x, 0, 0), and its image; `even.stl` is the ball round 0."""
    ball = trimesh.creation.icosphere(4, 50.0)
    ball.export(folder / "even.stl")
    ball.apply_translation([x, 0, 0])
    ball.export(folder / "ball.stl")
    return {
        "flatnet": 1,
        "name": "ball",
        "edge_length": 6,
        "surface": {"mesh": "ball.stl", "clearance": 4},
        "mirror": {"normal": [1, 0, 0]},
        "nodes": {"front": [0, -20, 45], "back": [0, 20, 45]},
        "curves": {
            "middle": {"on": "surface", "kind": "spline", "from": "front", "to": "back", "points": [[0, 0, 50]]},
            "rim": {"on": "surface", "kind": "spline", "from": "front", "to": "back", "points": [[30, 0, 40]]},
            "rim_left": {"mirror_of": "rim"},
        },
        "patches": {"right": {"around": ["rim", "-middle"]}, "left": {"mirror_of": "right"}},
        "rest": "openings",
        "nesting": {"seconds": 1},
    }


def roof(degrees=40, crease=False):
    """Two rectangles that meet along the y axis; each leans down by half the angle."""
    angle = np.radians(degrees)
    x, z = float(60 * np.cos(angle / 2)), float(-60 * np.sin(angle / 2))
    right, left = [-z, 0.0, x], [z, 0.0, x]
    nodes = {"a": [0, 0, 0], "b": [0, 80, 0], "c": [x, 0, z], "d": [x, 80, z], "e": [-x, 0, z], "f": [-x, 80, z]}
    ridge = {"from": "a", "to": "b", "normals": {"left": left, "right": right} if crease else [0, 0, 1]}
    sides = {"ac": right, "cd": right, "db": right, "ae": left, "ef": left, "fb": left}
    curves = {name: {"from": name[0], "to": name[1], "normals": normal} for name, normal in sides.items()}
    patches = {
        "right": {"around": ["ac", "cd", "db", "-ridge"]},
        "left": {"around": ["ridge", "-fb", "-ef", "-ae"]},
    }
    return without_good(project({"ridge": ridge} | curves, patches, nodes=nodes, fitting={"normal_weight": 0}))


def roll(more=0.7):
    """A strip rolled up by more than a full turn, its end through its beginning: r(t + 2 pi) = r(t) at t = more / 4."""
    t = np.linspace(0, 2 * np.pi + more, 60)
    radius = 60 + 2 * t * (t - 2 * np.pi - 0.5 * abs(more))
    low, high = (np.c_[radius * np.cos(t), radius * np.sin(t), np.full(60, z)] for z in (0.0, 50.0))
    points = np.concatenate([low, high[::-1]])
    out = points * [1, 1, 0]
    return alone(closed(points, out / np.linalg.norm(out, axis=1)[:, None]))


def crowded_allowance():
    """A slot 2 mm wide, and allowances of 5 mm."""
    slot = [[0, 0], [50, 0], [50, 60], [52, 60], [52, 0], [100, 0], [100, 100], [0, 100]]
    curve = closed(np.c_[slot, np.zeros(8)], UP)
    return alone(curve, materials={"cloth": {"width": 1500, "allowance": 5}})


def deep_notch():
    """Notches 4 mm deep on an allowance of 3."""
    return alone(square() | {"notches": 100}, materials={"cloth": {"width": 1500, "allowance": 3}})


def mark_off(height=30.0):
    """A button 30 mm above a level patch."""
    return alone(square(), patch={"marks": {"button": {"at": [50, 50, height]}}})


def cone(lean=0.7, slit=False):
    """A level ring with the normals of a cone, and cut open up to where its tip is."""
    t = np.linspace(0, 2 * np.pi, 41)
    ring = np.c_[100 * np.cos(t), 100 * np.sin(t), 0 * t]
    normals = np.c_[lean * np.cos(t), lean * np.sin(t), 0 * t + 1].tolist()
    rim = {"from": "a", "to": "a", "points": ring[1:-1].tolist(), "normals": {"per": "point", "values": normals}}
    content = alone(rim, nodes={"a": ring[0].tolist()})
    if slit:
        content["nodes"]["tip"] = [0, 0, 100 * lean]
        content["curves"]["dart"] = {"from": "a", "to": "tip", "slit": True, "normals": normals[0]}
        content["patches"]["sheet"]["around"] = ["sheet", "dart", "-dart"]
    return content


def normals_gave_way():
    """A nearly level ring of eight edges with the normals of a dome, held 1000 times as hard as by default."""
    t = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    ring = np.c_[100 * np.cos(t), 100 * np.sin(t), 0.5 * np.cos(2 * t)]
    edges = np.roll(ring, -1, axis=0) - ring
    normals = np.c_[np.cos(t), np.sin(t), np.ones(8)]
    normals -= (normals * edges).sum(axis=1)[:, None] / (edges**2).sum(axis=1)[:, None] * edges
    return given(ring, normals, edge_length=80, patch={"edge_length": 30, "fitting": FORCED})


FORCED = {"normal_weight": 1000, "stuck_rounds": 1}


def boundary_alone():
    return alone(saddle(), patch={"fitting": {"method": "boundary_alone"}})


def outline_opened():
    """A plane strip like the letter omega whose normals tilt along its feet, opened."""
    boundary = omega().boundary
    return given(boundary.vertices, boundary.normals, edge_length=9, patch={"planar_boundary": "simple"})


def no_grain():
    return alone(square(), patch={"grain": "up"})


def rectangles(widths, changes):
    """Rectangles 100 mm high side by side, `a0b0` the lower side of the first, with changes of curves and patches."""
    nodes, curves, patches = {}, {}, {}
    for i, width in enumerate(widths):
        x = 200 * i
        corners = [[x, 0, 0], [x + width, 0, 0], [x + width, 100, 0], [x, 100, 0]]
        names = [f"{letter}{i}" for letter in "abcd"]
        nodes |= dict(zip(names, corners, strict=True))
        around = [p + q for p, q in zip(names, names[1:] + names[:1], strict=True)]
        curves |= {name: {"from": name[:2], "to": name[2:], "normals": UP} for name in around}
        patches[f"sheet{i}"] = {"around": around}
    for name, change in changes.items():
        (curves.get(name) or patches[name]).update(change)
    return without_good(project(curves, patches, nodes=nodes))


def no_fold():
    """Half a piece, its fold bowed by 5 mm."""
    bow = {"kind": "spline", "points": [[50, -5, 0]]}
    return rectangles([100], {"sheet0": {"fold": "a0b0"}, "a0b0": bow})


def ease_off():
    """A side of 105 mm sewn to one of 100, and no word of ease."""
    return rectangles([100, 105], {"a1b1": {"sewn_to": "a0b0"}})


def draft_layout():
    """A roll 10 km wide, of whose strip single precision leaves the nesting engine nothing."""
    return alone(square(), patch={"cut": 2}, materials={"cloth": {"width": 1e7}})


def rolled_strip():
    return as_project(*spiral(1.5))


def edit(*path, to=None):
    """A remedy that changes one entry of the project file, or takes it out."""

    def cure(content):
        content = deepcopy(content)
        at = content
        for key in path[:-1]:
            at = at.setdefault(key, {})
        if to is None:
            del at[path[-1]]
        else:
            at[path[-1]] = to
        return content

    return cure


@dataclass(frozen=True)
class Case:
    """A project that shows a code, and a remedy.

    Attributes
    ----------
    make : the project; with `in_folder` it is called with a folder for the files that it names.
    words : what the case is.
    remedy, cure : what is done about it, in words and in deed.
    split : the case itself is built with --auto-split.
    """

    make: Callable[..., Content]
    words: str
    remedy: str
    cure: Cure
    in_folder: bool = False
    split: bool = False

    def content(self, folder: Path) -> Content:
        return self.make(folder) if self.in_folder else self.make()


BAD = ("patches", "bad")
SHEET = ("patches", "sheet")

CASES = {
    "degenerate_curve": Case(
        degenerate_curve, "a corner that stands there twice", "the point taken out", lambda _: alone(square())
    ),
    "ambiguous_faces": Case(
        ambiguous_faces, "two closed curves that nothing joins, one of them listed", "`rest: openings`",
        edit("rest", to="openings"),
    ),
    "not_disk": Case(not_disk, "a square ring", "the seam that `diagnose` proposes", "seam"),
    "lemma_2": Case(
        lemma_2, "a square whose corners are to have 95 degrees", "`min_angle: 90`",
        edit(*BAD, "min_angle", to=dict.fromkeys("abcd", 90)),
    ),
    "self_intersection": Case(
        self_intersection, "a strip that climbs round an axis once and a half", "`--auto-split`", "split"
    ),
    "warp_singular": Case(
        warp_singular, "two corners a ten-thousandth of a mm apart", "one of them taken out",
        edit("curves", "spike", "points", to=[[0, 0, 0], [100, 0, 20], [100, 100, 0], [0, 100, 20]]),
    ),
    "not_converged": Case(
        not_converged, "a saddle, and one step to get there", "`max_steps` as by default", edit(*BAD, "fitting")
    ),
    "stuck_vertex": Case(
        stuck_vertex, "a saddle 10 km from the origin, `tolerance: 1e-12`", "`tolerance` as by default",
        edit(*SHEET, "fitting"),
    ),
    "folded": Case(
        folded, "an accordion folded by 170 degrees, its normals held hard", "`fitting` as by default",
        edit(*BAD, "fitting"),
    ),
    "sheet_too_small": Case(
        sheet_too_small, "a piece 200 mm wide on a ribbon of 50", "a ribbon of 300",
        edit("materials", "ribbon", "width", to=300),
    ),
    "out_of_material": Case(
        out_of_material, "two pieces of 200 mm and one sheet of 300", "`sheets: 2`",
        edit("materials", "ply", "sheets", to=2),
    ),
    "time_limit": Case(
        time_limit, "a saddle of 6,000 vertices, and one second", "`limits: {seconds: 600}`, a larger `edge_length`",
        lambda content: content | {"limits": {"seconds": 600}, "edge_length": 5},
    ),
    "wrinkled": Case(wrinkled, "a strip with a step of 80 degrees", "`--auto-split`", "split"),
    "inside_surface": Case(
        cut_off_cap, "a sheet over a cap of a ball", "the cut that `diagnose --patch` finds", "cut", True
    ),
    "off_surface": Case(
        beside, "the image of a patch on a ball that lies 5 mm off the mirror plane", "a ball with two equal halves",
        lambda content: content | {"surface": content["surface"] | {"mesh": "even.stl"}}, True,
    ),
    "normal_gap": Case(
        roof, "a roof of 40 degrees with one normal along its ridge", "the ridge a crease",
        lambda _: roof(crease=True),
    ),
    "mesh_self_intersection": Case(
        roll, "a strip rolled up by more than a turn, its end through its beginning", "rolled up by less",
        lambda _: roll(-0.7),
    ),
    "crowded_allowance": Case(
        crowded_allowance, "a slot 2 mm wide, allowances of 5", "`allowance: 0`", edit(*SHEET, "allowance", to=0)
    ),
    "deep_notch": Case(
        deep_notch, "notches 4 mm deep, an allowance of 3", "`depth: 3`",
        edit("curves", "sheet", "notches", to={"every": 100, "depth": 3}),
    ),
    "no_fold": Case(
        no_fold, "half a piece, its fold bowed by 5 mm", "the fold straight",
        lambda _: rectangles([100], {"sheet0": {"fold": "a0b0"}}),
    ),
    "ease_off": Case(
        ease_off, "a side of 105 mm sewn to one of 100", "`ease: 5`",
        edit("curves", "a1b1", "sewn_to", to={"curves": "a0b0", "ease": 5}),
    ),
    "mark_off": Case(mark_off, "a button 30 mm above its patch", "put on the patch", lambda _: mark_off(0.0)),
    "normals_contradict": Case(
        cone, "a level ring with the normals of a cone", "a dart up to its tip", lambda _: cone(slit=True)
    ),
    "normals_gave_way": Case(
        normals_gave_way, "a level ring of eight edges, `normal_weight: 1000`", "`normal_weight: 1`",
        edit(*SHEET, "fitting", to={"normal_weight": 1}),
    ),
    "boundary_alone": Case(
        boundary_alone, "a saddle of its boundary alone", "`method: fair`", edit(*SHEET, "fitting")
    ),
    "outline_opened": Case(
        outline_opened, "a plane strip whose normals tilt, `planar_boundary: simple`", "without it, `--auto-split`",
        "split",
    ),
    "no_grain": Case(no_grain, "a level patch, `grain: up`", "`grain: [1, 0, 0]`", edit(*SHEET, "grain", to=[1, 0, 0])),
    "draft_layout": Case(
        draft_layout, "a roll 10 km wide", "a roll of 1.5 m", edit("materials", "cloth", "width", to=1500)
    ),
    "divided": Case(
        rolled_strip, "a rolled strip built with `--auto-split`", "the cut that `diagnose` prints, pasted", "cut",
        split=True,
    ),
}  # fmt: skip
