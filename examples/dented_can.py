#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A dent in a can stays, a little shallower than the ball had pressed it."""

import math

from common import SCENES, claim, elastogen, steps, vertices

RADIUS, WALL, HEIGHT, SIDES, RINGS = 0.033, 0.008, 0.1, 48, 25


def write_can(path: str) -> None:
    """An outer and an inner closed cylinder, the inner one turned inside out."""
    lines, faces = [], []
    for r, low, high, sign in ((RADIUS, 0, HEIGHT, 1), (RADIUS - WALL, WALL, HEIGHT - WALL, -1)):
        first = len(lines) + 1
        for j in range(RINGS):
            y = low + (high - low) * j / (RINGS - 1)
            lines += [f"v {r * math.cos(2 * math.pi * k / SIDES)} {y} "
                      f"{r * math.sin(2 * math.pi * k / SIDES)}" for k in range(SIDES)]
        for j in range(RINGS - 1):
            for k in range(SIDES):
                a, b = first + j * SIDES + k, first + j * SIDES + (k + 1) % SIDES
                faces.append([a, a + SIDES, b + SIDES, b][::sign])
        faces.append([first + k for k in range(SIDES)][::sign])
        faces.append([first + (RINGS - 1) * SIDES + k for k in reversed(range(SIDES))][::sign])
    with open(path, "w") as file:
        file.write("\n".join(lines + ["f " + " ".join(map(str, face)) for face in faces]) + "\n")


def dent(frame: int) -> float:
    """How far the side has come in [m]."""
    rest, now = vertices("dented_can_00000.ply"), vertices(f"dented_can_{frame:05d}.ply")
    return max(a[0] - b[0] for a, b in zip(rest, now) if a[0] > 0.9 * RADIUS)


write_can("can.obj")
elastogen("simulate", "can.obj", "--scene", SCENES / "dented_can.toml", "--tolerance", "1e-4", "-o", "dented_can.ply",
          "-o", "dented_can.png", "--camera", "right", "--log-json", "dented_can.log")
deepest, left = max(dent(frame) for frame in range(11)), dent(10)
claim("deepest dent [mm]", 1e3 * deepest, 5, 11)
claim("dent that stays over the deepest", left / deepest, 0.6, 0.999)
claim("work of plastic flow [J]", steps("dented_can.log")[-1]["energies"]["plastic"], 1e-3, 1e3)
