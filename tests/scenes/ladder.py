#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The ladder: closed forms and tables of the literature, from scene files through the command.

    tests/scenes/ladder.py --binary build/cpu/elastogen [--json FILE] [--short] [--only TEXT ...]

Rows: ladder_statics.py, ladder_dynamics.py, ladder_classics.py; scene files:
tests/scenes/verification. A line a row: what it reads from the state files, how far that is from
the reference, and what is allowed. Ends with n/m and the rows that failed; exit status 1 if there is one."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from classic_meshes import written
from definitions import definitions_hash, scene_files
from ladder_classics import CLASSICS
from ladder_dynamics import DYNAMICS
from ladder_row import Row, scene_path
from ladder_statics import STATICS
from runs import Finished, run_scene

ROWS = [*STATICS, *DYNAMICS, *CLASSICS]
MODULES = ("classic_meshes", "ladder", "ladder_classics", "ladder_dynamics", "ladder_row",
           "ladder_statics", "runs")
PAST = 5400  # [s] after which a run is killed


class Runs:
    """Runs of the command, each made once however many rows read it."""

    def __init__(self, binary: Path, folder: Path) -> None:
        self.binary, self.folder = binary, folder
        self.made: dict[tuple[str, ...], Finished] = {}

    def get(self, row: Row, options: tuple[str, ...]) -> Finished:
        """One run of a row."""
        verb, *flags = row.verb.split()
        words = (row.verb, row.scene, *row.options, *options)
        if words not in self.made:
            folder = self.folder / str(len(self.made))
            folder.mkdir()
            given = self.with_meshes([*flags, *row.options, *options], folder)
            self.made[words] = run_scene(self.binary, verb, scene_path(row.scene), given, folder,
                                         PAST)
        return self.made[words]

    @staticmethod
    def with_meshes(options: list[str], folder: Path) -> list[str]:
        """The same with "mesh:NAME" written to the folder, and the words that belong to it."""
        given: list[str] = []
        for word in options:
            name = word.removeprefix("mesh:")
            given += [word] if name == word else written(name, folder / "body.msh")
        return given


def judge(row: Row, runs: list[Finished]) -> dict[str, Any]:
    """A row's entry in the results."""
    broken = [run for run in runs if run.code]
    measured = [] if broken else [float(value) for value in row.measure(runs)]
    errors = row.errors(measured)
    entry: dict[str, Any] = {
        "key": row.key, "name": row.name, "scene": row.scene, "command": row.verb,
        "options": list(row.options), "sweep": [list(options) for options in row.sweep],
        "quantity": row.quantity, "source": row.source, "reference": list(row.reference),
        "tolerance": row.tolerance, "relative": row.relative, "bound": row.bound,
        "measured": measured, "worst": max(errors) if measured else None,
        "passed": bool(measured) and max(errors) <= row.tolerance}
    if broken:
        entry["broken"] = f"exit code {broken[0].code}: {' '.join(broken[0].err.split())[:200]}"
    return entry


def line(entry: dict[str, Any], seconds: float) -> str:
    """What is printed of a row."""
    word = "ok  " if entry["passed"] else "FAIL"
    values = " ".join(f"{value:.5g}" for value in entry["measured"]) or entry.get("broken", "")
    worst = "-" if entry["worst"] is None else f"{entry['worst']:.2g}"
    return (f"{word} {entry['key']:<4} {entry['name']}: {values}; off by {worst}, allowed "
            f"{entry['tolerance']:g}{' of it' if entry['relative'] else ''} ({seconds:.1f} s)")


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    options.add_argument("--short", action="store_true", help="the rows of the test")
    options.add_argument("--only", nargs="*", default=[""], help="rows that have a text")
    chosen = options.parse_args()
    rows = [row for row in ROWS if (row.short or not chosen.short)
            and any(text in f"{row.key} {row.name}" for text in chosen.only)]
    entries = []
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(chosen.binary, Path(folder))
        for row in rows:
            made = [runs.get(row, sweep) for sweep in row.sweep]
            entries.append(judge(row, made))
            print(line(entries[-1], sum(run.seconds for run in made)), flush=True)
    if chosen.json:
        files = ["tests/python/tet_mesh.py", *(f"tests/scenes/{name}.py" for name in MODULES)]
        files += scene_files(sorted({row.scene for row in ROWS}))
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "rows": entries}, indent=1) + "\n")
    failed = [f"{entry['key']} {entry['name']}" for entry in entries if not entry["passed"]]
    print(f"{len(entries) - len(failed)}/{len(entries)} rows met", *failed, sep="\n  ")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
