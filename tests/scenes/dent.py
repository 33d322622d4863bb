#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A ball is pressed 4 mm into aluminium and drawn back, by steps of several lengths: how deep the dent is and
how deep it stays must not depend on them.

    tests/scenes/dent.py --binary build/cpu/elastogen --json docs/results/dent.json [--short] [--jobs N]

Two bodies of voxels of 5 mm: a plate of 10 cm x 10 cm x 1 cm held at its rim, which bends, and a block of twice
that height held at its bottom, which is only dented. The ball waits at the bottom of its way until a step of every
length ends there. --short: the plate by the two longest steps; exit status 1 if depths are more than 2 % apart."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from definitions import definitions_hash, run_header
from runs import run_scene

RIM = '["x<2%", "x>98%", "z<2%", "z>98%"]'
BODIES = {"plate": (0.01, RIM), "block": (0.02, '["y<5%"]')}  # height [m], pins
RATES = (24, 96, 250, 1000)  # steps a second
PRESSED, WAITS, DRAWN_BACK = 0.12, 0.13, 1 / 6  # [s]
DEPTH, ABOVE = 4e-3, 5e-4  # [m]
ALLOWED = 0.02

SCENE = """pins = {pins}
gravity = [0, 0, 0]

[shape]
kind = "box"
lower = [-0.05, 0, -0.05]
upper = [0.05, {height}, 0.05]

[asset]
h = 0.005

[material]
preset = "aluminium"

[[collider]]
shape = "sphere"
name = "ball"
centre = [0, {centre}, 0]
radius = 0.02
friction = 0.3
path = [[0, 0, 0, 0], [{pressed}, 0, {lowest}, 0], [{waits}, 0, {lowest}, 0], [{drawn_back}, 0, 0.004, 0]]

[time]
frames = {frames}
fps = {rate}
substeps = 1
"""


def dent(binary: Path, body: str, rate: int) -> dict[str, Any]:
    """A row: depths in mm of the deepest node of the upper face."""
    height, pins = BODIES[body]
    text = SCENE.format(pins=pins, height=height, centre=height + 0.02 + ABOVE, pressed=PRESSED, waits=WAITS,
                        lowest=-DEPTH - ABOVE, drawn_back=DRAWN_BACK, rate=rate,
                        frames=-int(-1.05 * DRAWN_BACK * rate // 1) + 1)
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "dent.toml"
        scene.write_text(text)
        run = run_scene(binary, "simulate", scene, ("--element", "hex-bbar"), Path(folder), 1800)
        if run.code != 0:
            raise SystemExit(f"{body} by steps of 1/{rate} s: exit code {run.code}: {run.err}")
        report = json.loads((Path(folder) / "report.json").read_text())
        upper = run.rest[:, 1] > height - 1e-6
        depth = -1e3 * run.u[:, upper, 1].min(axis=1)
    return {"body": body, "steps_a_second": rate, "deepest": depth.max(), "stays": depth[-1],
            "steps": report["steps"], "certified": round(report["converged_share"] * report["steps"])}


def spreads(rows: list[dict[str, Any]]) -> list[float]:
    """(largest - least)/least of either depth over the steps, of each body."""
    found = []
    for body in dict.fromkeys(row["body"] for row in rows):
        for depth in ("deepest", "stays"):
            numbers = [row[depth] for row in rows if row["body"] == body]
            found.append(max(numbers) / min(numbers) - 1)
    return found


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path)
    options.add_argument("--short", action="store_true")
    options.add_argument("--jobs", type=int, default=1, help="rows at once")
    chosen = options.parse_args()
    cases = [(body, rate) for body in BODIES for rate in RATES]
    with ThreadPoolExecutor(chosen.jobs) as pool:
        rows = list(pool.map(lambda case: dent(chosen.binary, *case), cases[:2] if chosen.short else cases))
    if chosen.json:
        files = ["tests/scenes/dent.py"]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "header": run_header(), "rows": rows},
                                          indent=1) + "\n")
    for row in rows:
        print(row)
    print("spreads:", ", ".join(f"{100 * s:.2f} %" for s in spreads(rows)))
    drafts = sum(row["steps"] - row["certified"] for row in rows)
    return int(drafts > 0 or max(spreads(rows)) > ALLOWED and chosen.short)


if __name__ == "__main__":
    sys.exit(main())
