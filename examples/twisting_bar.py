#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The energy of a twisted bar, against Saint-Venant's torsion of a square."""

import math

from common import SCENES, claim, elastogen, steps

LENGTH, EDGE, SHEAR = 1.0, 0.1, 1e6 / (2 * 1.3)

elastogen("simulate", "--scene", SCENES / "twisting_bar.toml", "--static", "-o", "twisting_bar.ply",
          "-o", "twisting_bar.png", "--log-json", "twisting_bar.log")
energy = steps("twisting_bar.log")[-1]["energies"]
stored = energy["elastic"] + energy["hourglass"]

angle, torsion = math.radians(20), 0.1406 * EDGE**4
claim("energy over G J a^2/(2 L)", stored / (SHEAR * torsion * angle**2 / (2 * LENGTH)), 0.97, 1.06)
