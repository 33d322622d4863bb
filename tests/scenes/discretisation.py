#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The network's element against quadratic tetrahedra on boxes: statics of large loads by `simulate`.

    tests/scenes/discretisation.py --binary build/cpu/elastogen [--json FILE] [--scenes NAME ...]

Each scene is solved with `voxel` on three grids, each half as coarse as the next, and with `tet10` on
two, whose difference bounds what the reference itself is off. Errors are those of the displacement
at the coarsest grid's nodes, weighted with their masses, over the rms displacement. Prints a table
with the observed orders; exit status 1 if the order from the coarsest to the finest grid is below
that of the scene. Smooth solutions give 2; the edges of clamped faces are singular, and the cube has
them all around both faces that load it: order 1 there, for the tetrahedra of the reference too."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from math import log2
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from definitions import definitions_hash
from shapes import BOX_FACES, box

Floats = NDArray[np.float64]
SOFT = ("--law", "neo-hookean", "--young", "1e6", "--density", "1000", "--up", "y")


@dataclass(frozen=True)
class Scene:
    """Edges [m], options, and voxels along the longest edge: of the network's element, of tet10."""

    edges: tuple[float, float, float]
    options: tuple[str, ...]
    voxels: tuple[int, ...]
    reference: tuple[int, int]
    order: float = 1.5  # at least


SCENES = {
    "cantilever, nu 0.3": Scene((0.8, 0.1, 0.1), ("--poisson", "0.3", "--pin", "x<0%"),
                                (16, 32, 64), (32, 64)),
    "cantilever, nu 0.45": Scene((0.8, 0.1, 0.1), ("--poisson", "0.45", "--pin", "x<0%"),
                                 (16, 32, 64), (32, 64)),
    "bar twisted by 90 degrees": Scene(
        (0.4, 0.1, 0.1), ("--poisson", "0.3", "--gravity", "0,0,0", "--pin", "x<0%", "--move",
                          "x>100%: turn(0,50%,50%, 1,0,0) 0s:0; 1s:90deg"), (8, 16, 32), (16, 32)),
    "cube pressed by 30 %": Scene(
        (0.1, 0.1, 0.1), ("--poisson", "0.3", "--gravity", "0,0,0", "--pin", "y<0%", "--move",
                          "y>100%: shift 0s:0,0,0; 1s:0,-3cm,0"), (8, 16, 32), (16, 32),
        order=1.0),
}


def solve(binary: Path, scene: Scene, element: str, voxels: int) -> dict[str, Any]:
    """Rest positions, displacements and masses of the grid's nodes in equilibrium."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        vertices, _ = box(*scene.edges)
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        lines += ["f " + " ".join(str(v + 1) for v in face) for face in BOX_FACES]
        (folder / "box.obj").write_text("\n".join(lines) + "\n")
        words = [str(binary), "simulate", str(folder / "box.obj"), "--static", "--quiet", *SOFT,
                 *scene.options, "--voxels", str(voxels), "--element", element, "--mass",
                 "lumped" if element == "voxel" else "consistent", "--tolerance", "1e-8",
                 "-o", str(folder / "out.pc2"), "--state", str(folder / "state.h5")]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.returncode}: {done.stderr}")
        with h5py.File(folder / "state.h5") as file:
            X = file["grid/rest"][()]
            return {"X": X, "u": file["steps/x"][-1] - X, "mass": file["grid/mass"][()],
                    "ms": float(file["steps/ms"][0])}


def at(solution: dict[str, Any], X: Floats, h: float) -> Floats:
    """Displacements at nodes that are nodes of the solution too."""
    key = {tuple(place): n for n, place in enumerate(np.rint(solution["X"] / h * 8).astype(int)
                                                     .tolist())}
    return solution["u"][[key[tuple(place)] for place in np.rint(X / h * 8).astype(int).tolist()]]


def error(coarse: dict[str, Any], fine: dict[str, Any], h: float) -> float:
    """Of the coarse solution's displacements against the fine one's at its nodes."""
    truth = at(fine, coarse["X"], h)
    weight = coarse["mass"][:, None]
    return float(np.sqrt((weight * (coarse["u"] - truth) ** 2).sum()
                         / (weight * truth ** 2).sum()))


def study(binary: Path, scene: Scene) -> dict[str, Any]:
    """Errors of all grids of a scene."""
    edge = scene.edges[0]
    finest = max(*scene.voxels, *scene.reference)
    rough, fine = (solve(binary, scene, "tet10", n) for n in scene.reference)
    grids = [solve(binary, scene, "voxel", n) for n in scene.voxels]
    coarsest = grids[0] | {"h": edge / finest}
    errors = []
    for grid in grids:
        # the nodes that all grids share, so that errors of different grids are of one kind
        shared = {"X": coarsest["X"], "mass": coarsest["mass"],
                  "u": at(grid, coarsest["X"], edge / finest)}
        errors.append(error(shared, fine, edge / finest))
    shared = {"X": coarsest["X"], "mass": coarsest["mass"],
              "u": at(rough, coarsest["X"], edge / finest)}
    return {"voxels": list(scene.voxels), "errors": errors,
            "orders": [log2(a / b) for a, b in zip(errors, errors[1:])],
            "order": log2(errors[0] / errors[-1]) / (len(errors) - 1),
            "reference": list(scene.reference),
            "reference_change": error(shared, fine, edge / finest)}


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    options.add_argument("--scenes", nargs="*", default=list(SCENES), choices=list(SCENES))
    chosen = options.parse_args()
    rows, bad = [], []
    print("| scene | voxels along it | errors | orders | tet10 between its grids |\n"
          "|---|---|---|---|---|")
    for name in chosen.scenes:
        r = study(chosen.binary, SCENES[name])
        rows.append({"scene": name} | r)
        print(f"| {name} | {', '.join(map(str, r['voxels']))} | "
              f"{', '.join(f'{e:.1e}' for e in r['errors'])} | "
              f"{', '.join(f'{o:.2f}' for o in r['orders'])} | {r['reference_change']:.1e} |",
              flush=True)
        if r["order"] < SCENES[name].order:
            bad.append(f"{name}: order {r['order']:.2f}")
    if chosen.json:
        files = ["tests/scenes/discretisation.py", "tests/scenes/shapes.py"]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "rows": rows}, indent=1) + "\n")
    print("\n".join(bad) or "orders as they should be")
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
