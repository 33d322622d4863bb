#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmarks of docs/benchmarks.md and keeps their tables: docs/results/benchmarks.json.

    bench/results.py --build build/cpu

Wants a machine with nothing else to do. Minutes; docs/generate.py puts the tables into the page."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "scenes"))
from definitions import definitions_hash, run_header  # noqa: E402

FILES = ["bench/error_time.cpp", "bench/kernels.cpp", "bench/measure.cpp", "bench/scenes.cpp",
         "bench/startup.py", "bench/results.py"]
RUNS = {  # rows of several runs stand below each other
    "error time": ["{build}/bench_error_time beam 1e4 3", "{build}/bench_error_time ball 1e5 1"],
    "kernels": ["{build}/bench_kernels 1e5"],
    "start": ["python3 {source}/bench/startup.py {build}/elastogen"]}


def cells(line: str) -> list[str]:
    """The cells of a row of a Markdown table."""
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def main() -> int:
    """Runs them."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--build", type=Path, required=True)
    build = options.parse_args().build.resolve()
    tables: dict[str, dict[str, object]] = {}
    for name, commands in RUNS.items():
        rows: list[list[str]] = []
        head: list[str] = []
        notes: list[str] = []
        for command in commands:
            words = command.format(build=build, source=ROOT).split()
            out = subprocess.run(words, check=True, capture_output=True, text=True).stdout
            lines = [line for line in out.splitlines() if line.strip()]
            found = [cells(line) for line in lines if line.startswith("|")]
            notes += [line for line in lines if not line.startswith("|")]
            head = found[0]
            rows += found[2:]  # without the line below the head
            print(command, len(found) - 2, "rows", flush=True)
        tables[name] = {"commands": [c.format(build="build/cpu", source=".") for c in commands],
                        "notes": notes, "head": head, "rows": rows}
    stamp = {"files": FILES, "sha256": definitions_hash(FILES)}
    (ROOT / "docs" / "results" / "benchmarks.json").write_text(json.dumps(
        {"definitions": stamp, "header": run_header(), "tables": tables}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
