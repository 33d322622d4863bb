#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Taylor's test on copper, against the length and the radius that the literature computes: 21.4 to
21.5 mm and 6.8 to 7.2 mm of 32.4 mm and 3.2 mm (linear hardening, no rates; Kamoulakos 1990 and others)."""

import math

from common import SCENES, claim, elastogen, vertices

RADIUS, LENGTH, SIDES = 3.2e-3, 32.4e-3, 48


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
elastogen("simulate", "rod.obj", "--scene", SCENES / "taylor_bar.toml", "-o", "taylor_bar.ply", "-o", "taylor_bar.png")
rod = vertices("taylor_bar_00008.ply")
top = max(x[1] for x in rod) - min(x[1] for x in rod)
foot = max(math.hypot(x[0], x[2]) for x in rod)
claim("length after it [mm]", 1e3 * top, 20.9, 22.0)
claim("radius of the foot [mm]", 1e3 * foot, 6.4, 7.6)
