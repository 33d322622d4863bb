#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The scene c84 of `elastogen bench` in libuipc (pyuipc on PyPI): time of a frame, and the tip.

    python bench/peers/libuipc_c84.py --sizes 3.2e4,2.56e5 --json FILE

A cantilever of 1 x 0.25 x 0.25 m, E 1e5 Pa, nu 0.4, 1000 kg/m^3, held at x = 0, falls from rest
under 9.81 m/s^2; one implicit Euler step of 1/30 s a frame, 24 frames, no contact. Each cell of the
lattice is cut into five tetrahedra, mirrored from cell to cell. `--tight` asks for a hundredth of
the library's tolerances. Of its elastic solids the nearest to log neo-Hookean is its stable neo-Hookean
law, which takes Young's modulus and Poisson's ratio through Lame's constants."""

from __future__ import annotations

import json
import sys
import tempfile
import time

import numpy as np
from c84_mesh import (
    DENSITY, DT, FRAMES, GRAVITY, POISSON, YOUNG, arguments, lattice, outcome, tip_of)
from libuipc_steps import steps, tighten


def make_scene(uipc, nodes: np.ndarray, tets: np.ndarray, tight: bool):  # noqa: ANN001, ANN201
    """The scene and the slot of its geometry."""
    from uipc.constitution import ElasticModuli, StableNeoHookean
    from uipc.geometry import label_surface, tetmesh
    config = uipc.Scene.default_config()
    config["dt"] = DT
    config["gravity"] = [[0.0], [0.0], [-GRAVITY]]
    config["contact"]["enable"] = 0
    config["sanity_check"]["enable"] = 0
    if tight:
        tighten(config)
    scene = uipc.Scene(config)
    body = tetmesh(nodes, tets)
    label_surface(body)
    StableNeoHookean().apply_to(body, ElasticModuli.youngs_poisson(YOUNG, POISSON), DENSITY)
    held = uipc.view(body.vertices().find(uipc.builtin.is_fixed))
    held[:] = nodes[:, 0] < 1e-9
    slot, _ = scene.objects().create("beam").geometries().create(body)
    return scene, slot


def run(uipc, size: float, tight: bool, backend: str) -> dict:  # noqa: ANN001
    """Milliseconds of the frames and the way of the tip [m]."""
    nodes, tets, cells = lattice(size)
    scene, slot = make_scene(uipc, nodes, tets, tight)
    tip = tip_of(nodes)
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        engine = uipc.Engine(backend, folder)  # the world does not keep it
        world = uipc.World(engine)
        world.init(scene)
        setup = time.perf_counter() - begin
        ms, way = [], []
        for taken, places in steps(uipc, world, slot, FRAMES):
            ms.append(taken)
            way.append(float((places[tip, 2] - nodes[tip, 2]).mean()))
    return outcome("libuipc, tight" if tight else "libuipc", cells, setup, ms, way)


def main() -> int:
    """Runs the sizes."""
    options = arguments(__doc__)
    options.add_argument("--tight", action="store_true")
    options.add_argument("--backend", default="cuda", help="cuda, or none (nothing moves)")
    given = options.parse_args()
    try:
        import uipc
    except ImportError as error:
        print(f"{error}: install pyuipc", file=sys.stderr)
        return 3
    uipc.Logger.set_level(uipc.Logger.Level.Warn)
    rows = [run(uipc, float(size), given.tight, given.backend)
            for size in given.sizes.split(",")]
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
