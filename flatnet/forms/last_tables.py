"""The proportions of the form `shoe_last`: a base last of 280 mm (size 42), in mm, row by row from heel to toe.

Chosen by eye against photographs of lasts for men's everyday shoes, so that girths and widths come near those of
the size; `shoe_last` scales them until they are met.
"""

from __future__ import annotations

import numpy as np

#: Of the base last.
LENGTH = 280.0
#: x of the rows of the control net. The first two and the last two close heel and toe.
ROWS = np.array([0, 0, 13, 36, 64, 92, 120, 148, 174, 200, 226, 250, 268, 280, 280], dtype=float)
#: Distances of the feather edge from the axis, and how far the wall above swells beyond it. The inner side is
#: hollow at the arch.
INNER_FEATHER = np.array([0, 17, 26, 30, 29.5, 25.5, 21, 26.5, 37, 43.5, 43, 38.5, 31, 22, 5])
OUTER_FEATHER = np.array([0, 17, 26, 31, 32, 33, 35.5, 39.5, 43.5, 43.5, 40, 32, 22.5, 12, -5])
INNER_SWELL = np.array([0, 0, 2, 3, 4, 7, 10, 9, 5, 2.5, 2, 2, 1, 0, 0])
OUTER_SWELL = np.array([0, 0, 2, 3, 3.5, 4, 4.5, 4.5, 4, 3, 2.5, 2, 1, 0, 0])
#: How far the inner feather edge rises into the hollow of the arch.
ARCH_RISE = np.array([0, 0, 0, 0, 2, 6, 8, 5, 1.5, 0, 0, 0, 0, 0, 0])
#: Height of the ridge over the feather edge (over the heel a roof, which the cone's cut takes away), and its
#: distance from the axis towards the inner side.
RIDGE = np.array([112, 112, 122, 124, 117, 103, 88, 75, 58.5, 43.5, 34, 28.5, 25, 22, 22])
RIDGE_SHIFT = np.array([0, 0, 0, 0, 0, 1, 3, 5, 5.5, 5, 5, 5, 5, 5, 5], dtype=float)
#: Half widths of the upper wall and of the roof as parts of the lower wall's.
WALL = np.array([0.86, 0.86, 0.82, 0.79, 0.76, 0.73, 0.72, 0.76, 0.83, 0.90, 0.93, 0.94, 0.95, 0.95, 0.95])
ROOF = np.array([0.50, 0.50, 0.50, 0.46, 0.40, 0.32, 0.27, 0.30, 0.38, 0.46, 0.52, 0.56, 0.60, 0.60, 0.60])
#: Half widths of the toe at the rows before the last one, as parts of the above.
TOES = {
    "round": (1.0, 1.0, 1.0, 1.0),
    "almond": (0.99, 0.95, 0.88, 0.80),
    "pointed": (0.97, 0.86, 0.70, 0.50),
    "square": (1.0, 1.03, 1.10, 1.25),
}

#: Columns of the net from the feather edge to the ridge: heights as parts of the ridge's, and how far the curves
#: of heel and toe lean inwards there.
ACROSS_HEIGHTS = np.array([0.0, 0.12, 0.40, 0.74, 1.0, 1.0])
HEEL_LEAN = np.array([4.0, 0.0, 0.0, 5.0, 11.0, 12.0])
TOE_LEAN = np.array([2.0, 0.0, 2.0, 8.0, 14.0, 21.0])
#: Away from heel and toe the lean fades with this length.
LEAN_FADES = 26.0
