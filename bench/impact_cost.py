#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What short steps and friction cost in an impact: V-cycles of the frames in which a cow of jelly lands.

    bench/impact_cost.py COMMAND --assets FOLDER [--voxels 20 40] [--steps 1 16] [--json FILE]

The cow is 30 cm long and falls 20 cm. The impact are the six frames of 1/30 s from the first touch on. Steps are of
`sdirk2`, so many a frame, by the default solver to the default tolerance, or (0) those of `auto`. docs/drops.md has the
table. Counts do not depend on the machine, so that runs may go beside each other."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from drops import TOUCHES, box_of, colliders, header

Row = dict[str, Any]
FRAMES, OF_IMPACT, FRICTION = 13, 6, 0.5


def land(command: str, asset: Path, voxels: int, steps: int, friction: float) -> Row:
    """V-cycles and more of the impact, by so many steps a frame; 0: by `auto`."""
    scheme = ["--time-scheme", "sdirk2", "--substeps", str(steps)] if steps else []
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        subprocess.run([command, "animate", asset, "--size", "0.3", "--material", "jelly", "--voxels", str(voxels), "--fps", "30",
                        *colliders("floor", box_of(command, asset)), "--friction", str(friction), "--frames", str(FRAMES),
                        *scheme, "--mesh-error", "off", "--quiet", "--log-json", log, "-o", Path(folder) / "x.pc2"],
                       check=False, stderr=subprocess.DEVNULL)
        done = [json.loads(line) for line in log.read_text().splitlines()]
    most = max(step["energies"]["kinetic"] for step in done)
    first = next(step["frame"] for step in done if step["energies"]["contact"] > TOUCHES * most)
    impact = [step for step in done if first <= step["frame"] < first + OF_IMPACT]
    return {"voxels": voxels, "steps": steps, "friction": friction, "first_frame": first, "made": len(impact),
            "frames": impact[-1]["frame"] - first + 1, "solves": sum(step["solves"] for step in impact),
            "converged": sum(step["residual"] <= step["tolerance"] for step in impact) / len(impact),
            "outer": sum(step["outer"] for step in impact), "inner": sum(step["inner"] for step in impact)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--assets", type=Path, required=True)
    parser.add_argument("--voxels", type=int, nargs="+", default=[20, 40])
    parser.add_argument("--steps", type=int, nargs="+", default=[1, 16, 0])
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows: list[Row] = json.loads(given.json.read_text())["rows"] if given.json and given.json.exists() else []
    for voxels in given.voxels:
        for steps in given.steps:
            for friction in (FRICTION, 0.0):
                row = land(given.command, given.assets / "closed/spot.obj", voxels, steps, friction)
                case = ("voxels", "steps", "friction")
                rows = [old for old in rows if any(old[key] != row[key] for key in case)] + [row]
                print(row, flush=True)
                if given.json:  # what is there where the rest takes too long
                    result = {"header": header(given.command), "rows": rows}
                    given.json.write_text(json.dumps(result, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
