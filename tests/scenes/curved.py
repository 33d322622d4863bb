#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The network's element on bodies that the grid cuts, against quadratic tetrahedra that fit them.

    tests/scenes/curved.py --binary build/cpu/discretisation_curved [--json FILE]
                           [--scenes NAME ...]

Each scene (tests/curved/scenes.cpp) is an equilibrium under large loads on 16, 32 and 64 voxels
along the body and on three meshes of tetrahedra. Errors are those of displacement over its rms, at
the nodes of the coarsest grid that lie in the body, weighted with their masses, and at points of
its surface. Prints a table with the observed orders; exit status 1 if the order from the coarsest
to the finest grid is below 1.4, or below 1.9 where nothing is held."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from math import log2
from pathlib import Path
from typing import Any

from definitions import definitions_hash

SOURCES = ("curved_scene.hpp", "errors.cpp", "main.cpp", "mapped_body.cpp", "mapped_body.hpp",
           "scenes.cpp", "solve.cpp", "tet_field.cpp", "tet_field.hpp")


def with_orders(result: dict[str, Any]) -> dict[str, Any]:
    """A scene's result with the observed orders at the nodes inside."""
    errors = [grid["inside"] for grid in result["grids"]]
    orders = [log2(a / b) for a, b in zip(errors, errors[1:])]
    return result | {"orders": orders, "order": log2(errors[0] / errors[-1]) / (len(errors) - 1)}


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    options.add_argument("--scenes", nargs="*")
    chosen = options.parse_args()
    binary = str(chosen.binary.resolve())
    names = chosen.scenes or subprocess.run([binary], capture_output=True, text=True,
                                            check=True).stdout.splitlines()
    rows, bad = [], []
    print("| scene | errors | orders | reference's own error |\n|---|---|---|---|")
    for name in names:
        done = subprocess.run([binary, name], stdout=subprocess.PIPE, text=True, check=True)
        row = {"scene": name} | with_orders(json.loads(done.stdout))
        rows.append(row)
        errors = ", ".join(f"{grid['inside']:.1e}" for grid in row["grids"])
        orders = ", ".join(f"{order:.2f}" for order in row["orders"])
        print(f"| {name} | {errors} | {orders} | {row['reference_inside']['error']:.1e} |",
              flush=True)
        target = 1.9 if "nothing held" in row["load"] else 1.4
        if row["order"] < target:
            bad.append(f"{name}: order {row['order']:.2f}, below {target}")
    if chosen.json:
        files = ["tests/scenes/curved.py", *(f"tests/curved/{name}" for name in SOURCES)]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "rows": rows}, indent=1) + "\n")
    print("\n".join(bad) or "orders as expected")
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
