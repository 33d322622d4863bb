#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What borders cost that cut voxels: steps of a bar held at both ends, beside those of one whose borders fit.

    bench/hold_times.py COMMAND [--device cpu] [--voxels 48 96] [--repeat 3] [--json FILE]

A soft bar of 1 x 0.25 x 0.25 m sags from rest, 24 implicit Euler steps of 1/60 s. The grid is laid to fit the
first pin; the second one lies half a voxel behind nodes, or at nodes. Both are run in turn. docs/holds.md has the
table."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

BODY = ("--young", "2e4", "--poisson", "0.3", "--density", "1000", "--analytic", "--damping", "0", "--mesh-error", "off")
STEPS = ("--fps", "60", "--frames", "24", "--substeps", "1", "--time-scheme", "euler")
HELD = 2  # voxels at either end


def run(given: argparse.Namespace, voxels: int, mode: str, cuts: bool) -> tuple[float, float, float, str]:
    """Milliseconds of a step, of one of its iterations (medians of the steps after the first), iterations, machine."""
    h = 1 / voxels
    pins = (f"x<{HELD * h}m", f"x>{1 - (HELD - (0.5 if cuts else 0)) * h}m")
    with tempfile.TemporaryDirectory() as folder:
        log, report = Path(folder) / "log", Path(folder) / "report"
        subprocess.run([given.command, "animate", "--shape", "box(0,0,0, 1,0.25,0.25)", "--h", f"{h:.15g}", *BODY, *STEPS,
                        "--up", "y", "--pin", pins[0], "--pin", pins[1], "--solver", mode, "--device", given.device,
                        "--quiet", "--log-json", log, "--report", report, "-o", Path(folder) / "x.pc2"], check=True)
        steps = [json.loads(line) for line in log.read_text().splitlines()][1:]
        machine = json.loads(report.read_text())["device"]
    ms = np.array([step["ms"] for step in steps])
    inner = np.array([step["inner"] for step in steps])
    return float(np.median(ms)), float(np.median(ms / inner)), float(inner.sum()), machine


def main() -> int:
    """Prints the rows, and writes them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--voxels", type=int, nargs="+", default=[48, 96])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for voxels in given.voxels:
        for mode in ("quasi", "newton"):
            found = [(run(given, voxels, mode, False), run(given, voxels, mode, True)) for _ in range(given.repeat)]
            fit, cut = (np.median(np.array([pair[k][:3] for pair in found]), axis=0) for k in (0, 1))
            rows.append({"voxels": voxels, "solver": mode, "machine": found[0][0][3],
                         "fit": list(fit), "cut": list(cut), "date": time.strftime("%Y-%m-%d")})
            print(f"{voxels} voxels long, {mode}: a step {fit[0]:.3g} ms where borders fit, {cut[0]:.3g} where one cuts; "
                  f"an iteration {fit[1]:.3g}, {cut[1]:.3g} ({100 * (cut[1] / fit[1] - 1):+.1f} %); "
                  f"iterations {fit[2]:.0f}, {cut[2]:.0f}", flush=True)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
