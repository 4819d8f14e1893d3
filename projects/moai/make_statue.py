"""Make statue.obj: a stone figure four metres tall with a hole in its back, lofted from sections and cut open.

Run `python projects/moai/make_statue.py` to write it anew; the same file comes out every time. z is the height
over the ground, mm; the figure looks along +y. Of numpy alone.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np

#: Height of the level sections, half width, depth to the front and to the back, and how square they are (the
#: exponent of a superellipse).
SECTIONS = np.array(
    [
        # z, half width, front, back, squareness
        [0, 790, 430, 430, 3.2],
        [300, 765, 450, 440, 3.2],
        [700, 725, 480, 445, 3.2],
        [1300, 705, 470, 430, 3.2],
        [1800, 720, 430, 390, 3.2],
        [2080, 690, 380, 350, 3.0],
        [2260, 570, 320, 310, 2.8],
        [2370, 450, 290, 285, 2.8],
        [2430, 425, 330, 280, 3.0],
        [2500, 425, 435, 280, 3.2],
        [2600, 430, 440, 285, 3.2],
        [2900, 430, 400, 300, 3.2],
        [3200, 430, 390, 310, 3.2],
        [3480, 435, 400, 315, 3.2],
        [3750, 420, 345, 310, 3.2],
        [3900, 390, 300, 280, 3.0],
        [4000, 360, 270, 255, 3.0],
    ]
)
HEIGHT, EDGE_RADIUS, CROWN_RADIUS = 4000.0, 130.0, 160.0
#: Points of a section on its front and on its back, and spacing of the sections.
FRONT, BACK, BODY_STEP, HEAD_STEP = 46, 30, 90.0, 47.0

#: The hole, hourglass-shaped: from under the base (negative: how far in from its edge) up the back, how narrow
#: and where, how wide 1 m from there, and the radius of its corners.
HOLE_LOW, HOLE_HIGH = -520.0, 1500.0
WAIST, WAIST_AT, WAIST_CURVE, CORNER = 250.0, 450.0, 270.0, 250.0


def profile() -> tuple[np.ndarray, np.ndarray]:
    """Heights of the rows from the middle of the base to the crown, and their scale against the section there."""
    turn = np.linspace(0.0, np.pi / 2, 5)
    edge = [(EDGE_RADIUS * (1 - np.cos(a)), 1 - EDGE_RADIUS * (1 - np.sin(a)) / 600) for a in turn]
    base = [(0.0, scale) for scale in np.linspace(0.0, edge[0][1], 8)[1:-1]]
    body = [(z, 1.0) for z in np.arange(EDGE_RADIUS + BODY_STEP, 2350, BODY_STEP)]
    head = [(z, 1.0) for z in np.arange(body[-1][0] + HEAD_STEP, HEIGHT - CROWN_RADIUS, HEAD_STEP)]
    turn = np.linspace(0.0, np.pi / 2, 6)
    crown = [(HEIGHT - CROWN_RADIUS * (1 - np.sin(a)), 1 - CROWN_RADIUS * (1 - np.cos(a)) / 350) for a in turn]
    roof = [(HEIGHT, scale) for scale in (0.36, 0.18)]
    rows = np.array([*base, *edge, *body, *head, *crown, *roof])
    return rows[:, 0], rows[:, 1]


def bump(value: np.ndarray, centre: float, width: float) -> np.ndarray:
    return np.exp(-(((value - centre) / width) ** 2))


def plateau(value: np.ndarray, low: float, high: float, soft: float) -> np.ndarray:
    """1 between low and high, 0 outside, with soft ends."""
    return 0.5 * (np.tanh((value - low) / soft) - np.tanh((value - high) / soft))


def relief(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """How far the front stands out, mm: brow, eyes, nose, lips; arms and hands on the belly."""
    side = np.abs(x)
    down_the_nose = np.clip((3480 - z) / 520, 0.0, 1.0)
    nose = (50 + 150 * down_the_nose) * plateau(z, 2950, 3480, 22) * np.exp(-((x / (55 + 55 * down_the_nose)) ** 4))
    brow = 62 * plateau(z, 3410, 3500, 25) * plateau(x, -350, 350, 30)
    eyes = -75 * bump(z, 3320, 75) * bump(side, 205, 115)
    cheeks = -35 * plateau(z, 2900, 3300, 60) * bump(side, 330, 90)
    lips = (55 * bump(z, 2795, 32) + 50 * bump(z, 2705, 32)) * plateau(x, -185, 185, 40)
    chin = 45 * bump(z, 2540, 60) * plateau(x, -230, 230, 70)
    arms = -60 * bump(side, 500, 45) * plateau(z, 640, 2000, 60)
    hands = 45 * bump(z, 560, 75) * plateau(side, 90, 560, 45)
    collar = 25 * bump(z, 2150, 50) * plateau(x, -350, 350, 60)
    return nose + brow + eyes + cheeks + lips + chin + arms + hands + collar


def ears(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """How far the sides stand out, mm: long ears."""
    return 60 * plateau(z, 2800, 3480, 35) * plateau(y, -60, 90, 25)


def figure() -> tuple[np.ndarray, np.ndarray]:
    """The closed figure: (n, 3) vertices, mm, and (m, 3) triangles, anticlockwise seen from outside."""
    heights, scales = profile()
    front = np.pi * np.arange(FRONT) / FRONT
    angles = np.concatenate([front, np.pi + np.pi * np.arange(BACK) / BACK])
    width, ahead, behind, square = (np.interp(heights, SECTIONS[:, 0], column)[:, None] for column in SECTIONS[:, 1:].T)
    # Round corners of the profile that the table's straight lines leave.
    width, ahead, behind = (smooth(column) for column in (width, ahead, behind))
    cosine, sine = np.cos(angles), np.sin(angles)
    norm = (np.abs(cosine) ** square + np.abs(sine) ** square) ** (1 / square)
    x = width * cosine / norm
    y = np.where(sine > 0, ahead, behind) * sine / norm
    z = np.repeat(heights[:, None], len(angles), axis=1)
    faces_front, faces_side = np.clip(y / ahead, 0, 1) ** 3, np.sign(x) * np.clip(np.abs(x) / width, 0, 1) ** 6
    y, x = y + relief(x, z) * faces_front, x + ears(y, z) * faces_side
    rings = np.stack([x * scales[:, None], y * scales[:, None], z], axis=-1)
    rows, columns = rings.shape[:2]
    vertices = np.concatenate([rings.reshape(-1, 3), [[0, 0, 0], [0, 0, HEIGHT]]])
    here = np.arange(rows * columns).reshape(rows, columns)
    beside = np.roll(here, -1, axis=1)
    a, b, c, d = here[:-1], beside[:-1], beside[1:], here[1:]
    foot, crown = np.full(columns, rows * columns), np.full(columns, rows * columns + 1)
    # Diagonals run the other way on the other half, so that left and right are alike.
    left = (np.arange(columns) >= FRONT // 2) & (np.arange(columns) < FRONT + BACK // 2)
    lower = np.where(left[:, None], np.stack([a, b, c], -1), np.stack([a, b, d], -1))
    upper = np.where(left[:, None], np.stack([a, c, d], -1), np.stack([b, c, d], -1))
    caps = [np.stack([beside[0], here[0], foot], -1), np.stack([here[-1], beside[-1], crown], -1)]
    return vertices, np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3), *caps])


def smooth(column: np.ndarray) -> np.ndarray:
    padded = np.concatenate([column[:1], column, column[-1:]])
    return 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]


def hole(vertices: np.ndarray) -> np.ndarray:
    """Signed distance, about, from the rim of the hole, mm: negative within it."""
    x, y, z = vertices.T
    edge = vertices[z < EDGE_RADIUS, 1].min()
    # Up the back it is the height; round the edge and under the base, how far in from the edge.
    along = z - np.clip(1 - z / EDGE_RADIUS, 0, 1) * (y - edge)
    half = WAIST + WAIST_CURVE * ((along - WAIST_AT) / 1000) ** 2
    aside = np.abs(x) - half + CORNER
    beyond = np.abs(along - (HOLE_LOW + HOLE_HIGH) / 2) - (HOLE_HIGH - HOLE_LOW) / 2 + CORNER
    outside = np.hypot(np.maximum(aside, 0), np.maximum(beyond, 0))
    signed = np.minimum(np.maximum(aside, beyond), 0) + outside - CORNER
    return np.where((y < 0.25 * edge) | (z < EDGE_RADIUS / 2), signed, 1e3)


def cut_open(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leave what lies outside the hole; vertices near the rim are moved on it, the other edges across it cut."""
    signed = hole(vertices)
    pairs = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    pairs = pairs[signed[pairs[:, 0]] * signed[pairs[:, 1]] < 0]
    moved, at = vertices.copy(), signed.copy()
    for near, far in np.concatenate([pairs, pairs[:, ::-1]]):
        share = signed[near] / (signed[near] - signed[far])
        if share < 0.3 and at[near] != 0:
            moved[near], at[near] = vertices[near] + share * (vertices[far] - vertices[near]), 0.0
    kept, points, of_edge = [], list(moved), {}

    def crossing(inside: int, outside: int) -> int:
        if (inside, outside) not in of_edge:
            share = at[inside] / (at[inside] - at[outside])
            of_edge[inside, outside] = len(points)
            points.append(moved[inside] + share * (moved[outside] - moved[inside]))
        return of_edge[inside, outside]

    for triangle in triangles.tolist():
        polygon = []
        for tail, head in zip(triangle, triangle[1:] + triangle[:1]):
            if at[tail] >= 0:
                polygon.append(tail)
            if at[tail] * at[head] < 0:
                polygon.append(crossing(*((tail, head) if at[tail] < 0 else (head, tail))))
        if any(at[corner] > 0 for corner in triangle):
            kept += [[polygon[0], *pair] for pair in pairwise(polygon[1:])]
    used, faces = np.unique(kept, return_inverse=True)
    return np.array(points)[used], faces.reshape(-1, 3)


def written() -> str:
    """The figure with its hole as OBJ, in tenths of a mm."""
    vertices, faces = cut_open(*figure())
    lines = ["# A stone figure with a hole in its back, mm, z up; made by make_statue.py."]
    # Plus 0.0, which makes 0 of -0.
    lines += ["v " + " ".join(f"{round(value, 1) + 0.0:g}" for value in vertex) for vertex in vertices.tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces.tolist()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("statue.obj").write_text(written(), encoding="ascii")
