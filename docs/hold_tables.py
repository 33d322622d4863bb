# SPDX-License-Identifier: Apache-2.0
"""Tables of what is held where borders cut voxels, from docs/results/holds.json (bench/holds.py)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results" / "holds.json"
Lines = tuple[list[str], list[list[str]]]
FORCE, TORQUE = 0.041313, 8.885e-5  # of the reference, bench/holds.py


def rows(part: str) -> list[dict[str, Any]]:
    return json.loads(RESULTS.read_text())["parts"][part]


def measured_on() -> str:
    """Commit, day and machine."""
    head = json.loads(RESULTS.read_text())["header"]
    return f"commit {head['commit']}, {head['date']}, {head['cpu']}"


def spread(values: list[float]) -> str:
    return f"{100 * (max(values, key=abs) / min(values, key=abs) - 1):.2g} %"


def sagging() -> Lines:
    lines = [[r["solver"], str(r["voxels"]), f"{r['error_mean']:.2f} / {r['error_worst']:.2f} %", f"{r['left_right']:.2f} %",
              f"{r['spread']:.2f} %", f"{r['face']:.0e}", f"{r['weight']:.0e}"] for r in rows("sagging")]
    return ["element", "voxels across", "sag off, mean / worst", "left-right", "spread over offsets",
            "held faces move, of the sag", "reactions over weight, less 1"], lines


def pulled() -> Lines:
    lines = []
    for r in rows("pulled"):
        off = [max((abs(value / truth - 1) for value in r[name])) for name, truth in (("force", FORCE), ("torque", TORQUE))]
        lines.append([r["solver"], str(r["voxels"]), f"{100 * off[0]:.2f} %", f"{100 * off[1]:.2f} %", spread(r["torque"]),
                      spread(r["far_force"]), spread(r["far_torque"]),
                      f"{max(r[f'{name}_face'] for name in ('force', 'torque', 'far_force', 'far_torque')):.0e}"])
    return ["element", "voxels across", "small pull off", "small turn off", "small turn, spread", "pull by 0.3, spread",
            "quarter turn, spread", "moved face off, of the move"], lines


def shaped() -> Lines:
    return ["border", "element", "h [m]", "off, mean over offsets", "worst"], [
        [r["body"], r["solver"], f"{r['h']:.3g}", f"{r['mean']:.1f} %", f"{r['worst']:.1f} %"] for r in rows("shaped")]


def special() -> Lines:
    return ["case", "element", "found"], [
        [r["body"], r["solver"], " ... ".join(f"{value:.3g}" for value in r["values"])] for r in rows("special")]


def steps() -> Lines:
    """The mirror image, and V-cycles."""
    lines = [[f"bar and its mirror image after 60 frames of `auto`, tolerance {r['tolerance']}",
              f"{r['off']:.1e} of the motion"] for r in rows("mirrored")]
    lines += [[f"V-cycles of 24 steps, `{r['solver']}`: borders that cut voxels over a grid that fits",
               f"{', '.join(map(str, r['cut']))} over {r['fit']}: at most {max(r['cut']) / r['fit']:.2f}"] for r in rows("iterations")]
    return ["", "found"], lines


def times() -> Lines:
    """Steps of a bar where borders fit and where one cuts voxels (bench/hold_times.py)."""
    of = json.loads((RESULTS.parent / "hold_times.json").read_text())
    lines = [[str(r["voxels"]), r["solver"], f"{r['fit'][0]:.3g}, {r['cut'][0]:.3g}", f"{r['fit'][1]:.2g}, {r['cut'][1]:.2g}",
              f"{r['fit'][2]:.0f}, {r['cut'][2]:.0f}"] for r in of["rows"]]
    return ["voxels along the bar", "solver", "ms a step: fits, cuts", "ms an iteration", "iterations of 24 steps"], lines


def times_measured_on() -> str:
    of = json.loads((RESULTS.parent / "hold_times.json").read_text())
    return f"commit {of['header']['commit']}, {of['header']['date']}, {of['rows'][0]['machine']}"


TABLES = {"held sag": sagging, "held moves": pulled, "held shapes": shaped, "held cases": special, "held steps": steps,
          "held times": times}
