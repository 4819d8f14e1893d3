"""Measurements of a body become its horizontal sections: what the form `mannequin` is made of.

z points up from the floor, y to the front, x to the body's right; the sagittal plane is x = 0. The right half's
section is the part x >= 0 of an ellipse with centre (c_x, c_y) and half axes (a, b). Above the crotch c_x < a:
the sagittal plane cuts the ellipse. At the crotch c_x = a, below c_x > a: a closed leg. Sections are told by the
way up the body: the height, but from the shoulder point on along the shoulder, which is nearly level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.spatial import ConvexHull
from scipy.special import ellipe

from flatnet.forms.measurements import MeasurementError

Floats = NDArray[np.float64]

#: The shoulder falls by this angle from the neck, degrees: our own choice.
SHOULDER_SLOPE = 20.0


@dataclass(frozen=True)
class Body:
    """Measurements of a body, mm.

    The defaults waist, hip, ankle, rise and inseam are those of a table of UK size 12 (720, 960, 240, crotch
    depth 280, inseam 760: together its waist to floor, 1040), and so are bust, neck, shoulder, back length, back
    and front width (its chest). That table has no thigh and no knee: FreeSewing's base set for women (570 and
    380 at hip 1010) scaled to hip 960 gives 542 and 361; its under bust, high bust and bust span (780, 865 and
    160 at bust 925) scaled to bust 880 give 742, 823 and 152. Neither has a calf: a little less than the knee is
    our own choice.

    Attributes
    ----------
    waist, hip : girths by tape around the whole body.
    thigh, knee, calf, ankle : girths of one leg.
    rise : height from crotch to waist (crotch depth).
    inseam : height from floor to crotch.
    under_bust, bust, high_bust, neck : girths by tape around the whole body; the high bust close under the arms.
    bust_span : from bust point to bust point.
    back_length : height from the waist to the nape.
    shoulder : straight from the neck to the shoulder point.
    back_width, front_width : by tape from arm to arm, half way from the underarm to the shoulder point.
    top : `waist`, or `neck` for a body with its torso.
    half : `left` or `right` of the sagittal plane, or `both`.
    """

    waist: float = 720.0
    hip: float = 960.0
    thigh: float = 542.0
    knee: float = 361.0
    calf: float = 350.0
    ankle: float = 240.0
    rise: float = 280.0
    inseam: float = 760.0
    under_bust: float = 742.0
    bust: float = 880.0
    high_bust: float = 823.0
    neck: float = 370.0
    bust_span: float = 152.0
    back_length: float = 410.0
    shoulder: float = 122.5
    back_width: float = 344.0
    front_width: float = 324.0
    top: str = "waist"
    half: str = "both"

    def __post_init__(self) -> None:
        messages = []
        if self.half not in ("left", "right", "both"):
            messages.append(f"half must be left, right or both, got {self.half!r}")
        if self.top not in ("waist", "neck"):
            messages.append(f"top must be waist or neck, got {self.top!r}")
        of_torso = (("under_bust", "bust"), ("high_bust", "bust"), ("under_bust", "high_bust"))
        for smaller, larger in (
            *(("waist", "hip"), ("knee", "thigh"), ("calf", "thigh"), ("ankle", "calf")),
            *(of_torso if self.top == "neck" else ()),
        ):
            girth, other = getattr(self, smaller), getattr(self, larger)
            if not 0.4 * other <= girth <= 1.2 * other:
                messages.append(
                    f"{smaller} must be 0.4 to 1.2 times {larger}, so in "
                    f"[{0.4 * other:.0f}, {1.2 * other:.0f}] mm, got {girth:g} mm"
                )
        thighs = _around_both(_section_at("thigh", self.thigh))
        if thighs > 1.05 * self.hip:
            messages.append(
                f"two thighs of {self.thigh:g} mm side by side measure {thighs:.0f} mm around, "
                f"more than the hip of {self.hip:g} mm; make hip larger or thigh smaller"
            )
        if self.top == "neck" and self.neck > 0.6 * self.high_bust:
            messages.append(
                f"neck must be at most 0.6 times high_bust, so {0.6 * self.high_bust:.0f} mm, got {self.neck:g} mm"
            )
        if self.top == "neck" and self.shoulder > 0.45 * self.back_length:
            messages.append(
                f"shoulder must be at most 0.45 times back_length, so {0.45 * self.back_length:.0f} mm, "
                f"got {self.shoulder:g} mm"
            )
        if not messages and self.top == "neck":
            messages += _torso_messages(self)
        if messages:
            raise MeasurementError(messages)

    @property
    def ways(self) -> dict[str, float]:
        """Way up from the floor to every level, mm: its height, but for the neck.

        Hip: 206 / 280 of the rise below the waist; knee: 455 / 760 of the inseam (both UK 12; its waist to
        knee is 585 of 1040). Thigh 5 %, the calf's fullest place 57 %, the ankle 90 % of the inseam below the
        crotch: our own choices. High bust: 200 / 410 of the back length above the waist (UK 12, whose armscye
        depth is 210); the under bust at 30 % of that and the bust at 65 %: our own choices.
        """
        waist = self.inseam + self.rise
        of_legs = {
            "waist": waist,
            "hip": waist - 206.0 / 280.0 * self.rise,
            "crotch": self.inseam,
            "thigh": 0.95 * self.inseam,
            "knee": 455.0 / 760.0 * self.inseam,
            "calf": 0.43 * self.inseam,
            "ankle": 0.10 * self.inseam,
        }
        if self.top == "waist":
            return of_legs
        underarm = 200.0 / 410.0 * self.back_length
        shoulder = self.back_length - self.shoulder * float(np.sin(np.radians(SHOULDER_SLOPE)))
        return of_legs | {
            "under_bust": waist + 0.3 * underarm,
            "bust": waist + 0.65 * underarm,
            "high_bust": waist + underarm,
            "across": waist + (underarm + shoulder) / 2.0,
            "shoulder": waist + shoulder,
            "neck": waist + shoulder + self.shoulder,
        }

    def height(self, ways: Floats) -> Floats:
        """Height over the floor, mm, at ways up the body, (n,)."""
        if self.top == "waist":
            return ways
        at = self.ways
        neck = at["waist"] + self.back_length
        over = PchipInterpolator(
            [at[name] for name in ("bust", "high_bust", "shoulder", "neck")],
            [at["bust"], at["high_bust"], at["shoulder"], neck],
        )
        return np.where(ways > at["high_bust"], over(np.maximum(ways, at["high_bust"])), ways)

    @property
    def heights(self) -> dict[str, float]:
        """Height of every level over the floor, mm."""
        ways = self.ways
        return dict(zip(ways, self.height(np.array([*ways.values()])).tolist()))


@dataclass(frozen=True)
class Ellipse:
    """A horizontal section of the right half: centre (cx, cy), half axes a (across) and b (deep), mm."""

    cx: float
    cy: float
    a: float
    b: float


#: Level -> b / a, c_x / a, c_y / b of its ellipse: the figure's proportions, chosen by eye. The crotch level
#: has no girth of its own: a is that of the thigh, a little fuller. Nor has the shoulder: a is told by its
#: width. At the bust it is the ribs' ellipse, as large around as the high bust.
PROPORTIONS = {
    "waist": (0.76, 0.05, 0.0),
    "hip": (0.90, 0.40, -0.10),
    "crotch": (1.11, 1.0, -0.05),
    "thigh": (1.10, 1.13, 0.02),
    "knee": (1.06, 1.33, 0.10),
    "calf": (1.02, 1.38, -0.16),
    "ankle": (1.20, 2.05, -0.30),
    "under_bust": (0.74, 0.0, 0.0),
    "bust": (0.73, 0.0, -0.04),
    "high_bust": (0.70, 0.0, -0.08),
    "shoulder": (0.38, 0.0, -0.25),
    "neck": (1.10, 0.0, -0.15),
}
CROTCH_OVER_THIGH = 1.07


#: Levels whose ring goes round the body, and round a leg. At the crotch the legs touch: there is no ring.
BODY_RINGS = ("waist", "hip")
LEG_RINGS = ("thigh", "knee", "calf", "ankle")
TORSO_RINGS = ("under_bust", "bust", "high_bust", "neck")


def sections(body: Body) -> dict[str, Ellipse]:
    """The ellipse of every level that has one, its size solved for from the level's girth."""
    found = {name: _section_at(name, getattr(body, name)) for name in LEG_RINGS}
    for name in BODY_RINGS:
        depth, offset, _ = PROPORTIONS[name]
        found[name] = _scaled(name, getattr(body, name) / (_perimeter(1.0, depth) + 4.0 * offset))
    found["crotch"] = _scaled("crotch", CROTCH_OVER_THIGH * found["thigh"].a)
    if body.top == "neck":
        found |= {name: _section_at(name, getattr(body, name)) for name in ("under_bust", "high_bust", "neck")}
        found["bust"] = _section_at("bust", body.high_bust)
        across = body.shoulder * float(np.cos(np.radians(SHOULDER_SLOPE)))
        found["shoulder"] = _scaled("shoulder", found["neck"].a + across)
    return found


def profile(body: Body, ways: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """c_x, c_y, a, b at each way up the body, each (n,).

    Interpolated are the four silhouettes c_x -+ a and c_y -+ b, by monotone cubics: no bulge between two
    measured levels that neither has, and c_x - a changes its sign at the crotch alone.
    """
    levels = body.ways
    ellipses = sections(body)
    order = sorted(ellipses, key=lambda name: levels[name])
    at = [levels[name] for name in order]
    inner, outer, back, front = (
        PchipInterpolator(at, silhouette)(ways)
        for silhouette in np.transpose(
            [(e.cx - e.a, e.cx + e.a, e.cy - e.b, e.cy + e.b) for e in (ellipses[name] for name in order)]
        )
    )
    return (inner + outer) / 2, (back + front) / 2, (outer - inner) / 2, (front - back) / 2


def rows_of_points(body: Body, ways: Floats, columns: int) -> Floats:
    """Points of the right half's ellipses, not yet cut at the sagittal plane, (n, columns, 3).

    Column 0 is the outside, a quarter of the columns on the front, then the inside and the back.
    """
    angles = 2.0 * np.pi * np.arange(columns) / columns
    cx, cy, a, b = (values[:, None] for values in profile(body, ways))
    x, y = cx + a * np.cos(angles), cy + b * np.sin(angles)
    return np.stack([x, y, np.broadcast_to(body.height(ways)[:, None], x.shape)], axis=2)


def with_bust(body: Body, points: Floats) -> Floats:
    """The ribs' points, (..., 3), moved to the front by the breasts: by as much as the bust's girth asks for."""
    return points + _breast_depth(body) * _breast(body, points)[..., None] * [0.0, 1.0, 0.0]


def _breast(body: Body, points: Floats) -> Floats:
    """Share of the breasts' depth at points of the ribs: (1 - r^2)^2 about the bust point, 0 on the back.

    It ends at the rings above and below the bust and in the sagittal plane, so that their girths are the ribs'.
    """
    at = body.heights
    half_span = body.bust_span / 2.0
    across = (np.abs(points[..., 0]) - half_span) / half_span
    up = (points[..., 2] - at["bust"]) / (at["high_bust"] - at["bust"])
    share = np.maximum(1.0 - across**2 - up**2, 0.0) ** 2
    return np.where(points[..., 1] > 0.0, share, 0.0)


def _bust_girth(body: Body, depth: float) -> float:
    """By tape around the ribs at the bust's height and breasts of this depth, mm."""
    ribs = rows_of_points(body, np.array([body.ways["bust"]]), 720)[0]
    x, y = ribs[:, 0], ribs[:, 1] + depth * _breast(body, ribs)
    return float(ConvexHull(np.column_stack([np.concatenate([x, -x]), np.concatenate([y, y])])).area)


def _deepest_breast(body: Body) -> float:
    """As deep as the bust's ring is above the under bust's: deeper ones would be steeper than 57 degrees, mm."""
    return body.heights["bust"] - body.heights["under_bust"]


def _breast_depth(body: Body) -> float:
    return float(brentq(lambda depth: _bust_girth(body, depth) - body.bust, 0.0, _deepest_breast(body), xtol=1e-6))


def _torso_messages(body: Body) -> list[str]:
    """What is impossible in the measurements of the torso."""
    messages = []
    low, high = _bust_girth(body, 0.0), _bust_girth(body, _deepest_breast(body))
    if not low <= body.bust <= high:
        messages.append(
            f"bust must be in [{low:.0f}, {high:.0f}] mm over ribs with under_bust {body.under_bust:g} and "
            f"high_bust {body.high_bust:g} mm, got {body.bust:g} mm"
        )
    widest_span = 1.9 * sections(body)["bust"].a
    if body.bust_span > widest_span:
        messages.append(f"bust_span must be at most {widest_span:.0f} mm on these ribs, got {body.bust_span:g} mm")
    _, _, a, b = profile(body, np.array([body.ways["across"]]))
    widest = 0.95 * _perimeter(float(a[0]), float(b[0])) / 2.0
    messages += [
        f"{name} must be at most {widest:.0f} mm on this chest, got {getattr(body, name):g} mm"
        for name in ("back_width", "front_width")
        if getattr(body, name) > widest
    ]
    return messages


def _scaled(name: str, a: float) -> Ellipse:
    depth, offset, shift = PROPORTIONS[name]
    return Ellipse(offset * a, shift * depth * a, a, depth * a)


def _section_at(name: str, girth: float) -> Ellipse:
    """The ellipse at a level with this perimeter."""
    return _scaled(name, girth / _perimeter(1.0, PROPORTIONS[name][0]))


def _perimeter(a: float, b: float) -> float:
    long, short = max(a, b), min(a, b)
    return float(4.0 * long * ellipe(1.0 - (short / long) ** 2))


def _around_both(ellipse: Ellipse) -> float:
    """Length of a tape around the ellipse and its mirror image.

    Their hull is the ellipse swept by 2 c_x, and a swept convex curve is longer by twice the way.
    """
    return _perimeter(ellipse.a, ellipse.b) + 4.0 * ellipse.cx
