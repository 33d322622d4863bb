#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A snowball falls freely, hits the ground and does not bounce."""

from common import SCENES, claim, elastogen, steps

CELL, GAP, START = 0.02, 0.1, 2.0  # to the ground, which is felt a cell and a half above it [m], [m/s]

elastogen("simulate", "--scene", SCENES / "snowball_2d.toml", "--shape", "disk(0,0.2,0, 0.1)",
          "--h", CELL, "--dt", "2 ms", "-o", "snow.ply", "-o", "snow.png", "--camera", "front",
          "--log-json", "snow.log")
log = steps("snow.log")

# energy before it touches the ground, which the step keeps to first order of dt
flight = [step for step in log if step["time"] < (GAP - 2 * CELL) / (START + 0.5)]
energy = [step["energies"]["kinetic"] + step["energies"]["gravity"] for step in flight]
claim("energy kept in flight", energy[-1] / energy[0], 0.999, 1.001)

kinetic = [step["energies"]["kinetic"] for step in log]
claim("kinetic energy left after the impact", kinetic[-1] / max(kinetic), 0, 0.05)
size = log[-1]["particles"]
claim("height of the ball after it over that before", (size["upper"][1] - size["lower"][1]) / 0.2,
      0.5, 0.99)
