#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The network against finite elements with its own element in float64: four scenes, three laws,
three Poisson ratios, 60 steps.

    tests/scenes/accuracy.py --binary build/cpu/elastogen [--json FILE] [--scenes NAME ...]

Prints a Markdown table: the largest displacement error of a step that starts at the reference's
state, and of the run on its own (docs/study.md), at the default tolerance. Exit status 1 if an error
of a step is above 1e-3 with the mode that `auto` takes (network/solver.hpp)."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from definitions import definitions_hash, scene_files

HERE = Path(__file__).resolve().parent
SCENES = ("beam", "twist", "torus", "knot")
LAWS = ("neo-hookean", "stable-neo-hookean", "fixed-corotated")
RATIOS = (0.3, 0.45, 0.49)
NEWTON_ABOVE = 0.47  # Poisson ratio from which on `auto` takes newton; Courant numbers are below 100
BOUND = 1e-3  # of the displacement error of a step at the default tolerance


def study(binary: Path, scene: str, law: str, ratio: float) -> dict[str, Any]:
    """The study.json of one combination, network by quasi and newton at the default tolerance."""
    with tempfile.TemporaryDirectory() as folder:
        words = [str(binary), "study", "--scene", str(HERE / "verification" /
                 f"network_{scene}.toml"), "--law", law, "--poisson", str(ratio), "--folder",
                 folder, "--refine", "0", "--time-steps", "1", "--repeat", "1", "--solvers",
                 "quasi,newton", "--tolerances", "1e-3"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.stderr}")
        return json.loads((Path(folder) / "study.json").read_text())


def row(scene: str, law: str, ratio: float, result: dict[str, Any]) -> dict[str, Any]:
    """What the table says of a combination."""
    runs = {run["solver"]: run for run in result["runs"]}
    entry: dict[str, Any] = {"scene": scene, "law": law, "poisson": ratio,
                             "voxels": runs["fem"]["voxels"], "steps": runs["fem"]["steps"],
                             "fem_ms": runs["fem"]["step_ms"]["median"]}
    for solver in ("quasi", "newton"):
        errors = runs[solver]["solver_error"]
        entry[solver] = {"step": errors["step"]["max"], "free": errors["free_run"]["max"],
                         "converged": runs[solver]["converged_share"],
                         "ms": runs[solver]["step_ms"]["median"]}
    return entry


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    options.add_argument("--scenes", nargs="*", default=SCENES, choices=SCENES)
    chosen = options.parse_args()
    rows = []
    print("| scene | voxels | law | nu | quasi, a step | free run | newton, a step | free run |\n"
          "|---|---|---|---|---|---|---|---|")
    for scene in chosen.scenes:
        for law in LAWS:
            for ratio in RATIOS:
                r = row(scene, law, ratio, study(chosen.binary, scene, law, ratio))
                rows.append(r)
                print(f"| {scene} | {r['voxels']} | {law} | {ratio} | {r['quasi']['step']:.1e} | "
                      f"{r['quasi']['free']:.1e} | {r['newton']['step']:.1e} | "
                      f"{r['newton']['free']:.1e} |", flush=True)
    if chosen.json:
        files = ["tests/scenes/accuracy.py", *scene_files([f"network_{s}" for s in SCENES])]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "bound": BOUND, "rows": rows},
                                          indent=1) + "\n")
    worst = {solver: max(r[solver]["step"] for r in rows) for solver in ("quasi", "newton")}
    taken = max(r["newton" if r["poisson"] > NEWTON_ABOVE else "quasi"]["step"] for r in rows)
    print(f"worst error of a step: auto {taken:.2e} (bound {BOUND:.0e}), quasi {worst['quasi']:.2e}, "
          f"newton {worst['newton']:.2e}")
    return int(not taken <= BOUND)


if __name__ == "__main__":
    sys.exit(main())
