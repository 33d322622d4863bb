#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A top that spins on its tip does not fall: it goes round as fast as its weight and spin say."""

import math

from common import SCENES, claim, elastogen, steps, vertices

GRAVITY, FPS, FRAMES, SPIN, TILT = 9.81, 60, 40, 150.0, math.radians(12)
PROFILE = [(0, 0), (0.045, 0.045), (0.045, 0.06), (0.008, 0.065), (0.008, 0.095), (0, 0.095)]  # r, y [m]
AROUND = 24


def tilted(x: float, y: float, z: float) -> tuple[float, float, float]:
    return (x * math.cos(TILT) + y * math.sin(TILT), y * math.cos(TILT) - x * math.sin(TILT), z)


def write_top(path: str) -> None:
    """The profile turned about its axis, which is tilted; closed at tip and end."""
    rings = [[tilted(r * math.cos(a), y, r * math.sin(a))
              for a in (2 * math.pi * k / AROUND for k in range(AROUND))] for r, y in PROFILE[1:-1]]
    points = [tilted(0, 0, 0), *(p for ring in rings for p in ring), tilted(0, PROFILE[-1][1], 0)]
    last, faces = len(points), []
    for k in range(AROUND):
        a, b = k, (k + 1) % AROUND
        faces.append((1, 2 + a, 2 + b))
        for ring in range(len(rings) - 1):
            low, high = 2 + ring * AROUND, 2 + (ring + 1) * AROUND
            faces += [(low + a, high + a, high + b), (low + a, high + b, low + b)]
        faces.append((last - AROUND + b, last - AROUND + a, last))
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points)
        file.writelines(f"f {a} {b} {c}\n" for a, b, c in faces)


def arm_over_inertia() -> float:
    """m l / I of the solid: its arm from the tip, and its moment about the axis over its mass [1/m]."""
    first = second = 0.0
    for (r, y), (r2, y2) in zip(PROFILE, PROFILE[1:]):
        for k in range(1000):
            s = (k + 0.5) / 1000
            radius, height = r + s * (r2 - r), y + s * (y2 - y)
            first += radius**2 * height * (y2 - y) / 1000
            second += radius**4 / 2 * (y2 - y) / 1000
    return first / second


def heading(frame: int) -> float:
    """Direction in which the end of the axis leans [rad]."""
    points = vertices(f"top_{frame:05d}.ply")
    return math.atan2(points[-1][2] - points[0][2], points[-1][0] - points[0][0])


write_top("top.obj")
axis = tilted(0, SPIN, 0)
elastogen("animate", "top.obj", "--scene", SCENES / "spinning_top.toml", "--spin",
          ",".join(f"{w:.9g}" for w in axis), "-o", "top.ply", "-o", "top.png", "--log-json", "top.log")

turned, before = 0.0, heading(0)
for frame in range(1, FRAMES + 1):
    now = heading(frame)
    turned += (now - before + math.pi) % (2 * math.pi) - math.pi
    before = now
expected = GRAVITY * arm_over_inertia() / SPIN
# the formula is that of a fast top on a point; this one has a blunt tip
claim("rate at which it goes round over m g l / (I w)", abs(turned) * FPS / FRAMES / expected, 0.9, 1.3)
points = vertices(f"top_{FRAMES:05d}.ply")
claim("height of its end at last over that at the start",
      (points[-1][1] - points[0][1]) / (PROFILE[-1][1] * math.cos(TILT)), 0.95, 1.02)
kinetic = [step["energies"]["kinetic"] for step in steps("top.log")]
claim("kinetic energy that is left", kinetic[-1] / kinetic[0], 0.95, 1.001)
