#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Our finite elements beside the independent results: the same scenes, meshes and elements.

    bench/peers/compare.py --binary build/cpu/elastogen [--json FILE]

Runs `elastogen simulate` on every run of results/skfem.json that has an element of ours (hex and
tet10: node for node the same meshes) and prints, as Markdown, the largest relative difference of the
probes and the times of both. Exit status 1 if a difference is above 1e-5: the tolerances of both
solvers are smaller, the mesh errors much larger."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1] / "tests" / "scenes"), str(HERE.parents[1] / "docs")]
from definitions import definitions_hash  # noqa: E402
from shapes import BOX_FACES, box  # noqa: E402

Floats = NDArray[np.float64]
BOUND = 1e-5


def command(binary: Path, folder: Path, scene: dict[str, Any], run: dict[str, Any]) -> list[str]:
    """`simulate` of one run."""
    edges, material, cells = scene["box"], scene["material"], run["cells"]
    vertices, _ = box(*edges)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in BOX_FACES]
    (folder / "box.obj").write_text("\n".join(lines) + "\n")
    gravity = ",".join(map(str, scene.get("gravity", [0, 0, 0])))
    words = [str(binary), "simulate", str(folder / "box.obj"), "-o", str(folder / "out.pc2"),
             "--state", str(folder / "state.h5"), "--quiet", "--up", "y",
             "--law", material["law"], "--young", str(material["young"]),
             "--poisson", str(material["poisson"]), "--density", str(material["density"]),
             "--gravity", gravity, "--voxels", str(cells[0]), "--pin", "x<0%",
             "--element", run["element"], "--tolerance", "1e-9"]
    turn = next((b for b in scene["boundary"] if "angle" in b), None)
    if turn:
        y, z = turn["centre"]
        words += ["--move", f"x>100%: turn(0,{y},{z}, 1,0,0) 0s:0; 1s:{turn['angle']}rad"]
    # in statics the mass only spreads the weight; theirs is integrated without error
    words += ["--mass", run.get("mass", "consistent")]
    if "dt" not in scene:
        return [*words, "--static"]
    return [*words, "--fps", str(round(1 / scene["dt"])), "--frames", str(scene["steps"]),
            "--substeps", "1"]


def face_mean(X: Floats, u: Floats, scene: dict[str, Any], run: dict[str, Any]) -> Floats:
    """Mean displacement of the end face of a hexahedral mesh, trapezoids over its cells."""
    face = np.isclose(X[:, 0], scene["box"][0])
    weight = np.ones(face.sum())
    for d in (1, 2):
        h = scene["box"][d] / run["cells"][d]
        at = X[face, d]
        weight *= np.where(np.isclose(at, 0) | np.isclose(at, scene["box"][d]), h / 2, h)
    return np.einsum("n,...nd->...d", weight, u[..., face, :]) / weight.sum()


def quadratic_face_mean(X: Floats, u: Floats, scene: dict[str, Any], corners: NDArray[Any]
                        ) -> Floats:
    """The same of quadratic tetrahedra: a third of each triangle's area at each edge's middle."""
    inside = np.isclose(X[:, 0], scene["box"][0])
    weight = np.zeros(len(X))
    faces = (((0, 1, 2), (4, 5, 6)), ((0, 1, 3), (4, 8, 7)), ((1, 2, 3), (5, 9, 8)),
             ((0, 2, 3), (6, 9, 7)))
    for three, middles in faces:
        tets = corners[inside[corners[:, three]].all(1)]
        a, b, c = (X[tets[:, k]] for k in three)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        for middle in middles:
            np.add.at(weight, tets[:, middle], area / 3)
    return np.einsum("n,...nd->...d", weight, u) / weight.sum()


def ours(binary: Path, scene: dict[str, Any], run: dict[str, Any]) -> dict[str, Any]:
    """Probes and time of our run."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        words = command(binary, folder, scene, run)
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)}: {done.returncode}: {done.stderr}")
        with h5py.File(folder / "state.h5") as file:
            X = file["grid/rest"][()]
            u = file["steps/x"][1:] - X
            corners = file["grid/corners"][()]
            probes: dict[str, Any] = {"elastic": file["steps/energy_elastic"][()]}
            if "dt" in scene:
                probes["kinetic"] = file["steps/energy_kinetic"][()]
            seconds = float(file["steps/ms"][()].sum()) / 1e3
    for probe in scene["probes"]:
        if probe["quantity"] == "point":
            node = np.argmin(np.linalg.norm(X - probe["at"], axis=1))
            probes[probe["name"]] = u[:, node]
        elif probe["quantity"] == "face_mean":
            probes[probe["name"]] = (face_mean(X, u, scene, run) if run["element"] == "hex"
                                     else quadratic_face_mean(X, u, scene, corners))
    static = "dt" not in scene
    return {"probes": {k: (v[0] if static else v) for k, v in probes.items()},
            "seconds": seconds}


def difference(a: Any, b: Any) -> float:
    """Largest difference over the largest entry."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return float(np.abs(a - b).max() / np.abs(b).max())


def main() -> int:
    """Compares all."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--binary", type=Path, required=True)
    options.add_argument("--json", type=Path, help="results, for the tables of the documentation")
    chosen = options.parse_args()
    theirs = json.loads((HERE / "results" / "skfem.json").read_text())
    rows, worst = [], 0.0
    print("| scene | element | cells | largest difference | mesh error | ours [s] | scikit-fem [s] |"
          "\n|---|---|---|---|---|---|---|")
    for name, found in theirs["scenes"].items():
        scene = json.loads((HERE / "scenes" / f"{name}.json").read_text())
        for run in (r for r in found["runs"] if r["element"] in ("hex", "tet10")):
            mine = ours(chosen.binary, scene, run)
            common = {k: difference(mine["probes"][k], run["probes"][k]) for k in mine["probes"]}
            # how far the mesh is from the estimate of the limit, on the elastic energy
            limit = found["estimates"]["elastic"]["estimate"]
            mesh = difference(run["probes"]["elastic"], limit)
            worst = max(worst, *common.values())
            rows.append({"scene": name, "element": run["element"], "cells": run["cells"],
                         "difference": common, "mesh": mesh, "seconds": mine["seconds"],
                         "their_seconds": run["cpu_seconds"]})
            print(f"| {name} | {run['element']} | {'x'.join(map(str, run['cells']))} | "
                  f"{max(common.values()):.1e} | {mesh:.1e} | {mine['seconds']:.2f} | "
                  f"{run['cpu_seconds']:.2f} |", flush=True)
    if chosen.json:
        files = ["bench/peers/compare.py", "bench/peers/results/skfem.json",
                 *(f"bench/peers/scenes/{name}.json" for name in theirs["scenes"])]
        stamp = {"files": files, "sha256": definitions_hash(files)}
        chosen.json.write_text(json.dumps({"definitions": stamp, "rows": rows}, indent=1) + "\n")
    print(f"largest difference {worst:.2e}, bound {BOUND:.0e}")
    return int(not worst <= BOUND)


if __name__ == "__main__":
    sys.exit(main())
