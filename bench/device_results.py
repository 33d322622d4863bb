#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps what bench_device printed on a machine with a card: docs/results/device.json.

    bench/device_results.py OUTPUT

Run it on the commit that was measured; docs/generate.py puts the tables into docs/benchmarks.md."""

from __future__ import annotations

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "scenes"), str(ROOT / "bench")]
from definitions import definitions_hash, run_header  # noqa: E402
from results import cells  # noqa: E402

FILES = ["bench/device.cpp", "bench/scenes.cpp"]


def main() -> int:
    """Writes the tables by the first word of their heads, beside the first line, which names the card."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    lines = [line for line in Path(sys.argv[1]).read_text().splitlines() if line.strip()]
    tables: dict[str, dict[str, list[str] | list[list[str]]]] = {}
    rows: list[list[str]] = []
    for line, following in zip(lines, [*lines[1:], ""]):
        if following.startswith("|---"):
            rows = []
            tables[cells(line)[0]] = {"head": cells(line), "rows": rows}
        elif line.startswith("|") and not line.startswith("|---"):
            rows.append(cells(line))
    stamp = {"files": FILES, "sha256": definitions_hash(FILES)}
    header = {key: value for key, value in run_header().items() if key != "cpu"}
    (ROOT / "docs" / "results" / "device.json").write_text(json.dumps(
        {"definitions": stamp, "header": header, "card": lines[0], "tables": tables}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
