#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A plate falls through air: y = v^2/g ln cosh(g t/v), v its steady speed at a drag coefficient of 1."""

import math

from common import SCENES, box, claim, elastogen, vertices

GRAVITY, SECONDS, MASS, AIR = 9.81, 1.5, 30 * 0.05, 1.2  # kg of a square metre, kg/m^3

box("falling_plate.obj", (-0.5, 0, -0.5), (0.5, 0.05, 0.5), (10, 1, 10))
elastogen("animate", "falling_plate.obj", "--scene", SCENES / "falling_plate.toml", "-o",
          "falling_plate.ply", "-o", "falling_plate.png")
start, end = vertices("falling_plate_00000.ply"), vertices("falling_plate_00045.ply")
fall = sum(y - after for (_, y, _), (_, after, _) in zip(start, end)) / len(start)
steady = math.sqrt(2 * MASS * GRAVITY / AIR)
expected = steady**2 / GRAVITY * math.log(math.cosh(GRAVITY * SECONDS / steady))
claim("fall over that of the formula", fall / expected, 0.97, 1.03)
claim("fall over that without air", fall / (GRAVITY * SECONDS**2 / 2), 0.4, 0.7)
