#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A snowball falls freely, hits the ground and does not bounce."""

from common import SCENES, claim, elastogen, steps

GRAVITY, START, DROP = 9.81, 2.0, 0.02

elastogen("simulate", "--scene", SCENES / "snowball_2d.toml", "-o", "snow.ply", "-o", "snow.png",
          "--camera", "front", "--log-json", "snow.log")
log = steps("snow.log")

# energy before it touches the ground, which the step keeps to first order of dt
flight = [step for step in log if step["time"] < DROP / (START + 0.1)]
energy = [step["energies"]["kinetic"] + step["energies"]["gravity"] for step in flight]
claim("energy kept in flight", energy[-1] / energy[0], 0.999, 1.001)

kinetic = [step["energies"]["kinetic"] for step in log]
claim("kinetic energy left after the impact", kinetic[-1] / max(kinetic), 0, 0.05)
size = log[-1]["particles"]
claim("height of the ball after it over that before", (size["upper"][1] - size["lower"][1]) / 0.2,
      0.5, 0.99)
