#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Taylor's test on copper with linear hardening, against the length and the foot that other codes compute
for it: about 21.45 mm and 7.05 mm of 32.4 mm and 3.2 mm. The grid is coarse, three cells a radius."""

import math

from common import SCENES, claim, elastogen, vertices

RADIUS, LENGTH, SIDES, CELL = 3.2e-3, 32.4e-3, 48, 3.2e-3 / 3


def write_rod(path: str) -> None:
    """A prism that stands on y = 0."""
    lines = [f"v {RADIUS * math.cos(2 * math.pi * k / SIDES)} {y} "
             f"{RADIUS * math.sin(2 * math.pi * k / SIDES)}" for y in (0, LENGTH) for k in range(SIDES)]
    around = range(1, SIDES + 1)
    lines.append("f " + " ".join(map(str, around)))
    lines.append("f " + " ".join(str(k + SIDES) for k in reversed(around)))
    for k in around:
        after = k % SIDES + 1
        lines.append(f"f {k} {k + SIDES} {after + SIDES} {after}")
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


write_rod("rod.obj")
elastogen("simulate", "rod.obj", "--scene", SCENES / "taylor_bar.toml", "-o", "taylor_bar.ply", "-o",
          "taylor_bar.png")
rod = vertices("taylor_bar_00008.ply")
# the outer particles lie a quarter of a cell inside the body
top = max(x[1] for x in rod) - min(x[1] for x in rod) + CELL / 2
foot = max(math.hypot(x[0], x[2]) for x in rod) + CELL / 4
claim("length over that of other codes", 1e3 * top / 21.45, 0.95, 1.05)
claim("radius of the foot over theirs", 1e3 * foot / 7.05, 0.93, 1.07)
