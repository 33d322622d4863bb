#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A rubber ball falls on a floor and bounces: as high as with 32 steps in each frame."""

from common import SCENES, claim, elastogen, steps

DROP, GRAVITY = 1.0, 9.81


def play(name: str, *options: str) -> tuple[float, list[dict]]:
    """Height of the first hop over that of the drop, and the log of the run."""
    # the frames of impacts miss their time error; what that costs the claims below say
    elastogen("animate", "--scene", SCENES / "bouncing_ball.toml", *options,
              "-o", f"{name}.glb", "-o", f"{name}.png", "--log-json", f"{name}.log")
    log = steps(f"{name}.log")
    mass = log[0]["energies"]["kinetic"] / (GRAVITY**2 * log[0]["time"] ** 2 / 2)
    heights = [-step["energies"]["gravity"] / (-mass * GRAVITY) for step in log]  # of the centre
    low = heights.index(min(heights[: len(heights) * 2 // 3]))
    return (max(heights[low:]) + DROP) / DROP, log


hop, log = play("ball")
fine, _ = play("ball_fine", "--time-scheme", "sdirk2", "--substeps", "32")
claim("height of the hop over that of the drop", hop, 0.3, 0.95)
claim("that over the one of finer steps", hop / fine, 0.97, 1.03)

# energy goes into damping and friction and is never won
totals = [sum(step["energies"].values()) for step in log]
rise = max(after - min(totals[: k + 1]) for k, after in enumerate(totals[1:]))
claim("rise of the energy over the largest kinetic one",
      rise / max(step["energies"]["kinetic"] for step in log), -1, 0.001)
claim("energy that damping took over the one that is lost",
      sum(step["damped"] for step in log) / (totals[0] - totals[-1]), 0.5, 1.2)
