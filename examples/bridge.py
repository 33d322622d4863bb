#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A beam held at both ends, on a grid that fits neither: its sag, and what the banks carry."""

import json
from pathlib import Path

from common import SCENES, box, claim, elastogen, vertices

SPAN, DEPTH, WIDTH, YOUNG, WEIGHT = 1.8, 0.13, 0.3, 20e6, 1100 * 9.81  # m, Pa, N/m^3

box("bridge.obj", (0, 0, 0), (2, DEPTH, WIDTH), (40, 3, 6))
elastogen("animate", "bridge.obj", "--scene", SCENES / "bridge.toml", "-o", "bridge.ply",
          "-o", "bridge.png", "--report", "bridge.json")
start, end = vertices("bridge_00000.ply"), vertices("bridge_00060.ply")
sag = [(x, after[1] - y) for (x, y, _), after in zip(start, end) if y == 0]

moment, load = WIDTH * DEPTH**3 / 12, WEIGHT * WIDTH * DEPTH
shear = YOUNG / 2.6 * WIDTH * DEPTH * 5 / 6
expected = load * SPAN**4 / (384 * YOUNG * moment) + load * SPAN**2 / (8 * shear)
left, right = (min(s for x, s in sag if low < x < high) for low, high in ((0, 1), (1, 2)))
claim("sag in the middle over Timoshenko's formula", -min(left, right) / expected, 0.93, 1.05)

banks = [reaction["force"] for reaction in json.loads(Path("bridge.json").read_text())["reactions"]]
claim("what one bank carries over half of the weight", banks[0][1] / (load * SPAN / 2), 0.998, 1.002)
claim("and the other one", banks[1][1] / (load * SPAN / 2), 0.998, 1.002)
claim("push of one against the other", -banks[0][0] / banks[1][0], 0.999, 1.001)
