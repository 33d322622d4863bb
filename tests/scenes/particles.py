#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Integrators of particles side by side: `elastogen study` on the columns of sand and the snowballs of
examples/scenes (docs/study.md).

    tests/scenes/particles.py --binary build/cpu/elastogen --json FILE [--only TEXT ...]

Each study is a row of FILE; rows that are made anew take the place of old ones, so that studies can be
run one after the other. One thread a run, for times that can be compared."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from definitions import definitions_hash, run_header

ROOT = Path(__file__).resolve().parents[2]
SCENES = "examples/scenes"
BLEND = ("--transfer", "apic-blend")
NO_EXPLICIT = ("--explicit-dt", "none", "--no-noise-floor")
STUDIES: dict[str, tuple[str, tuple[str, ...]]] = {
    "sand": ("sand_column_2d", ("--explicit-dt", "1e-5,1e-4")),
    "sand, blended": ("sand_column_2d", (*BLEND, "--explicit-dt", "1e-5")),
    "sand, volume kept": ("sand_column_2d", ("--keeps-volume", "true", *NO_EXPLICIT)),
    "sand, 0.2 ms": ("sand_column_2d", ("--dt", "2e-4", *NO_EXPLICIT)),
    "sand, 0.5 ms": ("sand_column_2d", ("--dt", "5e-4", *NO_EXPLICIT)),
    "sand, 2 ms": ("sand_column_2d", ("--dt", "2e-3", *NO_EXPLICIT)),
    "sand, 10 MPa": ("sand_column_2d", ("--young", "1e7", "--explicit-dt", "1e-5",
                                        "--no-noise-floor")),
    "sand, 100 MPa": ("sand_column_2d", ("--young", "1e8", "--explicit-dt", "1e-5",
                                         "--no-noise-floor")),
    "snow": ("snowball_2d", ("--explicit-dt", "1e-5", "--particle-substeps", "200")),
    "snow, 0.5 ms": ("snowball_2d", ("--dt", "5e-4", "--explicit-dt", "1e-5",
                                     "--particle-substeps", "100", "--no-noise-floor")),
    "snow, 0.2 ms": ("snowball_2d", ("--dt", "2e-4", "--explicit-dt", "1e-5",
                                     "--particle-substeps", "40", "--no-noise-floor")),
    "sand in space": ("sand_column_3d", ("--frames", "8", "--explicit-dt", "7e-5",
                                         "--no-noise-floor")),
    "snow in space": ("snowball_3d", ("--frames", "6", "--explicit-dt", "4e-5",
                                      "--no-noise-floor")),
}


def study(binary: Path, name: str) -> dict[str, Any]:
    """A row: the study without what it says of every frame but the last."""
    scene, options = STUDIES[name]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([binary, "study", "--scene", ROOT / SCENES / f"{scene}.toml", *options,
                        "--threads", "1", "--folder", folder], check=True)
        row = json.loads((Path(folder) / "particles.json").read_text())
    for run in row["runs"]:
        run["last"] = run.pop("frames")[-1]
    return {"name": name, "file": scene, "options": list(options)} | row


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, required=True)
    options.add_argument("--only", nargs="*", default=list(STUDIES), help="names of studies")
    chosen = options.parse_args()
    old = json.loads(chosen.json.read_text())["studies"] if chosen.json.exists() else []
    rows = {row["name"]: row for row in old}
    for name in chosen.only:
        rows[name] = study(chosen.binary, name)
        files = ["tests/scenes/particles.py",
                 *sorted({f"{SCENES}/{scene}.toml" for scene, _ in STUDIES.values()})]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps(
            {"definitions": stamp, "header": run_header(),
             "studies": [rows[n] for n in STUDIES if n in rows]}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
