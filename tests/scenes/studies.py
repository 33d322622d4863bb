#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Studies of six scenes: pages for docs/studies, numbers for the tables of the documentation.

    tests/scenes/studies.py --binary build/cpu/elastogen [--asset spot.obj] [NAME ...]

Writes docs/studies/NAME.html and docs/results/study_NAME.json. The asset is that of the scene asset,
which is not in the repository; without one the others run."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from definitions import ROOT, definitions_hash, scene_files

# what keeps the finite elements of each scene to minutes
SCENES = {"beam": (), "twist": ("--frames", "30"), "torus": ("--frames", "20"),
          "knot": ("--frames", "15", "--voxels", "14"),
          "porous": ("--frames", "15", "--voxels", "12")}
ASSET = ("--size", "0.3", "--voxels", "14", "--pin", "y<12%", "--young", "1e5", "--density", "1000",
         "--fps", "60", "--substeps", "1", "--frames", "15")
KEPT = ("name", "solver", "element", "h", "dt", "dofs", "step_ms", "worst_residual",
        "converged_share", "solver_error", "discretisation_error")


def short(run: dict[str, Any]) -> dict[str, Any]:
    """A run without its series."""
    kept = {key: run[key] for key in KEPT}
    for family in ("solver_error", "discretisation_error"):
        if kept[family]:
            kept[family] = kept[family] | {measure: {"max": kept[family][measure]["max"]}
                                           for measure in ("step", "free_run")}
    return kept


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("names", nargs="*", metavar="NAME")
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--asset", type=Path, help="a closed mesh")
    chosen = options.parse_args()
    (ROOT / "docs" / "studies").mkdir(exist_ok=True)
    for name in chosen.names or [*SCENES, *(["asset"] if chosen.asset else [])]:
        scene = f"tests/scenes/verification/network_{name}.toml"
        folder = f"build/study/{name}"
        if name == "asset":  # the page names its file: no path of this machine
            copy = Path("build/study") / chosen.asset.name
            (ROOT / copy).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(chosen.asset, ROOT / copy)
            what = [str(copy), *ASSET]
        else:
            what = ["--scene", scene, *SCENES[name]]
        words = [str(chosen.binary.resolve()), "study", *what, "--folder", folder]
        subprocess.run(words, check=True, cwd=ROOT)
        result = json.loads((ROOT / folder / "study.json").read_text())
        shutil.copy(ROOT / folder / "study.html", ROOT / "docs" / "studies" / f"{name}.html")
        files = ["tests/scenes/studies.py",
                 *scene_files([] if name == "asset" else [f"network_{name}"])]
        header = {key: result["header"][key] for key in ("commit", "date", "machine", "repeats")}
        numbers = {"definitions": {"files": files, "sha256": definitions_hash(files)},
                   "header": header, "runs": [short(run) for run in result["runs"]],
                   "sweeps": result["sweeps"], "time_to_error": result["time_to_error"]}
        target = ROOT / "docs" / "results" / f"study_{name}.json"
        target.write_text(json.dumps(numbers, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
