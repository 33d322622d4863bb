#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Columns of sand in the plane that collapse on rough ground: run-out against what experiments found
in channels, and the slope of the heap against the angle of friction.

    tests/scenes/collapse.py --binary build/cpu/elastogen [--json FILE] [--short]

A column of half width l and height a l comes to rest with half width L; experiments (Lube et al. 2005,
Lajeunesse et al. 2005) have (L - l)/l = 1.2 a for a < 2.3. The slope is that of a line through the
heap's height where it is between a fifth and four fifths of its top. Exit status 1 if a slope is more
than a degree above the law's angle in the plane, or the heap is no mirror image of itself."""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from definitions import ROOT, definitions_hash, run_header
from runs import launch

SCENE = "examples/scenes/sand_column_2d.toml"
HALF_WIDTH = 0.1  # [m]
PUBLISHED = 1.2  # run-out over aspect
ASPECTS, ANGLES = (0.5, 1.0, 2.0), (20, 25, 30, 35, 40)
SPACINGS = (0.01, 0.005)  # of the grid [m]
# aspect, angle of friction [degrees], spacing
RUNS = [*((a, 30, h) for h in SPACINGS for a in ASPECTS),
        *((1.0, phi, 0.01) for phi in ANGLES if phi != 30)]
SHORT = [(0.5, 30, 0.02), (1.0, 30, 0.02), (1.0, 20, 0.02)]


def plane_angle(degrees: float) -> float:
    """Angle in the plane of a cone through triaxial compression [degrees]: sin = sqrt(2) alpha."""
    sine = math.sin(math.radians(degrees))
    return math.degrees(math.asin(math.sqrt(2) * math.sqrt(2 / 3) * 2 * sine / (3 - sine)))


def last_places(path: Path) -> NDArray[np.float64]:
    """Of a point cache [m], (points, 3)."""
    raw = path.read_bytes()
    points = int(np.frombuffer(raw[16:20], "<i4")[0])
    return np.frombuffer(raw[-12 * points:], "<f4").reshape(points, 3).astype(float)


def slope(x: NDArray[np.float64], h: float) -> float:
    """Of both sides together [degrees]."""
    column = np.floor(np.abs(x[:, 0]) / h).astype(int)
    top = np.array([x[column == k, 1].max() if np.any(column == k) else 0.0
                    for k in range(column.max() + 1)])
    middle = (top > 0.2 * top.max()) & (top < 0.8 * top.max())
    at = (np.flatnonzero(middle) + 0.5) * h
    return math.degrees(math.atan(-np.polyfit(at, top[middle], 1)[0]))


def collapse(binary: Path, aspect: float, angle: float, h: float) -> dict[str, Any]:
    """A row."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        size = f"rectangle({-HALF_WIDTH},0,0, {HALF_WIDTH},{aspect * HALF_WIDTH},0)"
        done = launch([str(binary.resolve()), "animate", "--scene", str(ROOT / SCENE), "--shape", size,
                       "--h", repr(h), "--friction-angle", f"{angle} deg", "--keeps-volume", "true",
                       "--frames", "50", "--threads", "1", "--quiet", "-o", str(folder / "out.pc2"),
                       "--log-json", str(folder / "log.json")], folder, 600)
        if done.code:
            raise RuntimeError(done.err)
        x = last_places(folder / "out.pc2")
        steps = [json.loads(line) for line in (folder / "log.json").read_text().splitlines()]
    steps = [step for step in steps if "residual" in step]
    front = np.abs(x[:, 0]).max()
    return {"aspect": aspect, "angle": angle, "h": h, "particles": len(x),
            "run_out": (front - HALF_WIDTH) / HALF_WIDTH, "top": x[:, 1].max() / HALF_WIDTH,
            "slope": slope(x, h), "plane_angle": plane_angle(angle),
            "mirror": abs(x[:, 0].max() + x[:, 0].min()) / front,
            "volume": steps[-1]["particles"]["volume"] / (2 * aspect * HALF_WIDTH ** 2),
            "drafts": sum(not step["converged"] for step in steps),
            "fallbacks": sum(step["fallbacks"] for step in steps)}


def exponent(rows: list[dict[str, Any]]) -> float:
    """Of the run-out in the aspect, by least squares."""
    logs = [(math.log(r["aspect"]), math.log(r["run_out"])) for r in rows]
    return float(np.polyfit(*zip(*logs), 1)[0])


def main() -> int:
    """Runs them all, or the short ones."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path)
    options.add_argument("--short", action="store_true", help="coarse ones alone")
    chosen = options.parse_args()
    rows = []
    for run in SHORT if chosen.short else RUNS:
        rows.append(collapse(chosen.binary, *run))
        print(json.dumps(rows[-1]), flush=True)
    exponents = {str(h): exponent([r for r in rows if r["h"] == h and r["angle"] == 30])
                 for h in sorted({r["h"] for r in rows}, reverse=True)}
    print(exponents)
    if chosen.json:
        files = ["tests/scenes/collapse.py", SCENE]
        chosen.json.write_text(json.dumps(
            {"definitions": {"files": files, "sha256": definitions_hash(files)}, "header": run_header(),
             "rows": rows, "exponents": exponents}, indent=1) + "\n")
    wrong = [r for r in rows if r["slope"] > r["plane_angle"] + 1 or r["mirror"] > 1e-3 or r["drafts"]]
    for row in wrong:
        print(f"out of bounds: {row}", file=sys.stderr)
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
