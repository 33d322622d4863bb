#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What an impact costs: assets that drop by 20 cm, against free steps of a beam.

    bench/drops.py COMMAND --assets FOLDER [--voxels 24 ...] [--names ...] [--materials ...]
                   [--floors ...] [--frames 40] [--device cpu] [--jobs 1] [--json FILE]

A minimisation is a step of BDF2 or a stage of SDIRK2. Its V-cycles are set beside those of a step of
`bench step` (implicit Euler, beam, 2048 voxels) of its Poisson's ratio and Courant number (k/h) sqrt(E/rho), k
the interval that its inertia sees. Only steps that touch something count. docs/drops.md has the tables."""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

Row = dict[str, Any]
DROP, LONGEST = 0.2, 0.3  # [m]
ASSETS = {"cow": "closed/spot.obj", "bunny": "closed/bunny.obj", "koala": "closed/koala.obj",
          "armadillo": "closed/armadillo.obj", "cactus": "closed/cactus.off",
          "wingnut": "closed/wingnut.obj"}
MATERIALS = ("jelly", "soft-rubber", "rubber", "foam")
COURANT = (0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200)
INTERVAL = {"euler": 1, "bdf2": 2 / 3, "sdirk2": 1 - math.sqrt(0.5)}  # k over the length of a step
TOUCHES = 1e-4  # least energy of contact over that of the drop


def box_of(command: str, asset: Path) -> list[tuple[float, float]]:
    """The least and the largest coordinate along each axis [m]."""
    text = subprocess.run([command, "inspect", asset, "--size", str(LONGEST)], check=True,
                          capture_output=True, text=True).stdout
    ends = re.findall(r"^ *[xyz]: (\S+) \.\.\. (\S+) m$", text, re.MULTILINE)
    return [(float(low), float(high)) for low, high in ends]


def colliders(floor: str, box: list[tuple[float, float]]) -> list[str]:
    """What an asset with that box falls on."""
    x, z = (sum(box[axis]) / 2 for axis in (0, 2))
    top = box[1][0] - DROP
    if floor == "floor":
        return ["--floor", f"y={top}"]
    if floor == "ball":
        return ["--collider", f"sphere({x + 0.01},{top - 0.1},{z}, 0.1)", "--floor", f"y={top - 0.25}"]
    steps = []
    for k in range(4):  # stairs that go down along x
        low, high = top - 0.05 * k - 0.3, top - 0.05 * k
        first = x - 0.08 + 0.08 * k
        steps += ["--collider", f"box({first},{low},{z - 1}, {first + (0.08 if k < 3 else 1)},{high},{z + 1})"]
    return steps


class FreeSteps:
    """V-cycles of free steps by Courant number, for Poisson's ratios that are asked for."""

    def __init__(self, command: str) -> None:
        self.command = command
        self.of: dict[float, list[int]] = {}

    def measure(self, poisson: float) -> None:
        with tempfile.NamedTemporaryFile() as file:
            subprocess.run([self.command, "bench", "step", "--device", "cpu", "--scenes", "beam", "--sizes", "2048",
                            "--courant", ",".join(map(str, COURANT)), "--poisson", str(poisson), "--repeat", "1",
                            "--json", file.name], check=True, stdout=subprocess.DEVNULL)
            self.of[poisson] = [row["evaluations"] for row in json.loads(Path(file.name).read_text())["step"]]

    def cycles(self, poisson: float, courant: float) -> float:
        return float(np.interp(math.log(courant), np.log(COURANT), self.of[poisson]))


def drop(arguments: argparse.Namespace, asset: Path, options: list[str]) -> tuple[int, list[Row], Row, float]:
    """Exit code, log, report and seconds of a run at defaults."""
    with tempfile.TemporaryDirectory() as folder:
        log, report = Path(folder) / "log", Path(folder) / "report"
        begin = time.monotonic()
        code = subprocess.run([arguments.command, "animate", asset, *options, "--device", arguments.device,
                               "--frames", str(arguments.frames), "--quiet",
                               "--threads", str(max(1, (os.cpu_count() or 1) // arguments.jobs)),
                               "--log-json", log, "--report", report, "-o", Path(folder) / "x.pc2"], check=False, stderr=subprocess.DEVNULL).returncode
        return (code, [json.loads(line) for line in log.read_text().splitlines()], json.loads(report.read_text()),
                time.monotonic() - begin)


def measure(arguments: argparse.Namespace, free: FreeSteps, case: tuple[str, str, str, int]) -> Row:
    """The numbers of one drop."""
    name, material, floor, voxels = case
    asset = arguments.assets / ASSETS[name]
    options = ["--size", str(LONGEST), "--material", material, "--voxels", str(voxels),
               *colliders(floor, box_of(arguments.command, asset))]
    code, log, report, seconds = drop(arguments, asset, options)
    of = report["materials"][0]
    if of["poisson"] not in free.of:
        free.measure(of["poisson"])
    speed = math.sqrt(of["young"] / of["density"])
    weight = max(abs(step["energies"]["kinetic"]) for step in log)
    touching = [step for step in log if step["energies"]["contact"] > TOUCHES * weight]
    cycles = np.array([step["inner"] / step["solves"] for step in touching])
    outer = np.array([step["outer"] / step["solves"] for step in touching])
    ratio = cycles / [free.cycles(of["poisson"], INTERVAL[step["scheme"]] * step["length"] * speed / report["h"])
                      for step in touching]
    frames = [sum(step["inner"] for step in log if step["frame"] == k) for k in range(1, arguments.frames + 1)]
    ms = [sum(step["ms"] for step in log if step["frame"] == k) for k in range(1, arguments.frames + 1)]
    rest = [step for step in log if step["frame"] > arguments.frames - 10]
    return {"asset": name, "material": material, "on": floor, "across": voxels, "voxels": report["voxels"],
            "code": code, "steps": len(log), "converged": sum(step["residual"] <= step["tolerance"] for step in log) / len(log),
            "touching": len(touching), "solves": sum(step["solves"] for step in log),
            "cycles_median": float(np.median(cycles)), "ratio_median": float(np.median(ratio)),
            "ratio_95": float(np.percentile(ratio, 95)), "outer_median": float(np.median(outer)),
            "outer_95": float(np.percentile(outer, 95)), "cycles_a_frame": float(np.median(frames)),
            "most_cycles_a_frame": max(frames),
            # runs beside each other share the machine
            "ms_a_frame": float(np.median(ms)) if arguments.jobs == 1 else None,
            "most_ms_a_frame": max(ms) if arguments.jobs == 1 else None,
            "cycles_near_rest": sum(step["inner"] for step in rest) / max(sum(step["solves"] for step in rest), 1),
            "min_j": min(step["min_j"] for step in log), "seconds": seconds if arguments.jobs == 1 else None,
            "device": report["device"], "commit": report["commit"]}


def header(command: str) -> Row:
    """Commit, day and machine."""
    version = subprocess.run([command, "--version"], check=True, capture_output=True, text=True).stdout
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return {"commit": version.split("(")[-1].rstrip(")\n"), "date": time.strftime("%Y-%m-%d"),
            "cpu": cpu[1] if cpu else platform.machine()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--assets", type=Path, required=True)
    parser.add_argument("--voxels", type=int, nargs="+", default=[24])
    parser.add_argument("--names", nargs="+", default=list(ASSETS))
    parser.add_argument("--materials", nargs="+", default=list(MATERIALS))
    parser.add_argument("--floors", nargs="+", default=["floor", "ball", "stairs"])
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    free = FreeSteps(arguments.command)
    rows: dict[int, Row] = {}
    with ThreadPoolExecutor(arguments.jobs) as pool:
        cases = product(arguments.voxels, arguments.names, arguments.materials, arguments.floors)
        runs = {pool.submit(measure, arguments, free, (name, material, floor, voxels)): k
                for k, (voxels, name, material, floor) in enumerate(cases)}
        for run in as_completed(runs):
            row = rows[runs[run]] = run.result()
            if arguments.json:  # what is there where the rest takes too long
                done = {"header": header(arguments.command), "rows": [rows[k] for k in sorted(rows)]}
                arguments.json.write_text(json.dumps(done, indent=1) + "\n")
            print(" ".join(f"{value:.3g}" if isinstance(value, float) else str(value) for value in row.values()),
                  flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
