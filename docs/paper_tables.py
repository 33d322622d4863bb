# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/papers.md and docs/papers_tables.md, from docs/results/paper.json
(tests/scenes/paper.py) and docs/results/bench_paper.json (bench/paper_results.py)."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results"
Row = dict[str, Any]
Lines = tuple[list[str], list[list[str]]]  # head and rows of a table


def read(name: str) -> Row:
    """A result by the name of its file."""
    return json.loads((RESULTS / f"{name}.json").read_text())


def shown(entry: Row, key: str, form: str = ".1e") -> str:
    """A number of a run, or the step that had no finite result."""
    return f"{entry[key]:{form}}" if entry["finite"] else f"refused at {entry['steps'] + 1}"


def errors() -> Lines:
    """Printed recipe and newton against finite elements on their own element."""
    lines = [[r["scene"], r["law"], str(r["poisson"]), shown(r["paper off"], "same"),
              shown(r["paper variance"], "same"), shown(r["paper variance"], "reach", ".3g"),
              *(shown(r[f"newton {kind}"], "same") for kind in ("off", "variance", "full"))]
             for r in read("paper")["rows"]]
    return ["scene", "law", "nu", "paper, off", "paper, variance", "its reach", "newton, off",
            "newton, variance", "newton, full"], lines


def elements() -> Lines:
    """All against quadratic tetrahedra."""
    lines = [[r["scene"], r["law"], str(r["poisson"]), shown(r["paper off"], "tet10"),
              shown(r["paper variance"], "tet10"),
              *(f"{r[f'fem {kind}']['tet10']:.1e}" for kind in ("off", "variance", "full")),
              shown(r["newton full"], "tet10")] for r in read("paper")["rows"]]
    return ["scene", "law", "nu", "paper, off", "paper, variance", "element, off",
            "element, variance", "element, full", "newton, full"], lines


def certificates() -> Lines:
    """Worst residuals, and medians of the time of a step."""
    lines = []
    for r in read("paper")["rows"]:
        runs = [r["paper off"], r["paper variance"], r["newton full"]]
        lines.append([r["scene"], r["law"], str(r["poisson"]),
                      *(shown(run, "residual") for run in runs),
                      *(f"{run['ms']:.2f}" for run in (*runs[1:], r["fem full"])),
                      f"{r['tet10_ms']:.0f}"])
    return ["scene", "law", "nu", "residual: paper, off", "paper, variance", "newton, full",
            "ms: paper, variance", "newton, full", "fem, same element", "fem, tet10"], lines


def swept(latent: bool) -> Lines:
    """The sweep of loops at 18 modes, or that of modes with the variance term."""
    rows = [r for r in read("paper")["sweeps"]
            if (r["outer"] in (5, 50) and r["hourglass"] == "variance" if latent
                else r["modes"] == 18)]
    if latent:
        rows.sort(key=lambda r: (r["scene"], r["outer"], r["modes"]))
    return ["scene", "hourglass", "outer", "modes", "residual", "error", "reach", "ms"], [
        [r["scene"], r["hourglass"], str(r["outer"]), str(r["modes"]), shown(r, "residual"),
         shown(r, "same"), shown(r, "reach", ".3g"), f"{r['ms']:.2f}"] for r in rows]


def references() -> Lines:
    """What halving the voxels changes in the reference."""
    return ["scene", "law", "nu", "steps", "change"], [
        [r["scene"], r["law"], str(r["poisson"]), str(r["steps"]), f"{r['change']:.1e}"]
        for r in read("paper")["references"]]


def steps(name: str) -> Lines:
    """Single steps of bench_paper."""
    lines = []
    for r in read("bench_paper")[name]:
        finite = r["residual"] is not None
        lines.append([r["scene"], str(r["voxels"]), f"{r['courant']:g}", r["hourglass"], r["mode"],
                      r["loops"], "" if r["modes"] is None else str(r["modes"]),
                      f"{r['residual']:.1e}" if finite else "not finite",
                      f"{r['error']:.1e}" if finite else "refused", f"{r['ms']:.1f}"])
    return ["scene", "voxels", "C", "hourglass", "mode", "loops", "modes", "residual", "error",
            "ms"], lines


def growth() -> Lines:
    """Residuals of the printed operator below and above Courant number 1."""
    lines = []
    for r in read("bench_paper")["courant"]:
        residual = r["residual"]
        lines.append([f"{r['courant']:g}", *(
            f"{residual[k - 1]:.1e}" if k <= len(residual)
            else f"not finite at step {len(residual) + 1}" for k in (1, 5, 10, 20))])
    return ["C", "step 1", "5", "10", "20"], lines


def span(values: list[float], form: str) -> str:
    """Least to largest."""
    return f"{min(values):{form}} ... {max(values):{form}}" if values else "none"


def summary() -> Lines:
    """The steps of all scenes, the recipe with an encoder beside the faster of our modes."""
    rows, lines = read("bench_paper")["scenes"], []
    for hourglass in ("variance", "off"):
        for courant in (1, 3, 10):
            of = [r for r in rows if r["hourglass"] == hourglass and r["courant"] == courant]
            paper = [r for r in of if r["mode"] == "paper" and r["modes"] > 0]
            finite = [r for r in paper if r["residual"] is not None]
            ours = [r for r in of if r["mode"] != "paper" and r["residual"] <= 1e-3]
            fastest = {s: min(r["ms"] for r in ours if r["scene"] == s)
                       for s in {r["scene"] for r in of}}
            ratios = [r["ms"] / fastest[r["scene"]] for r in finite]
            middle = f", median {median(ratios):.0f}" if ratios else ""
            lines.append([hourglass, str(courant), f"{len(paper) - len(finite)} of {len(paper)}",
                          span([r["error"] for r in finite], ".1e"),
                          span([r["error"] for r in ours], ".1e"),
                          span(ratios, ".1f") + middle])
    return ["hourglass", "C", "paper refused", "its errors", "ours, certified to 1e-3",
            "its time over ours"], lines


TABLES: dict[str, Callable[[], Lines]] = {
    "paper errors": errors, "paper elements": elements, "paper certificates": certificates,
    "paper loops": lambda: swept(False), "paper modes": lambda: swept(True),
    "paper references": references, "paper courant": growth,
    "paper step loops": lambda: steps("loops"), "paper steps": lambda: steps("scenes"),
    "paper summary": summary}
