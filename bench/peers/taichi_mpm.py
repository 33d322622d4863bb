#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Explicit MLS-MPM of sand by Taichi (pip install taichi) on the CPU beside `elastogen bench particles`.

    bench/peers/taichi_mpm.py --elastogen build/cpu/elastogen --json bench/peers/results/taichi_mpm.json

Both step the same cube: eight particles a cell in the mean at random places, Hencky's elasticity with
Drucker and Prager's cone, APIC, the ground sticky, one transfer each 7e-5 s. Taichi scatters with
atomics, in the order of its threads; its grid is dense. Times are medians of steps after one that
warms up; both programs use the same number of threads."""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import taichi as ti

H, DT, DENSITY, YOUNG, POISSON, FRICTION = 0.01, 7e-5, 1000.0, 1e6, 0.35, math.radians(30)
MARGIN = 3  # cells of the grid around the cube


@ti.data_oriented
class Sand:
    def __init__(self, count: int, real: Any) -> None:
        edge = H * (count / 8) ** (1 / 3)
        self.count, self.real = count, real
        self.cells = int(math.ceil(edge / H)) + 2 * MARGIN
        self.mass = DENSITY * edge ** 3 / count
        self.volume = edge ** 3 / count
        self.mu = YOUNG / (2 * (1 + POISSON))
        self.lam = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
        sine = math.sin(FRICTION)
        self.alpha = math.sqrt(2 / 3) * 2 * sine / (3 - sine)
        self.x = ti.Vector.field(3, real, count)
        self.v = ti.Vector.field(3, real, count)
        self.C = ti.Matrix.field(3, 3, real, count)
        self.F = ti.Matrix.field(3, 3, real, count)
        self.grid_v = ti.Vector.field(3, real, (self.cells,) * 3)
        self.grid_m = ti.field(real, (self.cells,) * 3)
        numbers = np.float32 if real == ti.f32 else np.float64
        self.x.from_numpy((np.random.default_rng(1).random((count, 3)) * edge
                           + MARGIN * H).astype(numbers))
        self.F.from_numpy(np.broadcast_to(np.eye(3, dtype=numbers), (count, 3, 3)).copy())

    @ti.func
    def weights(self, x):
        base = ti.floor(x / H - 0.5).cast(int)
        t = x / H - base.cast(self.real)
        w = [0.5 * (1.5 - t) ** 2, 0.75 - (t - 1) ** 2, 0.5 * (t - 0.5) ** 2]
        return base, t, w

    @ti.func
    def flow(self, F):
        """Elastic part of the trial and Kirchhoff's stress."""
        U, S, V = ti.svd(F)
        e = ti.Vector([ti.log(ti.max(S[0, 0], 1e-4)), ti.log(ti.max(S[1, 1], 1e-4)),
                       ti.log(ti.max(S[2, 2], 1e-4))])
        trace = e.sum()
        deviator = e - trace / 3
        size = deviator.norm()
        if trace >= 0 or size == 0:
            e = ti.Vector.zero(self.real, 3)
        else:
            excess = size + (3 * self.lam + 2 * self.mu) / (2 * self.mu) * trace * self.alpha
            if excess > 0:
                e -= deviator * (excess / size)
        tau = 2 * self.mu * e + self.lam * e.sum()
        elastic, stress = ti.Matrix.zero(self.real, 3, 3), ti.Matrix.zero(self.real, 3, 3)
        for k in ti.static(range(3)):
            elastic[k, k], stress[k, k] = ti.exp(e[k]), tau[k]
        return U @ elastic @ V.transpose(), U @ stress @ U.transpose()

    @ti.kernel
    def step(self):
        for i in ti.grouped(self.grid_m):
            self.grid_v[i], self.grid_m[i] = ti.Vector.zero(self.real, 3), 0
        for p in self.x:
            base, t, w = self.weights(self.x[p])
            F = (ti.Matrix.identity(self.real, 3) + DT * self.C[p]) @ self.F[p]
            self.F[p], stress = self.flow(F)
            affine = self.mass * self.C[p] - DT * self.volume * 4 / H ** 2 * stress
            for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
                away = (ti.Vector([i, j, k]) - t) * H
                weight = w[i][0] * w[j][1] * w[k][2]
                at = base + ti.Vector([i, j, k])
                self.grid_v[at] += weight * (self.mass * self.v[p] + affine @ away)
                self.grid_m[at] += weight * self.mass
        for i in ti.grouped(self.grid_m):
            if self.grid_m[i] > 0:
                self.grid_v[i] /= self.grid_m[i]
                self.grid_v[i][1] -= DT * 9.81
                if i[1] <= MARGIN:
                    self.grid_v[i] = ti.Vector.zero(self.real, 3)
        for p in self.x:
            base, t, w = self.weights(self.x[p])
            v, C = ti.Vector.zero(self.real, 3), ti.Matrix.zero(self.real, 3, 3)
            for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
                away = (ti.Vector([i, j, k]) - t) * H
                own = w[i][0] * w[j][1] * w[k][2] * self.grid_v[base + ti.Vector([i, j, k])]
                v += own
                C += 4 / H ** 2 * own.outer_product(away)
            self.v[p], self.C[p] = v, C
            self.x[p] += DT * v


def taichi_row(count: int, threads: int, real: Any, steps: int) -> dict[str, Any]:
    ti.init(arch=ti.cpu, cpu_max_num_threads=threads, default_fp=real, log_level=ti.WARN)
    sand = Sand(count, real)
    sand.step()
    ti.sync()
    times = []
    for _ in range(steps):
        begin = time.perf_counter()
        sand.step()
        ti.sync()
        times.append(1e3 * (time.perf_counter() - begin))
    x, mass = sand.x.to_numpy(), sand.grid_m.to_numpy().sum()
    assert np.isfinite(x).all() and abs(mass / (sand.mass * count) - 1) < 1e-3
    return {"program": f"taichi {ti.__version__[0]}.{ti.__version__[1]}.{ti.__version__[2]}",
            "numbers": "float" if real == ti.f32 else "double", "particles": count,
            "threads": threads, "ms": float(np.median(times)),
            "updates_per_second": 1e3 * count / float(np.median(times))}


def own_rows(program: str, sizes: list[int]) -> list[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "bench.json"
        subprocess.run([program, "bench", "particles", "--sizes", ",".join(map(str, sizes)),
                        "--integrators", "explicit", "--json", str(out)], check=True)
        result = json.loads(out.read_text())
    return [{"program": f"elastogen {result['commit']}", "numbers": "double"}
            | {k: row[k] for k in ("particles", "threads", "ms", "updates_per_second")}
            for row in result["particles"]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--elastogen", required=True)
    parser.add_argument("--sizes", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows = own_rows(args.elastogen, args.sizes)
    for threads in sorted({row["threads"] for row in rows}):
        for count in args.sizes:
            for real in (ti.f32, ti.f64):
                rows.append(taichi_row(count, threads, real, args.steps))
    for row in sorted(rows, key=lambda r: (r["particles"], r["threads"])):
        print(f"{row['program']:24} {row['numbers']:6} {row['particles']:8} particles, "
              f"{row['threads']} threads: {row['ms']:9.2f} ms, "
              f"{1e-6 * row['updates_per_second']:6.2f} million updates/s")
    if args.json:
        args.json.write_text(json.dumps({"rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
