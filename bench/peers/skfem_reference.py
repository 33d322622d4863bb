# SPDX-License-Identifier: Apache-2.0
"""Solves the scenes of this folder with scikit-fem and writes one JSON file of results.

usage: skfem_reference.py [--check] [--scene NAME]... [--output FILE]

Without --scene all scenes are solved; with it those named replace their old results in FILE.
--check solves none but tests this code: derivatives, closed forms, beams, laws of motion. README.md
lists what the results mean. Exit status 1 if a test fails or a run in FILE has not converged.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import skfem
from numpy.typing import NDArray

import skfem_check
from richardson import Estimate, richardson
from scene_file import Run, Scene, read_scene
from skfem_body import Body
from skfem_solve import Solution, body_of, solve

HERE = Path(__file__).resolve().parent
QUADRATIC = ("hex27", "tet10")
DIGITS_STATIC, DIGITS_IN_TIME, DIGITS_UNCERTAINTY = 11, 7, 3
NOISE = 1e-12  # written as 0


def rounded(values: Any, digits: int) -> Any:
    """Nested lists of the values with so many significant digits, noise as 0."""
    array = np.asarray(values)
    if array.ndim:
        return [rounded(value, digits) for value in array]
    return float(f"{float(array):.{digits - 1}e}") if abs(array) > NOISE else 0.0


def run_record(scene: Scene, run: Run, body: Body, solution: Solution) -> dict[str, Any]:
    """The results of one mesh."""
    _, points, corners, _ = body.shape_gradient.shape
    record: dict[str, Any] = {
        "element": run.element, "cells": list(run.cells), "h": scene.box[1] / run.cells[1],
        "element_count": len(body.elements), "nodes_of_element": corners,
        "quadrature_points": points, "unknowns": 3 * body.nodes, "nonzeros": body.nonzeros,
        "converged": solution.report.converged, "residual": float(f"{solution.report.residual:.1e}"),
        "newton_steps": solution.report.newton_steps, "halvings": solution.report.halvings,
        "min_j": rounded(solution.min_j, 6),
        "seconds": rounded(solution.seconds.wall, 3),
        "cpu_seconds": rounded(solution.seconds.cpu, 3)}
    if run.mass:
        record["mass"] = run.mass
    digits = DIGITS_IN_TIME if scene.dt else DIGITS_STATIC
    record["probes"] = {name: rounded(value, digits) for name, value in solution.probes.items()}
    return record


def estimate_record(estimate: Estimate, digits: int) -> dict[str, Any]:
    return {"estimate": rounded(estimate.estimate, digits),
            "uncertainty": rounded(estimate.uncertainty, DIGITS_UNCERTAINTY),
            "order": rounded(estimate.order, DIGITS_UNCERTAINTY)}


def best_of(families: dict[str, Estimate]) -> Estimate:
    """Of each value the quadratic element with the least uncertainty, which becomes at least the
    distance to the estimate of the other quadratic element."""
    first, second = (families[element] for element in QUADRATIC)
    take = first.uncertainty <= second.uncertainty
    distance = np.abs(first.estimate - second.estimate)
    return Estimate(np.where(take, first.estimate, second.estimate),
                    np.maximum(np.minimum(first.uncertainty, second.uncertainty), distance),
                    np.where(take, first.order, second.order))


def solve_scene(scene: Scene) -> dict[str, Any]:
    """Results of all meshes and what follows from their differences."""
    runs: list[dict[str, Any]] = []
    values: dict[str, list[dict[str, NDArray[np.float64]]]] = {}
    for run in scene.runs:
        body = body_of(scene, run)
        solution = solve(scene, run, body)
        runs.append(run_record(scene, run, body, solution))
        values.setdefault(run.element, []).append(solution.probes)
        report = solution.report
        print(f"{scene.name} {run.element} {run.cells}: residual {report.residual:.1e}, "
              f"{report.newton_steps} Newton steps, {solution.seconds.cpu:.1f} s", flush=True)
    digits = DIGITS_IN_TIME if scene.dt else DIGITS_STATIC
    by_element: dict[str, Any] = {element: {} for element in values}
    estimates = {}
    for name in values["hex"][0]:
        families = {element: richardson([r["h"] for r in runs if r["element"] == element],
                                        [probes[name] for probes in meshes])
                    for element, meshes in values.items()}
        for element, estimate in families.items():
            by_element[element][name] = estimate_record(estimate, digits)
        estimates[name] = estimate_record(best_of(families), digits)
    return {"runs": runs, "by_element": by_element, "estimates": estimates}


def written(results: dict[str, Any]) -> str:
    """JSON with each list of numbers, or of lists of numbers, on one line without blanks."""
    text = json.dumps(results, indent=1)
    return re.sub(r"\[[^{}\"]*\]", lambda m: "".join(m[0].split()), text) + "\n"


def main() -> int:
    scenes = {path.stem: path for path in sorted((HERE / "scenes").glob("*.json"))}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="test this code instead")
    parser.add_argument("--scene", action="append", choices=sorted(scenes), metavar="NAME")
    parser.add_argument("--output", type=Path, default=HERE / "results" / "skfem.json")
    arguments = parser.parse_args()
    if arguments.check:
        return skfem_check.main()
    results: dict[str, Any] = {"scenes": {}}
    if arguments.scene and arguments.output.exists():
        results = json.loads(arguments.output.read_text())
    results["code"] = {"scikit-fem": skfem.__version__, "numpy": np.__version__,
                       "scipy": scipy.__version__, "python": platform.python_version(),
                       "threads": os.environ.get("OMP_NUM_THREADS", "unset")}
    for name in arguments.scene or scenes:
        results["scenes"][name] = solve_scene(read_scene(scenes[name]))
        arguments.output.write_text(written(results))
    converged = [run["converged"] for s in results["scenes"].values() for run in s["runs"]]
    return 0 if all(converged) else 1


if __name__ == "__main__":
    sys.exit(main())
