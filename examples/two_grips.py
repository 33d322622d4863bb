#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A bar is twisted between two grips by half a turn, and back: where it is held, and its energy."""

import json
from pathlib import Path

from common import SCENES, box, claim, elastogen, steps, vertices

box("two_grips.obj", (0, -0.05, -0.05), (0.5, 0.05, 0.05), (50, 10, 10))
elastogen("animate", "two_grips.obj", "--scene", SCENES / "two_grips.toml", "-o",
          "two_grips.ply", "-o", "two_grips.png", "--log-json", "two_grips.log", "--report", "two_grips.json")

# a quarter turn each: y goes to z at the left, and to -z at the right
start, turned = vertices("two_grips_00000.ply"), vertices("two_grips_00030.ply")
worst = 0.0
for (x, y, z), (_, after_y, after_z) in zip(start, turned):
    way = 1 if x < 0.01 else -1 if x > 0.49 else 0
    if way:
        worst = max(worst, abs(after_y + way * z), abs(after_z - way * y))
claim("points in the grips are off by [um]", 1e6 * worst, 0, 0.1)

log = steps("two_grips.log")
torques = [step["reactions"][0]["moment"][0] for step in log]
others = [step["reactions"][1]["moment"][0] for step in log]
claim("torque of one grip over that of the other", -max(torques) / min(others), 0.99, 1.01)
energies = [step["energies"]["elastic"] + step["energies"]["hourglass"] for step in log]
claim("energy at the end over the largest", energies[-1] / max(energies), 0, 1e-3)
ledger = json.loads(Path("two_grips.json").read_text())["ledger"]["energy"]
lost = ledger["pins"] - ledger["damped"]
claim("work of the grips that damping did not take, of the largest energy", lost / max(energies),
      -0.02, 0.02)
