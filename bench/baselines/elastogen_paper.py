#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A step of the published algorithm (ElastoGen, AAAI 2026) in PyTorch, on dense grids of tensors.

    elastogen_paper.py SCENE --out FOLDER [--mode eager|compile|graph|numpy] [--svd library|jacobi]

RNN-1 freezes the lagged quadratic of every voxel `outer` times a step, RNN-2 relaxes A x = b,

    A = m/dt^2 + sum_v omega G^T (N N^T) G + variance term,      omega = E,

by cosine modes and `inner` Jacobi sweeps; it is the algorithm of `elastogen animate --solver paper`.
It is kinder than the paper: the variance term keeps the sweeps from diverging, and the stretches n are
fitted to the energy of the law itself, without evaluating a network.

SCENE is a folder that `elastogen bench baseline` writes: scene.json (dims [nx, ny, nz] voxels, h [m],
dt [s], young [Pa], poisson, density [kg/m^3], gravity [m/s^2], outer, inner, modes), solid.u8 (1 where
there is a voxel), pinned.u8 (nodes), u.f64 and v.f64 (displacement [m] and velocity [m/s] of each
node), x the fastest index. FOLDER gets u.f64 and v.f64 after the steps and result.json. Exit code 3:
a library is missing."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from pathlib import Path
from typing import Any

try:
    import numpy as np
except ImportError as missing:
    print(f"{sys.executable}: {missing}", file=sys.stderr)
    sys.exit(3)

from dense_grid import Array, Backend, node_sum, patterns, transposed  # noqa: E402
from local_step import fitted_stretches, jacobi_svd, library_svd  # noqa: E402


class Step:
    """One time step of a scene."""

    def __init__(self, scene: dict[str, Any], folder: Path, backend: Backend, svd: str) -> None:
        self.backend, self.xp, self.scene = backend, backend.xp, scene
        self.svd = library_svd if svd == "library" else jacobi_svd
        nx, ny, nz = scene["dims"]
        self.voxels, self.nodes = (nz, ny, nx), (nz + 1, ny + 1, nx + 1)
        self.h, self.dt, self.omega = scene["h"], scene["dt"], scene["young"]
        mu = self.omega / (2 * (1 + scene["poisson"]))
        self.c_h = (mu + self.omega / 2) / 2
        solid = np.fromfile(folder / "solid.u8", np.uint8).reshape(self.voxels)
        pinned = np.fromfile(folder / "pinned.u8", np.uint8).reshape(self.nodes)
        self.solid = backend.array(solid)
        mass = node_sum(backend, self.solid * (scene["density"] * self.h**3 / 8))
        free = (pinned == 0) & (backend.numpy(mass) > 0)
        self.free = backend.array(free)
        self.inertia = mass / self.dt**2
        self.gravity = backend.array(np.array(scene["gravity"]).reshape(3, 1, 1, 1))
        self.modes = self.make_modes(pinned) if scene["modes"] > 0 else None

    def field(self, path: Path) -> Array:
        """A vector a node of a file."""
        values = np.fromfile(path, np.float64).reshape(*self.nodes, 3)
        return self.backend.array(np.moveaxis(values, -1, 0))

    def make_modes(self, pinned: np.ndarray) -> Array:
        """Cosines of lowest frequency times d/(d + L/8), d the distance to the nearest pinned node."""
        count = self.scene["modes"] // 3
        lengths = np.array(self.scene["dims"]) * self.h
        waves = sorted((sum((k / L) ** 2 for k, L in zip(wave, lengths)), wave)
                       for wave in np.ndindex(count, count, count)
                       if (wave[0] + 1) * (wave[1] + 1) * (wave[2] + 1) <= count)[:count]
        axes = [np.arange(n) / max(1, n - 1) for n in reversed(self.nodes)]  # 0 ... 1 along x, y, z
        distance = self.pin_distance(pinned)
        factor = self.backend.numpy(self.free) * distance / (distance + lengths.max() / 8)
        modes = [factor * np.cos(np.pi * k[2] * axes[2])[:, None, None]
                 * np.cos(np.pi * k[1] * axes[1])[:, None] * np.cos(np.pi * k[0] * axes[0])
                 for _, k in waves]
        return self.backend.array(np.stack(modes))

    def pin_distance(self, pinned: np.ndarray) -> np.ndarray:
        """Distance of each node to the nearest pinned one [m], as the crow flies."""
        ones = np.argwhere(pinned)
        result = np.full(self.nodes, 1e30)
        if len(ones) * self.nodes[2] == pinned.size and np.ptp(ones[:, 2]) == 0:  # a plane, fast
            result[:] = self.h * np.abs(np.arange(self.nodes[2]) - ones[0, 2])
        elif len(ones) > 0:
            index, flat = np.indices(self.nodes).reshape(3, -1).T, result.reshape(-1)
            for k, place in enumerate(index):
                flat[k] = self.h * math.sqrt(((ones - place) ** 2).sum(1).min())
        return result

    def product(self, field: Array, NN: list[list[Array]]) -> Array:
        """A x without the mask of free nodes."""
        gradient, (xy, yz, zx, xyz) = patterns(field)
        weight = self.solid * (self.omega * self.h / 16)
        stress = [weight * sum(gradient[k] * NN[k][j] for k in range(3)) for j in range(3)]
        hold = self.solid * (self.c_h * self.h / 24)
        rest = (hold * xy, hold * yz, hold * zx, hold / 2 * xyz)
        return transposed(self.backend, tuple(stress), rest) + self.inertia * field

    def image(self, field: Array, NN: list[list[Array]]) -> Array:
        """A x, 0 on pinned nodes."""
        return self.free * self.product(field, NN)

    def freeze(self, u: Array, predictor: Array) -> tuple[list[list[Array]], Array, Array]:
        """N N^T of every voxel at u, the right-hand side b and the majorised diagonal D."""
        xp, h = self.xp, self.h
        gradient, _ = patterns(u)
        H = [[gradient[j][i] / (4 * h) for j in range(3)] for i in range(3)]
        NN, RN, slope = self.svd(
            xp, H, lambda sigma: fitted_stretches(xp, sigma, self.omega, self.scene["poisson"]))
        weight = self.solid * (self.omega * h / 16 * 4 * h)
        target = tuple(weight * xp.stack([RN[i][j] - NN[i][j] for i in range(3)]) for j in range(3))
        none = 0 * target[0]
        b = transposed(self.backend, target, (none, none, none, none)) + self.inertia * predictor
        kappa = self.c_h / self.omega
        share = self.solid * (self.omega * h) * (
            3 / 16 * slope + 7 / 48 * xp.clip(slope, kappa, None))
        diagonal = self.inertia + node_sum(self.backend, share)
        inverse = self.free / xp.where(self.free > 0, diagonal, 1 + 0 * diagonal)
        return NN, b, inverse

    def project(self, u: Array, NN: list[list[Array]], b: Array) -> Array:
        """Galerkin step over the modes: one matrix for x, y and z."""
        xp, B = self.xp, self.modes
        waves = B.shape[0]
        flat = B.reshape(waves, -1)
        right = flat @ (self.free * b - self.image(u, NN)).reshape(3, -1).T
        columns = []
        for first in range(0, waves, 3):  # three modes stand in for the three components
            image = self.image(B[first:first + 3], NN)
            columns.append(flat @ image.reshape(image.shape[0], -1).T)
        A = self.backend.double(xp.concatenate(columns, 1))
        A = A + 1e-12 / waves * (A * self.identity(A)).sum() * self.identity(A)
        y = self.backend.like(xp.linalg.solve(A, self.backend.double(right)), u)
        return u + (y.T @ flat).reshape(u.shape)

    def identity(self, A: Array) -> Array:
        """Of the size of A."""
        if self.backend.torch is None:
            return np.eye(len(A))
        return self.xp.eye(len(A), dtype=A.dtype, device=A.device)

    def relax(self, u: Array, NN: list[list[Array]], b: Array, inverse: Array) -> Array:
        """Jacobi sweeps."""
        for _ in range(self.scene["inner"]):
            u = self.sweep(u, NN, b, inverse)
        return u

    def sweep(self, u: Array, NN: list[list[Array]], b: Array, inverse: Array) -> Array:
        """x + D^-1 (b - A x)"""
        return u + inverse * (b - self.product(u, NN))

    def __call__(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Displacement and velocity after dt."""
        predictor = u + self.free * (self.dt * v + self.dt**2 * self.gravity)
        x = predictor
        for _ in range(self.scene["outer"]):
            NN, b, inverse = self.freeze(x, predictor)
            if self.modes is not None:
                x = self.project(x, NN, b)
            x = self.relax(x, NN, b, inverse)
        return x, (x - u) / self.dt


class GraphRelax:
    """The sweeps of a loop as one CUDA graph on buffers of its own."""

    def __init__(self, step: Step) -> None:
        self.step, self.graph = step, None

    def capture(self, inputs: list[Array]) -> None:
        """Records the sweeps."""
        torch = self.step.xp
        self.inputs = [x.clone() for x in inputs]
        stream = torch.cuda.Stream()
        stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(stream):
            self.run()
        torch.cuda.current_stream().wait_stream(stream)
        self.graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(self.graph):
            self.output = self.run()

    def run(self) -> Array:
        """The sweeps on the buffers."""
        u, b, inverse, *entries = self.inputs
        return Step.relax(self.step, u, [entries[0:3], entries[3:6], entries[6:9]], b, inverse)

    def __call__(self, u: Array, NN: list[list[Array]], b: Array, inverse: Array) -> Array:
        inputs = [u, b, inverse, *NN[0], *NN[1], *NN[2]]
        if self.graph is None:
            self.capture(inputs)
        for buffer, value in zip(self.inputs, inputs):
            buffer.copy_(value)
        self.graph.replay()
        return self.output.clone()


def build(scene: dict[str, Any], folder: Path, backend: Backend, mode: str, svd: str) -> Step:
    """The step in one of the modes."""
    step = Step(scene, folder, backend, svd)
    if mode in ("compile", "graph"):
        step.sweep = backend.torch.compile(step.sweep, dynamic=False)
        step.image = backend.torch.compile(step.image, dynamic=False)
        if svd == "jacobi":
            step.freeze = backend.torch.compile(step.freeze, dynamic=False)
    if mode == "graph":
        step.relax = GraphRelax(step)
    return step


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Steps and times; writes the state."""
    scene = json.loads((arguments.scene / "scene.json").read_text())
    backend = Backend(arguments.mode, arguments.device, arguments.dtype)
    began = time.perf_counter()
    step = build(scene, arguments.scene, backend, arguments.mode, arguments.svd)
    start = [step.field(arguments.scene / name) for name in ("u.f64", "v.f64")]
    state = start
    for _ in range(arguments.steps):
        state = step(*state)
    backend.wait()
    setup = time.perf_counter() - began
    times = []
    for _ in range(arguments.repeat):  # the last step is timed, from the state before it
        state = start
        for _ in range(arguments.steps):
            backend.wait()
            begin = time.perf_counter()
            state = step(*state)
            backend.wait()
        times.append(1e3 * (time.perf_counter() - begin))
    for name, values in zip(("u.f64", "v.f64"), state):
        np.moveaxis(backend.numpy(values), 0, -1).tofile(arguments.out / name)
    peak = backend.torch.cuda.max_memory_allocated() if backend.device == "cuda" else None
    card = backend.torch.cuda.get_device_name() if backend.device == "cuda" else None
    return {"mode": arguments.mode, "svd": arguments.svd, "dtype": arguments.dtype, "card": card,
            "device": backend.device, "ms": times, "setup_seconds": setup, "peak_bytes": peak,
            "torch": None if backend.torch is None else backend.torch.__version__}


def main() -> int:
    """Reads the scene, writes state and times."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("scene", type=Path)
    options.add_argument("--out", type=Path, required=True)
    options.add_argument("--mode", choices=("eager", "compile", "graph", "numpy"), default="eager")
    options.add_argument("--svd", choices=("library", "jacobi"), default="library")
    options.add_argument("--device", choices=("auto", "cpu", "cuda"), default="auto")
    options.add_argument("--dtype", choices=("float32", "float64"), default="float32")
    options.add_argument("--steps", type=int, default=1)
    options.add_argument("--repeat", type=int, default=5)
    arguments = options.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    try:
        if arguments.mode == "numpy":
            result = run(arguments)
        else:
            import torch
            with torch.no_grad():
                result = run(arguments)
    except ImportError as error:
        print(f"{sys.executable}: {error}", file=sys.stderr)
        return 3
    (arguments.out / "result.json").write_text(json.dumps(result, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
