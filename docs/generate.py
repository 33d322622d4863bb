#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of docs/*.md that come from docs/results/*.json and from the model cards of
network/weights, in place.

    docs/generate.py            writes them
    docs/generate.py --check    exit status 1, naming the place, if a table is not what the results
                                say, the results are older than the scenes that they are of, or a
                                line of prose is too long

A table stands between `<!-- table NAME -->` and `<!-- end -->`."""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "scenes"))
from definitions import definitions_hash  # noqa: E402
from drop_tables import TABLES as DROP_TABLES  # noqa: E402
from drop_tables import drops_machine, peers_machine  # noqa: E402
from equation_names import missing_names  # noqa: E402
from fit_tables import fine_tuning, fits, generation  # noqa: E402
from hold_tables import TABLES as HOLD_TABLES  # noqa: E402
from hold_tables import measured_on, times_measured_on  # noqa: E402
from metal_tables import TABLES as METAL_TABLES  # noqa: E402
from motion_tables import MACHINES  # noqa: E402
from motion_tables import TABLES as MOTION_TABLES  # noqa: E402
from paper_tables import TABLES as PAPER_TABLES  # noqa: E402
from particle_tables import TABLES as PARTICLE_TABLES  # noqa: E402
from prose import long_lines  # noqa: E402

RESULTS = ROOT / "docs" / "results"
BENCH_PARTS = ("ceilings", "kernels", "step", "error-time", "tip", "baseline", "particles", "startup")
STUDIES = ("beam", "twist", "torus", "knot", "porous", "asset")


def read(name: str) -> dict[str, Any]:
    """A result by the name of its file."""
    return json.loads((RESULTS / f"{name}.json").read_text())


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def accuracy() -> str:
    """Network against finite elements: worst of three Poisson ratios."""
    rows = read("accuracy")["rows"]
    lines = []
    for scene in dict.fromkeys(r["scene"] for r in rows):
        for law in dict.fromkeys(r["law"] for r in rows):
            for r in (r for r in rows if r["scene"] == scene and r["law"] == law):
                lines.append([scene, str(r["voxels"]), law, str(r["poisson"]),
                              *(f"{r[s][m]:.1e}" for s in ("quasi", "newton")
                                for m in ("step", "free"))])
    return table(["scene", "voxels", "law", "nu", "quasi, a step", "quasi, free run",
                  "newton, a step", "newton, free run"], lines)


def reference_change(runs: list[dict[str, Any]]) -> float:
    """How far the reference of grid errors has come from its own element on the scene's grid."""
    reference = next(r["discretisation_error"]["reference"] for r in runs
                     if r["discretisation_error"])
    own = next(r for r in runs if r["name"] == reference.partition(" h/")[0])
    return own["discretisation_error"]["free_run"]["max"]


def study(name: str) -> str:
    """The runs of a study: time beside both errors; grid errors that the reference cannot tell from
    its own stand in brackets."""
    lines = []
    runs = read(f"study_{name}")["runs"]
    change = reference_change(runs)
    for r in runs:
        solver, grid = r["solver_error"], r["discretisation_error"]
        error = grid["free_run"]["max"] if grid else 0
        lines.append([r["name"], f"{1e3 * r['h']:.3g}", f"{1e3 * r['dt']:.3g}", str(r["dofs"]),
                      f"{r['step_ms']['median']:.1f}", f"{r['worst_residual']:.1e}",
                      f"{solver['step']['max']:.1e}" if solver else "",
                      f"{solver['free_run']['max']:.1e}" if solver else "",
                      (f"{error:.1e}" if error > change else f"({error:.1e})") if grid else ""])
    return table(["run", "h [mm]", "dt [ms]", "unknowns", "ms a step", "worst residual",
                  "solver error, a step", "solver error, free run",
                  f"grid error, free run (its reference moved by {change:.1e})"], lines)


def peers() -> str:
    """Our finite elements beside an independent code on the same meshes."""
    return table(["scene", "element", "cells", "largest difference", "mesh error of the energy",
                  "ours [s]", "scikit-fem [s]"],
                 [[r["scene"], r["element"], "x".join(map(str, r["cells"])),
                   f"{max(r['difference'].values()):.1e}", f"{r['mesh']:.1e}",
                   f"{r['seconds']:.2f}", f"{r['their_seconds']:.2f}"]
                  for r in read("peers")["rows"]])


def reached(name: str) -> list[list[str]]:
    """What each solver pays for an error of a step against the same element."""
    lines = []
    for entry in read(f"study_{name}")["time_to_error"]:
        if entry["family"] == "solver_error" and entry["measure"] == "step":
            lines.append([name, entry["solver"], entry["reference"],
                          *(f"{level['ms']:.1f}" if level["ms"] is not None else "not reached"
                            for level in entry["levels"])])
    return lines


def time_to_error() -> str:
    """The same of all scenes."""
    return table(["scene", "solver", "against", "1e-1", "1e-2", "1e-3", "1e-4"],
                 [line for name in STUDIES for line in reached(name)])


def sweeps() -> str:
    """Observed orders."""
    return table(["scene", "line", "against", "values", "errors", "order"],
                 [[name, s["name"], s["variable"], ", ".join(f"{x:.3g}" for x in s["x"]),
                   ", ".join(f"{e:.1e}" for e in s["error"]), f"{float(s['order']):.2f}"]
                  for name in STUDIES for s in read(f"study_{name}")["sweeps"]])


def discretisation() -> str:
    """The network's element against quadratic tetrahedra."""
    return table(["scene", "voxels along it", "errors", "orders", "from first to last",
                  "tet10 between its grids"],
                 [[r["scene"], ", ".join(map(str, r["voxels"])),
                   ", ".join(f"{e:.1e}" for e in r["errors"]),
                   ", ".join(f"{o:.2f}" for o in r["orders"]), f"{r['order']:.2f}",
                   f"{r['reference_change']:.1e} ({r['reference'][0]}, {r['reference'][1]})"]
                  for r in read("discretisation")["rows"]])


def assets() -> str:
    """What became of each file of a folder of real assets."""
    result = read("assets")
    lines = [[re.sub(r"read are \..*", "read are (the list of formats)", cell) for cell in row]
             for row in result["rows"]]
    return table(result["head"], lines)


def particle_assets() -> str:
    """Real meshes that fall as particles."""
    lines = []
    for r in read("particle_assets")["rows"]:
        if "steps" not in r:
            lines.append([r["asset"], r["material"], "", "", "", "", "", "", "", str(r["code"]), r["fault"]])
            continue
        lines.append([r["asset"], r["material"], str(r["particles"]), f"{r['certified']}/{r['steps']}",
                      f"{r['residual']:.1e}", "yes" if r["finite"] else "**no**", f"{r['mass'] - 1:+.0e}",
                      f"{r['least_j']:.3f}", f"{r['seconds']:.0f}", str(r["code"]), r["fault"]])
    return table(["mesh", "material", "particles", "steps certified", "worst residual", "finite",
                  "mass over fill, less 1", "least J at the end", "seconds", "exit code", "fault"], lines)


def dent() -> str:
    """Depths of dents, and how far apart they are."""
    rows = read("dent")["rows"]
    lines = [[r["body"], f"1/{r['steps_a_second']}", f"{r['deepest']:.3f}", f"{r['stays']:.3f}",
              f"{r['certified']}/{r['steps']}"] for r in rows]
    for body in dict.fromkeys(r["body"] for r in rows):
        depths = [[r[d] for r in rows if r["body"] == body] for d in ("deepest", "stays")]
        lines.append([body, "spread", *(f"{100 * (max(d) / min(d) - 1):.1f} %" for d in depths), ""])
    return table(["body", "steps [s]", "deepest [mm]", "stays [mm]", "certified"], lines)


def values(numbers: list[float]) -> str:
    """Numbers in one cell."""
    return " / ".join(f"{number:.4g}" for number in numbers)


def ladder() -> str:
    """Every row of the ladder: reference, tolerance, what came out."""
    lines = []
    for r in read("ladder")["rows"]:
        allowed = f"{100 * r['tolerance']:g} %" if r["relative"] else f"{r['tolerance']:g}"
        lines.append([r["key"], f"{r['name']}: {r['quantity']}".replace("|", "\\|"),
                      f"`{r['command']}` {r['scene']}",
                      ("at most " if r["bound"] else "") + values(r["reference"]), allowed,
                      values(r["measured"]) or r["broken"],
                      f"{r['worst']:.1e}" if r["passed"] else "**too far**"])
    met = sum(r["passed"] for r in read("ladder")["rows"])
    return table(["", "row", "run", "reference", "allowed", "measured", "off by"], lines) + (
        f"\n\n**{met}/{len(lines)}** rows met.")


def scene_stress() -> str:
    """The stress scenes by their first word."""
    result, lines = read("scene_stress"), []
    rows = [r | {"verb": r["name"].split()[1], "group": re.split(r"[.-]", r["name"])[0]}
            for r in result["rows"]]
    for group in dict.fromkeys(r["group"] for r in rows):
        mine = [r for r in rows if r["group"] == group]
        ran = [r for r in mine if "steps" in r]
        passed = ["/".join(str(sum(1 for r in mine if r["verb"] == verb and good(r)))
                           for good in (lambda r: not r["faults"], lambda r: True))
                  for verb in ("animate", "simulate")]
        lines.append([group, *("" if cell == "0/0" else cell for cell in passed),
                      ", ".join(map(str, sorted({r["code"] for r in mine}))),
                      *([f"{sum(r['steps'] for r in ran)}", f"{sum(r['drafts'] for r in ran)}",
                         f"{max(r['evaluations'][1] for r in ran)}",
                         f"{max(r['mebibytes'] for r in ran)}"] if ran else [""] * 4)])
    good = sum(not r["faults"] for r in rows)
    failed = "; ".join(f"{r['name']}: {r['faults'][0]}" for r in rows if r["faults"])
    return (table(["rows", "`animate`", "`simulate`", "exit codes", "steps", "drafts",
                   "most evaluations in a step", "most MiB"], lines)
            + f"\n\n**{good}/{len(rows)}** passed. Not passed: {failed or 'none'}.")


def curved() -> str:
    """The network's element on bodies that the grid cuts."""
    lines = []
    for r in read("curved")["rows"]:
        lines.append([r["scene"], r["load"],
                      *(", ".join(f"{100 * grid[where]:.2g}" for grid in r["grids"])
                        for where in ("inside", "surface")),
                      ", ".join(f"{o:.2f}" for o in r["orders"]), f"{r['order']:.2f}",
                      f"{100 * r['reference_inside']['error']:.1g}"])
    return table(["scene", "load", "error at nodes inside [%]", "on the surface [%]", "orders",
                  "from first to last", "reference's own error [%]"], lines)


def real_shape() -> str:
    """The network on a real mesh against tetrahedra of the same surface."""
    r = read("real_shape")["rows"][0]
    orders = ["", *(f"{order:.2f}" for order in r["orders"])]
    return table(["voxels along it", "error of the deformation [%]", "of the motion [%]", "order"],
                 [[str(g["voxels"]), f"{100 * g['deformation']:.2g}", f"{100 * g['motion']:.2g}", o]
                  for g, o in zip(r["grids"], orders)]) + (
        f"\n\n{' and '.join(map(str, r['cells']))} tetrahedra of {r['asset']}; the second differ from "
        f"the first by {100 * r['reference_change']:.1g} % of the deformation.")


def neural() -> str:
    """Nets in the place of laws, beside the law and beside finite elements."""
    return table(["scene", "law", "nu", "table to law", "net to law", "table to finite elements",
                  "Newton steps, law", "table"],
                 [[r["scene"], r["law"], str(r["poisson"]), f"{r['to_law']:.1e}",
                   f"{r['net_to_law']:.1e}", f"{r['to_fem']:.1e}", str(r["steps_law"]),
                   str(r["steps_net"])] for r in read("neural")["rows"]])


def bench(file: str, part: str) -> str:
    """A table of bench/results.py, after what it was measured on."""
    found = read(file)["tables"][part]
    return (f"{found['machine']}; commit {found['commit']}, {found['date']}.\n\n"
            f"{table(found['head'], found['rows'])}")


TABLES: dict[str, Callable[[], str]] = {"accuracy": accuracy, "peers": peers,
                                    "assets": assets, "particle assets": particle_assets,
                                    "dent": dent,
                                    "discretisation": discretisation, "curved": curved,
                                    "real shape": real_shape,
                                    "time to error": time_to_error, "sweeps": sweeps,
                                    "ladder": ladder, "scene stress": scene_stress,
                                    "fits": lambda: table(*fits()), "neural": neural,
                                    "generation": lambda: table(*generation()),
                                    "fine tuning": lambda: table(*fine_tuning()),
                                    "held machine": measured_on,
                                    "held times machine": times_measured_on,
                                    "drops machine": drops_machine,
                                    "drops peers machine": peers_machine} | MACHINES | {
    f"study {name}": (lambda n=name: study(n)) for name in STUDIES} | {
    f"{title} {part.replace('-', ' ')}": (lambda f=file, p=part: bench(f, p))
    for title, file in (("bench", "benchmarks"), ("device", "device")) for part in BENCH_PARTS} | {
    name: (lambda lines=lines: table(*lines()))
    for name, lines in (PAPER_TABLES | METAL_TABLES | PARTICLE_TABLES | HOLD_TABLES | MOTION_TABLES
                        | DROP_TABLES).items()}


def rendered(text: str, place: str) -> str:
    """A page with its tables anew."""
    def replace(match: re.Match[str]) -> str:
        if match[1] not in TABLES:
            raise SystemExit(f"{place}: no table is called '{match[1]}'")
        return f"<!-- table {match[1]} -->\n\n{TABLES[match[1]]()}\n\n<!-- end -->"
    return re.sub(r"<!-- table ([\w ]+) -->.*?<!-- end -->", replace, text, flags=re.S)


def outdated() -> list[str]:
    """Results whose scenes or scripts are not those they were computed from."""
    found = []
    for path in sorted(RESULTS.glob("*.json")):
        result = json.loads(path.read_text())
        for part in (result, *result.get("tables", {}).values()):
            stamp = part.get("definitions") if isinstance(part, dict) else None
            if stamp and definitions_hash(stamp["files"]) != stamp["sha256"]:
                found.append(f"{path.relative_to(ROOT)}: older than {', '.join(stamp['files'])}")
    return found


def main() -> int:
    """Writes or checks."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--check", action="store_true")
    check = options.parse_args().check
    faults = outdated() + long_lines(ROOT) + missing_names(ROOT)
    for page in sorted((ROOT / "docs").glob("*.md")):
        text = page.read_text()
        new = rendered(text, str(page.relative_to(ROOT)))
        if new == text:
            continue
        if check:
            faults.append(f"{page.relative_to(ROOT)}: not what docs/results say; run "
                          "docs/generate.py")
        else:
            page.write_text(new)
    print("\n".join(faults) if faults else "up to date", file=sys.stderr if faults else sys.stdout)
    return int(bool(faults) and check)


if __name__ == "__main__":
    sys.exit(main())
