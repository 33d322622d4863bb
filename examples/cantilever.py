#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How far a beam sags, against Timoshenko's formula: bending and shear."""

from common import SCENES, claim, elastogen, vertices

LENGTH, THICK, YOUNG, DENSITY, GRAVITY = 1.0, 0.1, 1e8, 1000.0, 9.81

elastogen("simulate", "--scene", SCENES / "cantilever.toml", "--static", "-o", "cantilever.ply",
          "-o", "cantilever.png")
rest, bent = vertices("cantilever_00000.ply"), vertices("cantilever_00001.ply")
sag = max(a[1] - b[1] for a, b in zip(rest, bent))

weight = DENSITY * GRAVITY * THICK**2            # a metre of the beam
inertia, shear_area = THICK**4 / 12, 5 / 6 * THICK**2
bending = weight * LENGTH**4 / (8 * YOUNG * inertia)
shear = weight * LENGTH**2 / (2 * YOUNG / 2 * shear_area)
claim("sag of the end over the formula", sag / (bending + shear), 0.98, 1.02)
