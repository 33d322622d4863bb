#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A body that drops on a floor, in libuipc (pyuipc on PyPI) and in elastogen on the same card.

    python bench/peers/libuipc_drop.py COMMAND --asset spot.obj --voxels 40 80 118 --json FILE

Jelly (stable neo-Hookean, E 2e4 Pa, nu 0.45, 1050 kg/m^3), 30 cm long, falls by 20 cm; friction 0.5;
40 implicit Euler steps of 1/60 s, no contact of the body with itself. libuipc takes the cells whose
centre lies in the asset, each cut into five tetrahedra, at its own stop, and at a hundredth of its
tolerances; elastogen takes its voxels of that edge, at 1e-3 of the weight and at 1e-6. A row has the
times of the steps after 0.2 s, when the body touches the floor, and the path of its centre of mass,
whose distance to that code's tight run is its error."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from c84_mesh import EVEN, ODD
from libuipc_steps import steps, tighten

YOUNG, POISSON, DENSITY, GRAVITY = 2e4, 0.45, 1050.0, 9.81
LONGEST, DROP, DT, FRAMES, FRICTION = 0.3, 0.2, 1 / 60, 40, 0.5
TOUCHES = 12  # steps before the floor is met
Row = dict[str, Any]


def triangles_of(asset: Path) -> np.ndarray:
    """Corners (faces, 3, 3) of a closed OBJ of triangles or quads, scaled to LONGEST, its feet at y = 0."""
    points, faces = [], []
    for line in asset.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(w) for w in words[1:4]])
        if words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
            faces += [[corners[0], b, c] for b, c in zip(corners[1:], corners[2:], strict=False)]
    at = np.array(points)
    at *= LONGEST / (at.max(axis=0) - at.min(axis=0)).max()
    at -= at.min(axis=0)
    return at[np.array(faces)]


def cells_of(triangles: np.ndarray, h: float) -> np.ndarray:
    """Whether the centre of each cell lies in the body: crossings of lines along z, counted."""
    counts = np.ceil(triangles.max(axis=(0, 1)) / h).astype(int)
    inside = np.zeros(counts, dtype=bool)
    centre_z = (np.arange(counts[2]) + 0.5) * h
    shift = 1e-7 * h  # lines through no vertex and no edge
    for i in range(counts[0]):
        x = (i + 0.5) * h + shift
        near = triangles[(triangles[:, :, 0].min(axis=1) < x) & (triangles[:, :, 0].max(axis=1) > x)]
        for j in range(counts[1]):
            y = (j + 0.5) * h + 2.7 * shift
            a, b, c = (near[:, k] - [x, y, 0] for k in range(3))
            area = [u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] for u, v in ((b, c), (c, a), (a, b))]
            hit = (np.sign(area[0]) == np.sign(area[1])) & (np.sign(area[1]) == np.sign(area[2]))
            if not hit.any():
                continue
            weights = np.array(area)[:, hit]
            z = (weights * np.array([a[hit, 2], b[hit, 2], c[hit, 2]])).sum(axis=0) / weights.sum(axis=0)
            inside[i, j] = (z[:, None] < centre_z).sum(axis=0) % 2 == 1
    return inside


def tetrahedra(inside: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and tetrahedra of positive volume of these cells, neighbours mirrored."""
    shape = np.array(inside.shape) + 1
    cells = np.argwhere(inside)
    corner = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)])
    index = cells[:, None, :] + corner
    index = (index[..., 0] * shape[1] + index[..., 1]) * shape[2] + index[..., 2]
    cut = np.where((cells.sum(axis=1) % 2 == 0)[:, None, None], EVEN, ODD)
    tets = np.take_along_axis(index[:, None, :], cut, axis=2).reshape(-1, 4)
    used, tets = np.unique(tets, return_inverse=True)
    tets = tets.reshape(-1, 4)
    nodes = np.stack(np.unravel_index(used, shape), axis=-1) * h
    turned = np.linalg.det(nodes[tets[:, 1:]] - nodes[tets[:, :1]]) < 0
    tets[turned, :2] = tets[turned, 1::-1]
    return nodes, tets.astype(np.int32)


def lumped(nodes: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Share of each node in the volume."""
    volume = np.linalg.det(nodes[tets[:, 1:]] - nodes[tets[:, :1]])
    share = np.bincount(tets.reshape(-1), np.repeat(volume, 4), len(nodes))
    return share / share.sum()


def libuipc(uipc: Any, nodes: np.ndarray, tets: np.ndarray, tight: bool) -> tuple[list[float], list[float]]:
    """Milliseconds of the steps, and the height of the centre of mass after each [m]."""
    from uipc.constitution import ElasticModuli, StableNeoHookean
    from uipc.geometry import ground, label_surface, tetmesh
    config = uipc.Scene.default_config()
    config["dt"] = DT
    config["gravity"] = [[0.0], [-GRAVITY], [0.0]]
    config["sanity_check"]["enable"] = 0
    config["contact"]["friction"]["enable"] = 1
    config["contact"]["d_hat"] = 1e-3
    if tight:
        tighten(config)
    scene = uipc.Scene(config)
    table = scene.contact_tabular()
    table.default_model(FRICTION, 1e9)
    own = table.create("body")
    table.insert(own, own, 0.0, 0.0, False)  # none with itself
    body = tetmesh(nodes + [0, DROP, 0], tets)
    label_surface(body)
    StableNeoHookean().apply_to(body, ElasticModuli.youngs_poisson(YOUNG, POISSON), DENSITY)
    own.apply_to(body)
    slot, _ = scene.objects().create("body").geometries().create(body)
    scene.objects().create("floor").geometries().create(ground(0.0))
    share, ms, height = lumped(nodes, tets), [], []
    with tempfile.TemporaryDirectory() as folder:
        engine = uipc.Engine("cuda", folder)  # the world does not keep it
        world = uipc.World(engine)
        world.init(scene)
        for taken, at in steps(uipc, world, slot, FRAMES):
            ms.append(taken)
            height.append(float(share @ at[:, 1]))
    return ms, height


def ours(command: str, asset: Path, voxels: int, tolerance: str) -> tuple[list[float], list[float], Row]:
    """The same of elastogen; the height of the centre of mass is its energy of gravity over its weight,
    which free fall by implicit Euler tells, and is counted from the first step."""
    with tempfile.TemporaryDirectory() as folder:
        log, report = Path(folder) / "log", Path(folder) / "report"
        subprocess.run([command, "animate", asset, "--size", str(LONGEST), "--up", "y", "--material", "jelly", "--analytic",
                        "--damping", "0", "--floor", f"auto=-{DROP}", "--friction", str(FRICTION), "--fps", "60",
                        "--frames", str(FRAMES), "--time-scheme", "euler", "--substeps", "1", "--solver", "newton",
                        "--tolerance", tolerance, "--voxels", str(voxels), "--device", "cuda", "--quiet",
                        "--mesh-error", "off", "--log-json", log, "--report", report, "-o", Path(folder) / "x.pc2"],
                       check=False)
        steps = [json.loads(line) for line in log.read_text().splitlines()]
        said = json.loads(report.read_text())
    energy = np.array([step["energies"]["gravity"] for step in steps])
    fallen = lambda k: GRAVITY * DT**2 * k * (k + 1) / 2  # noqa: E731
    weight = (energy[0] - energy[5]) / (fallen(6) - fallen(1))
    return [step["ms"] for step in steps], list(energy / weight), said | {
        "residual": max(step["residual"] for step in steps), "converged": sum(step["converged"] for step in steps)}


def row(name: str, cells: int, ms: list[float], height: list[float], finest: list[float], more: Row) -> Row:
    """Times in contact, and the error of the fall of the centre of mass since the first step."""
    touching = ms[TOUCHES:]
    of = {"run": name, "cells": cells, "median": float(np.median(touching)), "mean": float(np.mean(touching)),
          "p95": float(np.percentile(touching, 95)), "most": max(touching), "error": None, "height": height} | more
    off = ""
    if finest:
        error = (np.array(height) - height[0]) - (np.array(finest) - finest[0])
        of["error"] = float(np.abs(error).max())
        off = f", centre of mass off by {1e3 * of['error']:.2f} mm"
    print(f"{name}, {cells} cells: {of['median']:.1f} ms a step in contact (mean {of['mean']:.1f}, 95 % {of['p95']:.1f}, "
          f"most {of['most']:.1f}){off}", flush=True)
    return of


def main() -> int:
    """Runs the sizes, one code after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--asset", type=Path, required=True)
    parser.add_argument("--voxels", type=int, nargs="+", default=[40, 80, 118])
    parser.add_argument("--without-peer", action="store_true", help="elastogen alone")
    parser.add_argument("--most-tight", type=int, default=80, help="voxels up to which libuipc runs tight: it takes minutes")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    uipc: Any = None
    if not given.without_peer:
        try:
            import uipc  # type: ignore[no-redef]
        except ImportError as error:
            print(f"{error}: install pyuipc", file=sys.stderr)
            return 3
        uipc.Logger.set_level(uipc.Logger.Level.Warn)
    rows: list[Row] = []
    for voxels in given.voxels:
        runs = {tolerance: ours(given.command, given.asset, voxels, tolerance) for tolerance in ("1e-3", "1e-6")}
        for tolerance, (ms, height, said) in runs.items():
            rows.append(row(f"elastogen, {tolerance}", said["voxels"], ms, height, runs["1e-6"][1],
                            {key: said[key] for key in ("residual", "converged", "device", "commit")}))
        if uipc is not None:
            nodes, tets = tetrahedra(cells_of(triangles_of(given.asset), LONGEST / voxels), LONGEST / voxels)
            tights = (False, True) if voxels <= given.most_tight else (False,)
            of = {tight: libuipc(uipc, nodes, tets, tight) for tight in tights}
            for tight, (ms, height) in of.items():
                finest = of[True][1] if True in of else []
                rows.append(row("libuipc, tight" if tight else "libuipc", len(tets) // 5, ms, height, finest, {}))
        if given.json:
            given.json.write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
