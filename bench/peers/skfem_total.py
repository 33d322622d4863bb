# SPDX-License-Identifier: Apache-2.0
"""The bar of bench/total_error.py that swings, by scikit-fem and implicit Euler: total error against the same truth.

usage: skfem_total.py TRUTH.npy [--json FILE]

TRUTH.npy has the vertices of all frames, as `bench/total_error.py --truths FOLDER` keeps them. Steps of implicit
Euler, each solved to 1e-6, on hexahedra, trilinear with lumped masses and triquadratic with the consistent one; the
vertices move with them. Time is that of the processor in the solves alone."""

from __future__ import annotations

import argparse
import json
import sys
from itertools import product
from pathlib import Path

import numpy as np

from newton import Floats, minimise
from scene_file import Material
from skfem_body import Body, box_mesh
from skfem_solve import Seconds, euler_step

BOX, FPS, GRAVITY, TOLERANCE = (0.4, 0.08, 0.08), 30, np.array([0, -9.81, 0]), 1e-6
RUNS = (("hex", (10, 2, 2), 1), ("hex", (10, 2, 2), 4), ("hex", (20, 4, 4), 1), ("hex", (20, 4, 4), 4),
        ("hex27", (10, 2, 2), 1), ("hex27", (10, 2, 2), 4), ("hex27", (10, 2, 2), 16))  # element, cells, steps a frame


def shape(order: int, node: int, t: Floats) -> Floats:
    """Lagrange's polynomial of a node of 0 ... order, which lie evenly in 0 ... 1."""
    others = [k for k in range(order + 1) if k != node]
    return np.prod([(order * t - k) / (node - k) for k in others], axis=0)


def carried(body: Body, cells: tuple[int, int, int], order: int, points: Floats) -> tuple[np.ndarray, Floats]:
    """Nodes that carry each point, of its cell, and their weights."""
    edge = np.array(BOX) / cells
    number = {tuple(place): n for n, place in enumerate(np.rint(order * body.rest / edge).astype(int).tolist())}
    cell = np.clip(np.floor(points / edge).astype(int), 0, np.array(cells) - 1)
    t = points / edge - cell
    nodes, weights = [], []
    for local in product(range(order + 1), repeat=3):
        nodes.append([number[tuple(place)] for place in (order * cell + local).tolist()])
        weights.append(np.prod([shape(order, local[d], t[:, d]) for d in range(3)], axis=0))
    return np.array(nodes).T, np.array(weights).T


def play(body: Body, steps: int, frames: int, mass: str) -> tuple[list[Floats], Seconds]:
    """Displacements at the frames, and the time of the solves."""
    dt, M = 1 / FPS / steps, body.mass(mass)
    free = np.ones((body.nodes, 3), bool)
    free[body.face_nodes("x_min")] = False
    u, v, kept, total = np.zeros((body.nodes, 3)), np.zeros((body.nodes, 3)), [], Seconds(0, 0)
    kept.append(u)
    for step in range(1, steps * frames + 1):
        start = Seconds.now()
        potential = euler_step(body, M, dt, u + dt * v + dt * dt * GRAVITY, free)
        ahead = np.where(free, u + dt * v, 0.0)
        end, report = minimise(potential, ahead if np.isfinite(body.energy(ahead)) else u, TOLERANCE)
        if not report.converged:
            sys.exit(f"step {step}: residual {report.residual:.1e}")
        u, v = end, (end - u) / dt
        took = Seconds.now().since(start)
        total = Seconds(total.wall + took.wall, total.cpu + took.cpu)
        if step % steps == 0:
            kept.append(u)
    return kept, total


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("truth", type=Path)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    truth = np.load(given.truth)
    motion = float(np.sqrt(((truth - truth[0]) ** 2).sum(2).mean(1)).max())
    rows = []
    for element, cells, steps in RUNS:
        quadratic = element == "hex27"
        body = Body(box_mesh(BOX, cells, element), element, Material("neo-hookean", 1e5, 0.4, 1000.0))
        nodes, weights = carried(body, cells, 1 + quadratic, truth[0])
        kept, total = play(body, steps, len(truth) - 1, "consistent" if quadratic else "lumped")
        moved = np.array([np.einsum("pc,pcd->pd", weights, u[nodes]) for u in kept])
        error = float(np.sqrt(((truth[0] + moved - truth) ** 2).sum(2).mean())) / motion
        rows.append({"element": element, "cells": list(cells), "steps_a_frame": steps, "error": error, "seconds": total.cpu})
        print(rows[-1], flush=True)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
