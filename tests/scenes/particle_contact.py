#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Contact of particles with colliders against what it should be.

    tests/scenes/particle_contact.py --binary build/cpu/elastogen [--json FILE] [--only NAME ...] [--threads N]
                                     [--short]

A plate without friction comes down on an elastic square in the plane, which slips on its floor (nu = 0, so the
square is a bar): its energy gives by how much it is shorter, ln(l/L)^2 E V/2, which should be how far the plate has
come beyond its top. Contact acts at nodes, and a node has mass from particles nearer than 1.5 h: so the force
begins where the plate meets the highest such node. Exit status 1 if it begins elsewhere, or the length is wrong by
more than half a cell.

A ball of 2 cm radius is pressed 4 mm into a block of metal of 6 cm x 2 cm x 6 cm, of particles and of voxels by
finite elements; the depth is that of the surface on the axis, of particles by a line through the two uppermost
layers. The metal is aluminium a ten-thousandth as stiff and as strong, which changes no depth."""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from definitions import definitions_hash, run_header
from runs import Finished, run_scene

YOUNG, EDGE, START, WAY, STEPS = 1e6, 0.1, 0.0203, 0.0224, 112  # [Pa], [m] of the square, plate's way, steps
RADIUS, PRESSED, BALL_STEPS = 0.02, 4e-3, 12

PLATE = """gravity = [0, 0, 0]
[shape]
kind = "rectangle"
lower = [-0.05, 0, 0]
upper = [0.05, {top}, 0]
[asset]
h = {h}
[material]
preset = "aluminium"
law = "hencky"
young = "1 MPa"
poisson = 0
density = 1000
yield = "1 GPa"
[floor]
friction = 0
[[collider]]
shape = "plane"
centre = [0, {plate}, 0]
normal = [0, -1, 0]
friction = 0
path = [[0, 0, 0, 0], [1, 0, {way}, 0]]
[particles]
jitter = 0
[time]
frames = {steps}
fps = {steps}
substeps = 1
"""

BALL = """gravity = [0, 0, 0]
{pins}
[shape]
kind = "box"
lower = [-0.03, 0, -0.03]
upper = [0.03, 0.02, 0.03]
[asset]
h = {h}
[material]
preset = "aluminium"
young = "6.9 MPa"
yield = "27.6 kPa"
hardening = "50 kPa"
{floor}
[[collider]]
shape = "sphere"
centre = [0, 0.0405, 0]
radius = 0.02
friction = 0.3
path = [[0, 0, 0, 0], [0.125, 0, -0.0045, 0]]
[particles]
jitter = 0
[time]
frames = {steps}
fps = 96
substeps = 1
"""


def played(binary: Path, text: str, words: tuple[str, ...], threads: int, folder: Path) -> Finished:
    """A run of a scene."""
    (folder / "scene.toml").write_text(text)
    run = run_scene(binary, "simulate", folder / "scene.toml", ("--threads", str(threads), *words), folder, 3600)
    if run.code:
        raise SystemExit(f"exit code {run.code}: {run.err}")
    return run


def steps_of(run: Finished) -> list[dict[str, Any]]:
    """Of its log."""
    lines = [json.loads(line) for line in (run.folder / "log.json").read_text().splitlines()]
    return [line for line in lines if "residual" in line]


def plate(binary: Path, threads: int, h: float, above: float) -> dict[str, Any]:
    """A row; the square is higher than 0.1 m by `above` cells."""
    top = EDGE + above * h
    text = PLATE.format(h=h, top=top, plate=top + START, way=-WAY, steps=STEPS)
    with tempfile.TemporaryDirectory() as folder:
        steps = steps_of(played(binary, text, ("--method", "mpm"), threads, Path(folder)))
    gap = np.array([START - WAY * step["time"] for step in steps])
    energy = np.array([step["energies"]["elastic"] for step in steps])
    shorter = top * -np.expm1(-np.sqrt(2 * energy / (YOUNG * top * EDGE)))
    # the highest line of nodes with mass
    line = h * (math.ceil((top - h / 4) / h + 1.5 - 1e-9) - 1)
    at = int(np.argmin(np.abs(gap)))
    return {"h": h, "above": above, "begins": gap[energy > 1e-12 * energy[-1]][0], "expected": line - top,
            "a_step": WAY / STEPS, "gap": gap[at], "shorter_at_touch": shorter[at],
            "gap_at_end": gap[-1], "shorter_at_end": shorter[-1],
            "drafts": sum(not step["converged"] for step in steps)}


def ball(binary: Path, threads: int, h: float, method: str) -> dict[str, Any]:
    """A row."""
    of_particles = method == "mpm"
    text = BALL.format(h=h, steps=BALL_STEPS, pins="" if of_particles else 'pins = ["y<5%"]',
                       floor='[floor]\nfriction = "sticky"' if of_particles else "")
    words = ("--method", "mpm") if of_particles else ("--element", "hex-bbar")
    with tempfile.TemporaryDirectory() as folder:
        run = played(binary, text, words, threads, Path(folder))
        steps = steps_of(run)
        x = run.state["particles/x" if of_particles else "steps/x"]
        rest = x[0] if of_particles else run.rest
    sunk = rest[:, 1] - x[-1][:, 1]
    heights = np.unique(np.round(rest[:, 1], 6))[-2:]
    depths = [sunk[np.abs(rest[:, 1] - y) < 1e-5].max() for y in heights]
    # at the height of the surface
    surface = depths[1] + (0.02 - heights[1]) * (depths[1] - depths[0]) / (heights[1] - heights[0])
    return {"h": h, "method": method, "points": len(rest), "depth": surface, "pressed": PRESSED,
            "overlap": h * steps[-1]["deepest_overlap"],
            "drafts": sum(not step["converged"] for step in steps)}


Row = Callable[[Path, int], dict[str, Any]]
ROWS: dict[str, Row] = {
    **{f"plate {1e3 * h:g} mm, {above:g}": lambda b, n, h=h, above=above: plate(b, n, h, above)
       for h in (0.02, 0.01, 0.005, 0.0025) for above in (0, 0.5)},
    **{f"ball {1e3 * h:g} mm, {method}": lambda b, n, h=h, method=method: ball(b, n, h, method)
       for h in (0.005, 0.0025, 0.00125) for method in ("mpm", "fem")}}
SHORT = ["plate 20 mm, 0", "plate 10 mm, 0.5"]


def is_wrong(row: dict[str, Any]) -> bool:
    """Whether a row of the plate is out of bounds."""
    if "begins" not in row:
        return bool(row["drafts"])
    early = row["expected"] - row["begins"]
    lengths = [row["shorter_at_touch"] + min(row["gap"], 0), row["shorter_at_end"] + row["gap_at_end"]]
    return not 0 <= early + 1e-9 <= row["a_step"] + 2e-9 or max(map(abs, lengths)) > row["h"] / 2


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path)
    options.add_argument("--only", nargs="*", default=list(ROWS))
    options.add_argument("--threads", type=int, default=1)
    options.add_argument("--short", action="store_true", help="two plates alone")
    chosen = options.parse_args()
    old = json.loads(chosen.json.read_text())["rows"] if chosen.json and chosen.json.exists() else []
    rows = {row["name"]: row for row in old}
    wrong = []
    for name in SHORT if chosen.short else chosen.only:
        rows[name] = {"name": name} | ROWS[name](chosen.binary, chosen.threads)
        print(json.dumps(rows[name]), flush=True)
        wrong += [name] if is_wrong(rows[name]) else []
        if chosen.json:
            files = ["tests/scenes/particle_contact.py"]
            chosen.json.write_text(json.dumps(
                {"definitions": {"files": files, "sha256": definitions_hash(files)}, "header": run_header(),
                 "rows": [rows[n] for n in ROWS if n in rows]}, indent=1) + "\n")
    for name in wrong:
        print(f"out of bounds: {rows[name]}", file=sys.stderr)
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
