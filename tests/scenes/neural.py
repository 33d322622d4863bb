#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""NeuralMTL in the place of the laws: cantilever and twisted bar, three laws, three Poisson ratios,
60 steps, against the law in the same solver and against finite elements.

    tests/scenes/neural.py --binary build/cpu/elastogen [--json FILE] [--short]

Displacement differences are mass-weighted norms over the largest of the run. Exit status 1 if one to
the law is above 1e-3, one to finite elements above 2e-3, or Newton needs over 20 % more steps."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from accuracy import LAWS, RATIOS
from definitions import definitions_hash, scene_files
from runs import Finished, run_scene

HERE = Path(__file__).resolve().parent
SCENES = ("beam", "twist")
TO_LAW, TO_FEM, MORE_STEPS = 1e-3, 2e-3, 0.2
PAST = 900  # [s] after which a run is killed
TIGHT = ("--solver", "newton", "--tolerance", "1e-6")


def run(binary: Path, scene: str, verb: str, options: list[str]) -> Finished:
    """A run that has converged."""
    with tempfile.TemporaryDirectory() as folder:
        done = run_scene(binary, verb, HERE / "verification" / f"network_{scene}.toml", options,
                         Path(folder) / "run", PAST)
        if done.code:
            raise SystemExit(f"{' '.join(done.words)}: exit code {done.code}: {done.err}")
        done.state  # read while the folder is there
        return done


def difference(a: Finished, b: Finished) -> float:
    """Largest over the steps of |u_a - u_b|_M over the largest |u_b|_M."""
    def size(u: Any) -> Any:
        return np.sqrt((a.mass[None, :, None] * u**2).sum((1, 2)))
    return float(size(a.u - b.u).max() / size(b.u).max())


def row(binary: Path, scene: str, law: str, ratio: float) -> dict[str, Any]:
    """Differences of the free runs, Newton steps in all."""
    words = ["--law", law, "--poisson", str(ratio)]
    law_run = run(binary, scene, "animate", [*words, *TIGHT, "--analytic"])
    net = run(binary, scene, "animate", [*words, *TIGHT, "--energy", "neural"])
    bare = run(binary, scene, "animate", [*words, *TIGHT, "--energy", "neural", "--no-skip"])
    fem = run(binary, scene, "simulate", words)
    return {"scene": scene, "law": law, "poisson": ratio, "to_law": difference(net, law_run),
            "net_to_law": difference(bare, law_run), "to_fem": difference(net, fem),
            "steps_law": int(law_run.state["steps/outer"].sum()),
            "steps_net": int(net.state["steps/outer"].sum())}


def main() -> int:
    """Runs all, or one of each scene."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    options.add_argument("--short", action="store_true", help="the rows of the test")
    chosen = options.parse_args()
    cases = [(scene, law, ratio) for scene in SCENES for law in LAWS for ratio in RATIOS]
    rows = []
    for scene, law, ratio in cases[4::9] if chosen.short else cases:
        r = row(chosen.binary, scene, law, ratio)
        r["passed"] = (r["to_law"] <= TO_LAW and r["to_fem"] <= TO_FEM and
                       r["steps_net"] <= (1 + MORE_STEPS) * r["steps_law"])
        rows.append(r)
        print(f"{'ok  ' if r['passed'] else 'FAIL'} {scene} {law} {ratio}: to the law "
              f"{r['to_law']:.1e} (net itself {r['net_to_law']:.1e}), to finite elements "
              f"{r['to_fem']:.1e}, Newton steps {r['steps_law']} and {r['steps_net']}", flush=True)
    if chosen.json:
        files = ["tests/scenes/neural.py", *scene_files([f"network_{s}" for s in SCENES])]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "rows": rows}, indent=1) + "\n")
    failed = [r for r in rows if not r["passed"]]
    print(f"{len(rows) - len(failed)}/{len(rows)} met")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
