#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A column of sand collapses into a heap that is no steeper than its friction allows."""

import math

from common import SCENES, claim, elastogen, steps

elastogen("simulate", "--scene", SCENES / "sand_column_2d.toml", "--h", "2 cm", "--dt", "2 ms",
          "-o", "sand.ply", "-o", "sand.png", "--camera", "front", "--log-json", "sand.log")
log = steps("sand.log")
last = log[-1]
energy = [sum(step["energies"].values()) for step in log]
claim("largest gain of energy in a step over the energy lost",
      max(b - a for a, b in zip(energy, energy[1:])) / (energy[0] - energy[-1]), -1, 1e-3)
claim("kinetic energy at the end over the largest",
      last["energies"]["kinetic"] / max(step["energies"]["kinetic"] for step in log), 0, 1e-2)

# in the plane a cone through triaxial compression has the angle with sine sqrt(2) alpha
alpha = math.sqrt(2 / 3) * 2 * 0.5 / (3 - 0.5)
angle = math.degrees(math.asin(math.sqrt(2) * alpha))
lower, upper = last["particles"]["lower"], last["particles"]["upper"]
slope = math.degrees(math.atan(upper[1] / ((upper[0] - lower[0]) / 2)))
claim("slope of the heap [degrees]", slope, 5, angle + 1)
