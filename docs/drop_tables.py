# SPDX-License-Identifier: Apache-2.0
"""Tables of what drops cost, from docs/results/drops*.json (bench/drops.py)."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results"
Lines = tuple[list[str], list[list[str]]]
FILES = {"on a CPU": "drops", "on a card": "drops_card"}
# what a row has to keep: its name, its key, the most that is asked for
ASKED = (("V-cycles over a free step, median", "ratio_median", 3), ("the same, 95 %", "ratio_95", 8),
         ("outer iterations, median", "outer_median", 10), ("the same, 95 %", "outer_95", 25))


def read(name: str) -> dict[str, Any]:
    return json.loads((RESULTS / f"{name}.json").read_text())


def present() -> dict[str, dict[str, Any]]:
    return {on: read(name) for on, name in FILES.items() if (RESULTS / f"{name}.json").exists()}


def drops_machine() -> str:
    """Commits, days and machines."""
    return "; ".join(f"{on}: commit " + ", ".join(sorted({row.get('commit', run['header']['commit']) for row in run["rows"]}))
                     + f", {run['header']['date']}, "
                     + " and ".join(sorted({row["device"] if row["device"] != "cpu" else run["header"]["cpu"]
                                            for row in run["rows"]})) for on, run in present().items())


def summary() -> Lines:
    """How many runs keep what is asked for, and the median of all."""
    lines = []
    for on, run in present().items():
        for across in sorted({row["across"] for row in run["rows"]}):
            rows = [row for row in run["rows"] if row["across"] == across]
            lines.append([on, str(across), str(len(rows)), str(sum(row["converged"] == 1 for row in rows)),
                          *(f"{sum(row[key] <= most for row in rows)}, {sorted(row[key] for row in rows)[len(rows) // 2]:.1f}"
                            for _, key, most in ASKED)])
    return ["", "voxels across", "runs", "all steps certified",
            *(f"{name}: at most {most}, middle" for name, _, most in ASKED)], lines


def milliseconds(row: dict[str, Any]) -> str:
    """Runs beside each other have no time."""
    return "" if row["ms_a_frame"] is None else f"{row['ms_a_frame']:.0f}, {row['most_ms_a_frame']:.0f}"


def rows_of(on: str) -> Callable[[], Lines]:
    def lines() -> Lines:
        of = present().get(on, {"rows": []})["rows"]
        return ["asset", "material", "on", "voxels", "certified", "minima", "V-cycles", "over a free step", "outer",
                "V-cycles a frame, most", "ms a frame, most", "near rest", "min J"], [
            [r["asset"], r["material"], r["on"], str(r["voxels"]), f"{100 * r['converged']:.3g} %", str(r["solves"]),
             f"{r['cycles_median']:.1f}", f"{r['ratio_median']:.1f}, {r['ratio_95']:.1f}",
             f"{r['outer_median']:.1f}, {r['outer_95']:.1f}", f"{r['cycles_a_frame']:.0f}, {r['most_cycles_a_frame']}",
             milliseconds(r), f"{r['cycles_near_rest']:.1f}", f"{r['min_j']:.2f}"]
            for r in of]
    return lines


def peers() -> Lines:
    """A drop on a card beside libuipc (bench/peers/libuipc_drop.py)."""
    lines = [[r["run"], str(r["cells"]), f"{r['median']:.0f}", f"{r['p95']:.0f}", f"{r['most']:.0f}",
              "" if r["error"] is None else "reference" if r["error"] == 0 else f"{1e3 * r['error']:.2g} mm"]
             for r in read("drop_peers")["rows"]]
    return ["", "cells", "ms a step in contact, median", "95 %", "most", "centre of mass off"], lines


def peers_machine() -> str:
    head = read("drop_peers")["header"]
    return f"commit {head['commit']}, {head['date']}, {head['card']}"


TABLES = {"drops peers": peers, "drops asked": summary, "drops cpu": rows_of("on a CPU"), "drops card": rows_of("on a card")}
