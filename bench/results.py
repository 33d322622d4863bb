#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/benchmarks.md from what `elastogen bench --json` wrote: docs/results/NAME.json.

    bench/results.py NAME BENCH.json [BENCH.json ...]

NAME is benchmarks (of a CPU) or device (of a card). Run it on the commit that was measured; rows of
one part in several files stand below each other. Parts that no file has keep the table that they
have; each says on which commit, day and machine it was measured. docs/generate.py puts the tables
into the page."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "scenes"))
from definitions import definitions_hash  # noqa: E402

Row = dict[str, Any]
Column = tuple[str, Callable[[Row], str]]


def cell(key: str, form: str = "{}") -> Callable[[Row], str]:
    """Of a number that may be missing."""
    return lambda row: "" if row.get(key) is None else form.format(row[key])


def stage(key: str) -> Callable[[Row], str]:
    """Of a start [s]."""
    return lambda row: f"{row['stage_seconds'][key]:.2f}"


def yes(key: str) -> Callable[[Row], str]:
    """Of a truth value."""
    return lambda row: "yes" if row[key] else "no"


SCENE: list[Column] = [("scene", cell("scene")), ("voxels", cell("voxels")),
                       ("C", cell("courant", "{:.4g}")), ("nu", cell("poisson"))]
TABLES: dict[str, list[Column]] = {
    "ceilings": [("threads", cell("threads")), ("copy [GB/s]", cell("copy", "{:.1f}")),
                 ("float [GFLOP/s]", cell("float", "{:.0f}")),
                 ("double [GFLOP/s]", cell("double", "{:.0f}"))],
    "kernels": [("kernel", cell("kernel")), ("voxels", cell("voxels")),
                ("ms", cell("ms", "{:.3f}")),
                ("B a voxel", cell("bytes_a_voxel", "{:.0f}")),
                ("GB/s", lambda r: f"{1e-9 * r['bytes_per_second']:.1f}"),
                ("share of copy", lambda r: f"{100 * r['copy_share']:.0f} %")],
    "particles": [("step", cell("integrator")), ("particles", cell("particles")),
                  ("threads", cell("threads")), ("ms", cell("ms", "{:.2f}")),
                  ("quartiles",
                   lambda r: f"{r['ms_lower_quartile']:.2f} ... {r['ms_upper_quartile']:.2f}"),
                  ("million updates/s", lambda r: f"{1e-6 * r['updates_per_second']:.2f}"),
                  ("share of copy", lambda r: f"{100 * r['copy_share']:.0f} %"
                   if "copy_share" in r else ""),
                  ("Newton steps", cell("newton_a_step", "{:.1f}")),
                  ("GMRES iterations", cell("iterations_a_step", "{:.0f}")),
                  ("certified", lambda r: f"{r['certified']} of {r['steps']}"
                   if "steps" in r else ""),
                  ("B a particle", cell("memory_bytes_a_particle", "{:.0f}"))],
    "step": [*SCENE, ("fill", cell("fill")), ("on", cell("device")),
             ("numbers", lambda r: "double" if r["float64"] else "float"),
             ("ms", cell("ms", "{:.2f}")),
             ("quartiles",
              lambda r: f"{r['ms_lower_quartile']:.2f} ... {r['ms_upper_quartile']:.2f}"),
             ("evaluations", cell("evaluations")), ("residual", cell("residual", "{:.1e}")),
             ("set-up [s]", cell("setup_seconds", "{:.2f}")),
             ("B a voxel, host", cell("host_bytes_a_voxel", "{:.0f}")),
             ("card", cell("card_bytes_a_voxel", "{:.0f}"))],
    "error-time": [*SCENE, ("fill", cell("fill")), ("mode", cell("solver")),
                   ("tolerance", cell("tolerance", "{:.0e}")),
                   ("outer", cell("outer")), ("inner", cell("inner")), ("float64", yes("float64")),
                   ("residual", cell("residual", "{:.1e}")), ("error", cell("error", "{:.1e}")),
                   ("ms", cell("ms", "{:.1f}")), ("setup s", cell("setup_seconds", "{:.2f}"))],
    "tip": [("run", cell("run")), ("voxels", cell("voxels")), ("on", cell("device")),
            ("ms a frame", cell("ms", "{:.2f}")),
            ("converged", lambda r: f"{r['converged']} of {r['frames']}"),
            ("worst residual", cell("residual", "{:.1e}")),
            *[(f"tip at {(k + 1) / 30:.1f} s [mm]", lambda r, k=k: f"{1e3 * r['tip'][k]:.2f}")
              for k in (5, 11, 17, 23)],
            ("largest distance to the finest tet10 [% of its last]", cell("away", "{:.2f}"))],
    "baseline": [*SCENE, ("run", cell("run")), ("on", cell("device")), ("ms", cell("ms", "{:.2f}")),
                 ("residual", cell("residual", "{:.1e}")), ("error", cell("error", "{:.1e}")),
                 ("time over quasi", cell("time_ratio", "{:.3g}")),
                 ("error over quasi", cell("error_ratio", "{:.3g}"))],
    "startup": [("material", cell("material")), ("solver", cell("solver")),
                ("voxels", cell("voxels")), ("read", stage("read")),
                ("voxelise", stage("voxelize")), ("set up", stage("setup")),
                ("first step", stage("steps")), ("all s", cell("seconds", "{:.2f}")),
                ("B a voxel", cell("bytes_a_voxel", "{:.0f}"))]}
SOURCES = {"ceilings": ["ceilings.cpp", "card_ceilings.cu"],
           "kernels": ["kernels.cpp", "card_kernels.cpp", "card_tangents.cu"], "step": ["step.cpp"],
           "error-time": ["error_time.cpp", "measure.cpp"],
           "tip": ["tip.cpp"],
           "baseline": ["baseline.cpp", "baselines/dense_grid.py", "baselines/elastogen_paper.py",
                        "baselines/local_step.py", "measure.cpp"],
           "particles": ["particles.cpp"], "startup": ["startup.cpp"]}
COMMON = ["lattice.cpp", "scenes.cpp", "timing.cpp"]


def ceiling_rows(part: dict[str, Any]) -> list[Row]:
    """Threads of the host, and the card."""
    def named(row: Row, name: str) -> Row:
        return {"threads": name, "copy": 1e-9 * row["copy_bytes_per_second"],
                "float": 1e-9 * row["float_flops_per_second"],
                "double": 1e-9 * row["double_flops_per_second"]}
    rows = [named(row, str(row["threads"])) for row in part["host"]]
    return rows + ([named(part["card"], part["card"]["name"])] if part["card"] else [])


def baseline_rows(part: list[dict[str, Any]]) -> list[Row]:
    """The runs of every case, beside its first one, quasi."""
    rows = []
    for case in part:
        ours = case["rows"][0]
        for row in case["rows"]:
            ratios = {f"{name}_ratio": row[key] / ours[key] for name, key in
                      (("time", "ms"), ("error", "error")) if row.get(key) is not None}
            rows.append({key: case[key] for key in ("scene", "voxels", "courant", "poisson")}
                        | row | ratios)
    return rows


def budget(row: Row) -> str:
    """Time of a run with its error."""
    error = "refused" if row["error"] is None else f"{row['error']:.0e}"
    return f"{row['ms']:.2f} ({error})"


def curve_rows(part: list[Row]) -> list[Row]:
    """The runs of a solver on a scene, a row each: the loosest budget first."""
    curves: dict[tuple[Any, ...], Row] = {}
    for row in part:
        names = ("scene", "voxels", "courant", "poisson", "fill", "solver")
        key = tuple(row[name] for name in names)
        curve = curves.setdefault(key, row | {"runs": []})
        curve["runs"].append(budget(row))
    return list(curves.values())


CURVES: list[Column] = [*SCENE, ("fill", cell("fill")), ("mode", cell("solver")),
                        ("ms (error) of each tolerance or number of outer loops",
                         lambda r: ", ".join(r["runs"]))]


def rows_of(name: str, part: Any) -> list[Row]:
    """Of a part."""
    special = {"ceilings": ceiling_rows, "baseline": baseline_rows}
    return special[name](part) if name in special else part


def judge_tips(rows: list[Row]) -> None:
    """Adds how far each curve strays from that of the finest elements, in per cent of its end."""
    best = max((row for row in rows if row["run"] == "tet10"), key=lambda row: row["voxels"])["tip"]
    for row in rows:
        away = max(abs(tip - truth) for tip, truth in zip(row["tip"], best, strict=True))
        row["away"] = 100 * away / abs(best[-1])


def make_table(name: str, having: list[dict[str, Any]]) -> dict[str, Any]:
    """The table of a part, from the results that have it."""
    columns = TABLES[name]
    rows = [row for result in having for row in rows_of(name, result[name])]
    if name == "tip":
        judge_tips(rows)
    if name == "error-time" and having[0]["card"]:
        columns, rows = CURVES, curve_rows(rows)
    commands = [re.sub(r" --(json|python|script) \S+", "", result["command"]) for result in having]
    files = sorted(f"bench/{file}" for file in SOURCES[name] + COMMON)
    first = having[0]
    rates = first["copy_bytes_per_second"]
    cpu = first["machine"]["cpu"]
    machine = (f"{first['card']}: copy {1e-12 * rates['card']:.2f} TB/s, read and written"
               if first["card"] else f"{cpu}: copy {1e-9 * rates['host']:.1f} GB/s")
    return {"definitions": {"files": files, "sha256": definitions_hash(files)},
            "commit": ", ".join(dict.fromkeys(result["commit"] for result in having)),
            "date": first["date"][:10], "machine": machine, "commands": commands,
            "head": [head for head, _ in columns],
            "rows": [[text(row) for _, text in columns] for row in rows]}


def main() -> int:
    """Writes the tables."""
    if len(sys.argv) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    results = [json.loads(Path(path).read_text()) for path in sys.argv[2:]]
    to = ROOT / "docs" / "results" / f"{sys.argv[1]}.json"
    tables: dict[str, dict[str, Any]] = json.loads(to.read_text())["tables"] if to.exists() else {}
    for name in TABLES:
        if having := [result for result in results if name in result]:
            tables[name] = make_table(name, having)
    to.write_text(json.dumps({"tables": tables}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
