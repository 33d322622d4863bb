#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The scene c84 of `elastogen bench` in Newton's VBD (newton on PyPI): time of a frame, and the tip.

    python bench/peers/newton_vbd_c84.py --sizes 3.2e4,2.56e5 --json FILE

The beam of `libuipc_c84.py`, cut into the same tetrahedra. A frame of 1/30 s is `--substeps` implicit
Euler steps, each of `--iterations` sweeps of vertex block descent over four colours of nodes; no
contact, no damping, single precision. The law is the stable neo-Hookean one without its logarithm,
mu/2 (I - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2, which takes Lame's constants. On a card a frame
is one CUDA graph; one frame goes before, then the beam starts from rest again."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
from c84_mesh import (
    DENSITY, DT, FRAMES, GRAVITY, POISSON, YOUNG, arguments, colours, lattice, outcome, tip_of)

# of newton/examples/softbody/example_softbody_hanging.py, the one example of a held soft body, whose
# frames are of 1/60 s and which turns `particle_enable_tile_solve` (here --tile) off
SUBSTEPS, ITERATIONS = 10, 10


def make_model(newton, device: str, size: float):  # noqa: ANN001, ANN201
    """The model, its nodes and the number of cells."""
    nodes, tets, cells = lattice(size)
    edges = np.swapaxes(nodes[tets[:, 1:]] - nodes[tets[:, :1]], 1, 2)
    mass = np.bincount(tets.ravel(), np.repeat(DENSITY * np.linalg.det(edges) / 24, 4))
    mass[nodes[:, 0] < 1e-9] = 0  # a node without mass is held
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY))
    builder.add_particles(nodes.tolist(), np.zeros_like(nodes).tolist(), mass.tolist())
    # the arrays that add_soft_mesh fills in a loop over the tetrahedra, without triangles of the
    # surface: they carry contact and nothing else
    lame = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    builder.tet_indices = tets
    builder.tet_poses = np.linalg.inv(edges).astype(np.float32)
    builder.tet_activations = np.zeros(len(tets), np.float32)
    builder.tet_materials = np.tile(np.array([*lame, 0.0], np.float32), (len(tets), 1))
    colour = colours(size)
    builder.set_coloring([np.flatnonzero(colour == c) for c in range(4)])
    return builder.finalize(device=device), nodes, cells


def run(newton, wp, size: float, given: argparse.Namespace) -> dict:  # noqa: ANN001
    """Milliseconds of the frames and the way of the tip [m]."""
    begin = time.perf_counter()
    model, nodes, cells = make_model(newton, given.device, size)
    solver = newton.solvers.SolverVBD(model, iterations=given.iterations,
                                      particle_enable_self_contact=False,
                                      particle_enable_tile_solve=given.tile)
    control = model.control()
    states = [model.state(), model.state()]

    def frame() -> None:
        for _ in range(given.substeps):
            solver.step(states[0], states[1], control, None, DT / given.substeps)
            states.reverse()
        if given.substeps % 2:  # a graph has to find its beginning where it was
            states[1].assign(states[0])
            states.reverse()

    frame()  # compiles
    rest = model.state()
    for state in states:
        state.assign(rest)
    advance = frame
    if model.device.is_cuda:
        with wp.ScopedCapture(device=model.device) as capture:
            frame()

        def advance() -> None:
            wp.capture_launch(capture.graph)
    wp.synchronize_device(model.device)
    setup = time.perf_counter() - begin
    tip = tip_of(nodes)
    ms, way = [], []
    for _ in range(FRAMES):
        begin = time.perf_counter()
        advance()
        wp.synchronize_device(model.device)
        ms.append(1e3 * (time.perf_counter() - begin))
        way.append(float((states[0].particle_q.numpy()[tip, 2] - nodes[tip, 2]).mean()))
    tiles = " in tiles" if given.tile else ""
    name = f"Newton VBD {given.substeps} x {given.iterations}{tiles}"
    return outcome(name, cells, setup, ms, way)


def main() -> int:
    """Runs the sizes."""
    options = arguments(__doc__)
    options.add_argument("--substeps", type=int, default=SUBSTEPS, help="of a frame")
    options.add_argument("--iterations", type=int, default=ITERATIONS, help="sweeps of a substep")
    options.add_argument("--tile", action="store_true", help="sixteen threads a node, on a card")
    options.add_argument("--device", default="cuda", help="cuda, or cpu (small sizes)")
    given = options.parse_args()
    # newton.py beside this file is another one
    here = Path(__file__).resolve().parent
    sys.path[:] = [folder for folder in sys.path if Path(folder).resolve() != here]
    try:
        import newton
        import warp as wp
    except ImportError as error:
        print(f"{error}: install newton and warp-lang", file=sys.stderr)
        return 3
    wp.config.log_level = wp.LOG_WARNING
    if given.device.startswith("cuda") and not wp.is_cuda_available():
        print("no card: --device cpu", file=sys.stderr)
        return 3
    rows = [run(newton, wp, float(size), given) for size in given.sizes.split(",")]
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
