#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The stress catalogue as scene files: every case through `animate` and `simulate`.

    tests/scenes/stress.py --binary build/cpu/elastogen [--json FILE] [--short] [--only TEXT ...]

Cases: stress_cases.py; scene files: tests/scenes/stress; criteria U1 ... U8: stress_checks.py. A
line a run, then n/m and each failure by name; exit status 1 if one failed that is not in KNOWN.
Starts that no scene file can give (random, flattened, inverted) are in the program tests/stress."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from definitions import ROOT, definitions_hash
from runs import HERE, Finished, run_scene
from shapes_small import Mesh, write
from stress_cases import CASES, Case
from stress_checks import all_faults

MODULES = ("stress", "stress_cases", "stress_checks", "shapes_small", "runs")
PAST = 600  # [s] after which a run is killed
# failures that are known, by case and verb, and why
TORSION = ("in folded voxels the rotations that the torsion correction takes at the start of a "
           "step bring energy")
ROWS = "rows of eight voxels are mostly empty in sheets and needles: more memory a voxel"
IMPACT = "the steps in which a cube of 20 cm hits the floor at 1000 m/s and more take thousands"
FITTED = "no net is shipped for nu = 0.499: it is fitted, which takes 65 MiB once"
NARROW = "nu is beyond the promised range, 0.499; the first step from rest takes thousands"
KNOWN = {f"gravity.1e4 {verb}": TORSION for verb in ("animate", "simulate")} | {
    f"impact.{speed} animate": IMPACT for speed in ("1e3", "1e4")} | {
    "poisson.0.499 animate": FITTED, "poisson.0.4999 animate": NARROW,
    "sheet.300 animate": ROWS, "needle.10000 animate": ROWS}


class Runs:
    """Runs of one verb in a folder; those of the same words are made once."""

    def __init__(self, binary: Path, verb: str, folder: Path) -> None:
        self.binary, self.verb, self.folder = binary, verb, folder
        self.made: dict[tuple[str, ...], Finished] = {}

    def get(self, scene: str, options: tuple[str, ...] = (), threads: int = 2,
            mesh: Mesh | None = None) -> Finished:
        """A run of a scene, of a mesh in place of the scene's if one is given."""
        named = [str(HERE / "stress" / word) if word.endswith(".obj") else word for word in options]
        if "--time-scheme" not in named:  # whose energy never rises, and whose motion has closed forms
            named += ["--time-scheme", "euler"]
        if "--threads" not in named:
            named += ["--threads", str(threads)]
        words = (scene, *named, "" if mesh is None else f"{len(mesh[0])} {mesh[0].sum()}")
        if words not in self.made:
            folder = self.folder / str(len(self.made))
            folder.mkdir(parents=True)
            if mesh is not None:
                named.insert(0, str(write(folder / "shape.obj", mesh)))
            self.made[words] = run_scene(self.binary, self.verb, HERE / "stress" / f"{scene}.toml",
                                         named, folder, PAST)
        return self.made[words]


def judge(case: Case, verb: str, runs: Runs) -> dict[str, Any]:
    """A case's entry in the results."""
    flags = tuple(case.options)
    run = runs.get(case.scene, flags, mesh=case.mesh)
    again = runs.get(case.scene, flags, threads=1, mesh=case.mesh)
    faults = all_faults(run, again, set(case.codes), case.passive)
    if run.code in case.codes:
        try:
            faults += case.extra(run, runs.get)
        except (OSError, KeyError, ValueError) as error:  # what another run did not write
            faults.append(f"a run to compare with gave nothing: {error}")
    entry: dict[str, Any] = {"name": f"{case.name} {verb}", "scene": case.scene, "code": run.code,
                             "faults": faults, "seconds": run.seconds}
    if run.code in (0, 4, 5) and (run.folder / "state.h5").exists():
        converged, inner = run.state["steps/converged"], run.state["steps/inner"]
        entry |= {"voxels": len(run.state["grid/corners"]), "steps": len(converged),
                  "drafts": int((converged == 0).sum()), "mebibytes": run.peak >> 20,
                  "evaluations": [int(sorted(inner)[len(inner) // 2]), int(max(inner))]
                  if len(inner) else [0, 0]}
    return entry


def line(entry: dict[str, Any]) -> str:
    """What is printed of a run."""
    word = "ok  " if not entry["faults"] else "known" if entry["name"] in KNOWN else "FAIL"
    text = f"{word} {entry['name']:<30} exit {entry['code']}"
    if "steps" in entry:
        median, worst = entry["evaluations"]
        text += (f", {entry['voxels']} voxels, {entry['steps']} steps, {entry['drafts']} drafts, "
                 f"evaluations {median} (worst {worst}), {entry['mebibytes']} MiB")
    return "\n     ".join([f"{text}, {entry['seconds']:.1f} s", *entry["faults"]])


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    options.add_argument("--short", action="store_true", help="the cases of the test")
    options.add_argument("--only", nargs="*", default=[""], help="cases whose name begins so")
    chosen = options.parse_args()
    entries = []
    for case in CASES:
        if (chosen.short and not case.short) or not case.name.startswith(tuple(chosen.only)):
            continue
        for verb in case.verbs:
            with tempfile.TemporaryDirectory() as folder:
                entries.append(judge(case, verb, Runs(chosen.binary, verb, Path(folder))))
            print(line(entries[-1]), flush=True)
    if chosen.json:
        files = [f"tests/scenes/{name}.py" for name in MODULES]
        files += [str(path.relative_to(ROOT)) for path in sorted((HERE / "stress").iterdir())]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        rows = [{key: entry[key] for key in entry if key != "seconds"} for entry in entries]
        chosen.json.write_text(json.dumps({"definitions": stamp, "known": KNOWN, "rows": rows},
                                          indent=1) + "\n")
    failed = {entry["name"]: entry["faults"] for entry in entries if entry["faults"]}
    print(f"{len(entries) - len(failed)}/{len(entries)} passed")
    for name, faults in failed.items():
        print(f"  {name}: {faults[0]}" + (f" (known: {KNOWN[name]})" if name in KNOWN else ""))
    return int(any(name not in KNOWN for name in failed))


if __name__ == "__main__":
    sys.exit(main())
