#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A block on a slope: friction 0.5 holds it at 20 degrees, and at 45 it slides as Coulomb says."""

import math

from common import SCENES, claim, elastogen, vertices

GRAVITY, FRICTION, FPS, FRAMES = 9.81, 0.5, 30, 45


def ways(angle: float) -> list[float]:
    """How far the block has slid along the slope at each frame [m]."""
    gravity = f"{GRAVITY * math.sin(angle)},{-GRAVITY * math.cos(angle)},0"
    name = f"slope_{math.degrees(angle):.0f}"
    elastogen("animate", "--scene", SCENES / "block_on_a_slope.toml", "--gravity", gravity,
              "-o", f"{name}.ply", "-o", f"{name}.png", "--camera", "front")
    means = []
    for frame in range(FRAMES + 1):
        points = vertices(f"{name}_{frame:05d}.ply")
        means.append(sum(x for x, _, _ in points) / len(points))
    return [x - means[0] for x in means]


held = ways(math.radians(20))
claim("slip while the block takes its weight [mm]", 1e3 * held[-1], 0, 1.2)
claim("creep in the last half second [mm]", 1e3 * abs(held[-1] - held[-1 - FPS // 2]), 0, 0.02)

slope = math.radians(45)
acceleration = GRAVITY * (math.sin(slope) - FRICTION * math.cos(slope))
expected = acceleration * (FRAMES / FPS) ** 2 / 2
claim("way at 45 degrees over that by Coulomb's law", ways(slope)[-1] / expected, 0.99, 1.01)
