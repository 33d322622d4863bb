#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs `bench_paper json` and stamps what it says: docs/results/bench_paper.json.

    bench/paper_results.py --binary build/cpu/bench_paper [--repeats N]"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "scenes"))
from definitions import definitions_hash, run_header  # noqa: E402

FILES = ["bench/measure.cpp", "bench/paper.cpp", "bench/scenes.cpp"]


def main() -> int:
    """Runs it."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--repeats", type=int, default=3, help="of each step, for its time")
    chosen = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.json"
        subprocess.run([str(chosen.binary), "json", str(path), str(chosen.repeats)], check=True)
        rows = json.loads(path.read_text())
    header = run_header() | {"repeats": chosen.repeats}
    stamp = {"files": FILES, "sha256": definitions_hash(FILES)}
    target = ROOT / "docs" / "results" / "bench_paper.json"
    target.write_text(json.dumps({"definitions": stamp, "header": header} | rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
