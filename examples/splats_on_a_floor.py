#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A ball of Gaussian splats, as a capture would hold it, falls freely and comes to rest on a floor."""

import math
import random
import struct

from common import SCENES, claim, elastogen, vertices

RADIUS, FLOOR, FPS, FRAMES, GRAVITY = 0.1, -0.2, 60, 150, 9.81
VOXEL = 2 * RADIUS / 10
COLUMNS = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
           "rot_0", "rot_1", "rot_2", "rot_3"]


def write_ball(path: str, count: int) -> None:
    """Splats spread evenly over a ball, red above and blue below, with logarithms of their sizes."""
    numbers = random.Random(1)
    rows = []
    while len(rows) < count:
        x = [numbers.uniform(-1, 1) for _ in range(3)]
        if math.hypot(*x) < 1:
            colour = [1.5, -1.0, -1.0] if x[1] > 0 else [-1.0, -1.0, 1.5]
            rows.append([RADIUS * a for a in x] + colour + [3.0] + 3 * [math.log(0.006)] + [1, 0, 0, 0])
    head = "\n".join(["ply", "format binary_little_endian 1.0", f"element vertex {count}",
                      *(f"property float {name}" for name in COLUMNS), "end_header", ""])
    with open(path, "wb") as file:
        file.write(head.encode() + b"".join(struct.pack("<14f", *row) for row in rows))


def mean_height(frame: int) -> float:
    """Of the splats [m]."""
    heights = [x[1] for x in vertices(f"splats_{frame:05d}.ply")]
    return sum(heights) / len(heights)


write_ball("ball.ply", 2000)
elastogen("animate", "ball.ply", "--scene", SCENES / "splats_on_a_floor.toml", "-o", "splats.ply", "-o", "splats.png")

# free fall: g t^2/2
fallen = mean_height(0) - mean_height(6)
claim("free fall over the formula", fallen / (GRAVITY / FPS**2 * 6 * 6 / 2), 0.999, 1.001)
lowest = min(x[1] for x in vertices(f"splats_{FRAMES:05d}.ply"))
claim("lowest splat above the floor [voxels]", (lowest - FLOOR) / VOXEL, -1, 1)
# jelly goes on wobbling: a vibration of 5 Hz keeps a seventh of its amplitude after 2.5 s
claim("motion of the last frame [m]", abs(mean_height(FRAMES) - mean_height(FRAMES - 1)), 0, 3e-3)
