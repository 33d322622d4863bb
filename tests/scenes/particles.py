#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Integrators of particles side by side: `elastogen study` on the columns of sand and the snowballs of
examples/scenes (docs/study.md).

    tests/scenes/particles.py --binary build/cpu/elastogen --json FILE [--only TEXT ...] [--jobs N]
                              [--threads N] [--limit SECONDS]

Each study is a row of FILE; rows that are made anew take the place of old ones, so that studies can be
run one after the other. One thread a run, for times that can be compared; --jobs studies at once,
which each row states. A study that is longer than --limit is told to end: its row has the runs that
had come to their end, and says so."""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from definitions import definitions_hash, run_header

ROOT = Path(__file__).resolve().parents[2]
SCENES = "examples/scenes"
BLEND = ("--transfer", "apic-blend")
NO_FLOOR = "--no-noise-floor"
NO_EXPLICIT = ("--explicit-dt", "none", NO_FLOOR)


def column(aspect: float, h: float) -> tuple[str, tuple[str, ...]]:
    """A column of collapse.py: half width 0.1 m, volume kept, for a second."""
    return "sand_column_2d", ("--shape", f"rectangle(-0.1,0,0, 0.1,{0.1 * aspect:g},0)", "--h", f"{h:g}",
                              "--keeps-volume", "true", "--frames", "50", *NO_EXPLICIT)


STUDIES: dict[str, tuple[str, tuple[str, ...]]] = {
    "sand": ("sand_column_2d", ("--explicit-dt", "1e-5,1e-4")),
    "sand, blended": ("sand_column_2d", (*BLEND, "--explicit-dt", "1e-5")),
    "sand, volume kept": ("sand_column_2d", ("--keeps-volume", "true", *NO_EXPLICIT)),
    "sand, 0.2 ms": ("sand_column_2d", ("--dt", "2e-4", *NO_EXPLICIT)),
    "sand, 0.5 ms": ("sand_column_2d", ("--dt", "5e-4", *NO_EXPLICIT)),
    "sand, 2 ms": ("sand_column_2d", ("--dt", "2e-3", *NO_EXPLICIT)),
    "sand, 10 MPa": ("sand_column_2d", ("--young", "1e7", "--explicit-dt", "1e-5", NO_FLOOR)),
    "sand, 100 MPa": ("sand_column_2d", ("--young", "1e8", "--frames", "30", "--explicit-dt", "1e-5",
                                         NO_FLOOR)),
    "snow": ("snowball_2d", ("--explicit-dt", "1e-5", "--particle-substeps", "200")),
    "snow, 0.5 ms": ("snowball_2d", ("--dt", "5e-4", "--explicit-dt", "1e-5",
                                     "--particle-substeps", "100", NO_FLOOR)),
    "snow, 0.2 ms": ("snowball_2d", ("--dt", "2e-4", "--explicit-dt", "1e-5",
                                     "--particle-substeps", "40", NO_FLOOR)),
    "sand in space": ("sand_column_3d", ("--explicit-dt", "7e-5", NO_FLOOR)),
    "snow in space": ("snowball_3d", ("--explicit-dt", "4e-5", NO_FLOOR)),
    "column a 0.5": column(0.5, 0.01),
    "column a 1": column(1, 0.01),
    "column a 2": column(2, 0.01),
    "column a 0.5, 5 mm": column(0.5, 0.005),
    "column a 1, 5 mm": column(1, 0.005),
    "column a 2, 5 mm": column(2, 0.005),
}


def farthest_apart(fronts: list[float], reference: list[float]) -> float:
    """Of half widths frame by frame, over that of the reference in its last frame."""
    return max((abs(a - b) / reference[-1] for a, b in zip(fronts, reference)), default=0)


def study(name: str, chosen: argparse.Namespace) -> dict[str, Any]:
    """A row: the study without what it says of every frame but the last."""
    scene, options = STUDIES[name]
    with tempfile.TemporaryDirectory() as folder:
        words = ["study", "--scene", f"{SCENES}/{scene}.toml", *options, "--threads", str(chosen.threads)]
        with subprocess.Popen([chosen.binary.resolve(), *words, "--quiet", "--folder", folder],
                              cwd=ROOT) as process:
            try:
                code = process.wait(chosen.limit)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGTERM)
                process.wait()
                code, ended = 0, {"ended_after": chosen.limit}
            else:
                ended = {}
        if code:
            raise subprocess.CalledProcessError(code, words)
        row = json.loads((Path(folder) / "particles.json").read_text())
    fronts = {run["name"]: [frame["half_width"] for frame in run["frames"]] for run in row["runs"]}
    for run in row["runs"]:
        run["front_apart"] = farthest_apart(fronts[run["name"]], fronts.get(row["sub_reference"], []))
        run["last"] = run.pop("frames")[-1]
    return {"name": name, "file": scene, "options": list(options), "at_once": chosen.jobs} | ended | row | {
        "command": " ".join(["elastogen", *words])}


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, required=True)
    options.add_argument("--only", nargs="*", default=list(STUDIES), help="names of studies")
    options.add_argument("--jobs", type=int, default=1, help="studies at once")
    options.add_argument("--threads", type=int, default=1, help="of a study")
    options.add_argument("--limit", type=float, help="seconds a study")
    chosen = options.parse_args()
    old = json.loads(chosen.json.read_text())["studies"] if chosen.json.exists() else []
    rows = {row["name"]: row for row in old}
    files = ["tests/scenes/particles.py",
             *sorted({f"{SCENES}/{scene}.toml" for scene, _ in STUDIES.values()})]
    stamp = {"files": files, "sha256": definitions_hash(files)}
    with ThreadPoolExecutor(chosen.jobs) as pool:
        for made in as_completed([pool.submit(study, name, chosen) for name in chosen.only]):
            row = made.result()
            rows[row["name"]] = row
            chosen.json.write_text(json.dumps(
                {"definitions": stamp, "header": run_header(),
                 "studies": [rows[n] for n in STUDIES if n in rows]}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
