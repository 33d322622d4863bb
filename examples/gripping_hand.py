#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A soft hand of four fingers closes about a ball: where its tips are, and what they feel."""

import math

from common import SCENES, blocks, claim, elastogen, steps, vertices

# palm and fingers of cubes of 5 mm
FINGERS = [((5, 0, -2), (9, 16, 2)), ((-9, 0, -2), (-5, 16, 2)), ((-2, 0, 5), (2, 16, 9)),
           ((-2, 0, -9), (2, 16, -5))]
blocks("gripping_hand.obj", lambda at: [0.005 * c for c in at], [((-9, 16, -9), (9, 20, 9)), *FINGERS])
elastogen("animate", "gripping_hand.obj", "--scene", SCENES / "gripping_hand.toml", "-o",
          "gripping_hand.ply", "-o", "gripping_hand.png", "--log-json", "gripping_hand.log")

# the tip at x > 0 goes round its knuckle by 14 degrees
start, end = vertices("gripping_hand_00000.ply"), vertices("gripping_hand_00024.ply")
cos, sin = math.cos(math.radians(14)), math.sin(math.radians(14))
worst = 0.0
for (x, y, z), (x1, y1, z1) in zip(start, end):
    if x > 0.024 and y < 0.0151:
        x, y = x - 0.035, y - 0.08
        worst = max(worst, math.dist((x1 - 0.035, y1 - 0.08, z1), (cos * x + sin * y, cos * y - sin * x, z)))
claim("a tip is off by [um]", 1e6 * worst, 0, 0.1)
claim("nearest vertex to the middle of the ball over its radius",
      min(math.dist(place, (0, 0.05, 0)) for place in end) / 0.022, 0.95, 1.02)

last = steps("gripping_hand.log")[-1]
claim("energy of contact over that of the fingers", last["energies"]["contact"] / last["energies"]["elastic"],
      1e-6, 1)
inwards = [force[axis] * way for force, axis, way in
           zip((held["force"] for held in last["reactions"][1:]), (0, 0, 2, 2), (-1, 1, -1, 1))]
claim("push inwards of the weakest tip over that of the strongest", min(inwards) / max(inwards), 0.99, 1)
