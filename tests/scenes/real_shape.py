#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The network on a real mesh against quadratic tetrahedra of the same surface.

    tests/scenes/real_shape.py --binary build/cpu/elastogen --asset spot.obj [--json FILE]

TetGen (Debian's tetgen, optional) fills the closed triangle mesh with tetrahedra twice: with its
triangles as they are, and cut where quality asks for it, which leaves the surface where it is. Both
become quadratic with straight edges. Nothing is held: the body starts with a spin, whose centrifugal
force stretches it, and both sides take the same implicit steps. Errors are rms distances of the
mesh's own vertices after the last step, over the rms distance of the reference from its best rigid
fit (deformation) and from the start (motion). Exit status 1 if an error does not fall with h."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from math import log2
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from definitions import definitions_hash

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # of a quadratic tetrahedron, as in VTK
GRIDS = (16, 32, 64)
SIZE = 0.3  # [m]
SCENE = ("--size", f"{SIZE} m", "--up", "y", "--young", "3e4", "--poisson", "0.3", "--density",
         "1000", "--law", "neo-hookean", "--gravity", "0,0,0", "--spin", "0,0,15", "--frames", "6",
         "--fps", "60", "--substeps", "1", "--quiet")
MESHES = {"triangles as they are": "-pYkq1.4a0.002", "cut for quality": "-pkq1.4a0.002"}


def read_obj(path: Path) -> tuple[Floats, Ints]:
    """Vertices and triangles; polygons become fans."""
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            face = [int(word.split("/")[0]) - 1 for word in words[1:]]
            triangles += [[face[0], face[k], face[k + 1]] for k in range(1, len(face) - 1)]
    return np.array(vertices), np.array(triangles)


def tetrahedra(folder: Path, mesh: tuple[Floats, Ints], switches: str) -> tuple[Floats, Ints]:
    """TetGen's points, of which the first are the mesh's vertices, and tetrahedra."""
    vertices, triangles = mesh
    lines = [f"OFF\n{len(vertices)} {len(triangles)} 0"]
    lines += [" ".join(map(repr, x)) for x in vertices.tolist()]
    lines += ["3 " + " ".join(map(str, t)) for t in triangles.tolist()]
    (folder / "body.off").write_text("\n".join(lines) + "\n")
    subprocess.run(["tetgen", switches, str(folder / "body.off")], check=True,
                   stdout=subprocess.DEVNULL)
    points = np.loadtxt(folder / "body.1.node", skiprows=1, comments="#")[:, 1:4]
    cells = np.loadtxt(folder / "body.1.ele", skiprows=1, comments="#", dtype=np.int64)[:, 1:5]
    return points, cells


def write_quadratic(path: Path, points: Floats, cells: Ints) -> None:
    """A VTK file of tetrahedra with a node in the middle of each edge."""
    pairs = np.sort(np.concatenate([cells[:, edge] for edge in EDGES]), axis=1)
    edges, place = np.unique(pairs, axis=0, return_inverse=True)
    points = np.concatenate([points, points[edges].mean(1)])
    middles = len(points) - len(edges) + place.reshape(6, -1).T
    rows = np.concatenate([np.full((len(cells), 1), 10), cells, middles], axis=1)
    with path.open("w") as file:
        file.write("# vtk DataFile Version 2.0\nbody\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                   f"POINTS {len(points)} double\n")
        np.savetxt(file, points, fmt="%.17g")
        file.write(f"CELLS {len(cells)} {rows.size}\n")
        np.savetxt(file, rows, fmt="%d")
        file.write(f"CELL_TYPES {len(cells)}\n" + "24\n" * len(cells))


def run(binary: Path, verb: str, *words: object) -> None:
    """Runs the command on the scene."""
    done = subprocess.run([str(binary), verb, *map(str, words), *SCENE], capture_output=True,
                          text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{verb} {words}: {done.returncode}: {done.stderr}")


def last_frame(path: Path) -> Floats:
    """Positions of a point cache's last frame."""
    data = path.read_bytes()
    points = int.from_bytes(data[16:20], "little")
    return np.frombuffer(data[32:], "<f4").reshape(-1, points, 3)[-1].astype(float)


def rms(distance: Floats) -> float:
    """Root of the mean square of rows."""
    return float(np.sqrt((distance**2).sum(1).mean()))


def deformation(X: Floats, x: Floats) -> float:
    """Rms distance of x from the rigid motion of X that is nearest to it (Kabsch)."""
    a, b = X - X.mean(0), x - x.mean(0)
    u, _, v = np.linalg.svd(a.T @ b)
    return rms(b - a @ (u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v))


def measured(binary: Path, asset: Path) -> dict[str, Any]:
    """The references, and the network on each grid."""
    mesh = read_obj(asset)
    metres = SIZE / float(np.ptp(mesh[0], axis=0).max())
    ends, counts = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for switches in MESHES.values():
            points, cells = tetrahedra(folder, mesh, switches)
            write_quadratic(folder / "body.vtk", points, cells)
            run(binary, "simulate", folder / "body.vtk", "-o", folder / "a.pc2", "--state",
                folder / "state.h5")
            counts.append(len(cells))
            with h5py.File(folder / "state.h5") as file:
                ends.append(file["steps/x"][-1][:len(mesh[0])])
        x, X = ends[-1], mesh[0] * metres
        bent, moved = deformation(X, x), rms(x - X)
        grids = []
        for voxels in GRIDS:
            run(binary, "animate", asset, "--voxels", voxels, "--tolerance", "1e-5", "-o",
                folder / "b.pc2")
            error = rms(last_frame(folder / "b.pc2") * metres - x)
            grids.append({"voxels": voxels, "deformation": error / bent, "motion": error / moved})
    orders = [log2(a["deformation"] / b["deformation"]) for a, b in zip(grids, grids[1:])]
    return {"asset": asset.name, "deformation": bent, "motion": moved, "cells": counts,
            "reference_change": rms(ends[0] - x) / bent, "grids": grids, "orders": orders}


def main() -> int:
    """Runs and prints."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--asset", type=Path, required=True, help="a closed OBJ mesh")
    options.add_argument("--json", type=Path, help="results, for the table of the documentation")
    chosen = options.parse_args()
    row = measured(chosen.binary, chosen.asset)
    print(json.dumps(row, indent=1))
    if chosen.json:
        files = ["tests/scenes/real_shape.py"]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "rows": [row]}, indent=1) + "\n")
    return int(min(row["orders"]) <= 0)


if __name__ == "__main__":
    sys.exit(main())
