# SPDX-License-Identifier: Apache-2.0
"""Rows C: classic problems with curved faces, on tetrahedra that fit them (classic_meshes.py).

Stresses are computed here from the displacements in the state file: at a node, of each element
around it, then averaged."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import h5py
import numpy as np

from ladder_row import Options, Row, each
from runs import Finished, Floats

STATIC = "simulate --static"
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # of the middles, in the order of VTK
CORNERS = np.concatenate([np.eye(4), [(np.eye(4)[a] + np.eye(4)[b]) / 2 for a, b in EDGES]])


def shape_gradients(barycentric: Floats) -> Floats:
    """dN_a/dxi of the quadratic tetrahedron at barycentric coordinates L, (10, 3)."""
    slope = np.concatenate([-np.ones((1, 3)), np.eye(3)])
    corners = (4 * barycentric[:, None] - 1) * slope
    middles = [4 * (barycentric[a] * slope[b] + barycentric[b] * slope[a]) for a, b in EDGES]
    return np.concatenate([corners, middles])


def hencky_stress(F: Floats, young: float, poisson: float) -> Floats:
    """Cauchy stress [Pa] of Hencky's law, (2 mu ln V + lambda tr(ln V) I)/J, (n, 3, 3)."""
    shear, lame = young / (2 * (1 + poisson)), young * poisson / (1 + poisson) / (1 - 2 * poisson)
    squares, axes = np.linalg.eigh(F @ F.transpose(0, 2, 1))
    logs = np.log(squares) / 2
    principal = (2 * shear * logs + lame * logs.sum(1)[:, None]) / np.exp(logs.sum(1))[:, None]
    return np.einsum("nik,nk,njk->nij", axes, principal, axes)


def stress_at(run: Finished, nodes: Sequence[int]) -> Floats:
    """Mean Cauchy stress [Pa] of some nodes, each the mean of its elements, (3, 3)."""
    tets, rest, u = run.state["grid/corners"], run.rest, run.u[-1]
    young, poisson = (float(run.state["materials"][name][0]) for name in ("young", "poisson"))
    means = []
    for node in nodes:
        elements, places = np.nonzero(tets == node)
        slopes = np.stack([shape_gradients(CORNERS[place]) for place in places])
        by_xi = [np.einsum("nai,naj->nij", field[tets[elements]], slopes) for field in (rest, u)]
        F = np.eye(3) + by_xi[1] @ np.linalg.inv(by_xi[0])
        means.append(hencky_stress(F, young, poisson).mean(0))
    return np.mean(means, 0)


def nodes_at(run: Finished, x: float, y: float, z: float | None = None) -> list[int]:
    """Nodes at a place [m], of all z where it is not given."""
    wanted = [x, y] if z is None else [x, y, z]
    apart = np.abs(run.rest[:, :len(wanted)] - wanted).max(1)
    return [int(node) for node in np.flatnonzero(apart < 1e-9)]


def lame(run: Finished) -> list[float]:
    """Inner displacement and hoop stress there over those of Lame's tube.

    a = 1, b = 2, p = 1, plane strain: u = (1 + nu)/E p a^2/(b^2 - a^2) ((1 - 2 nu) a + b^2/a).
    """
    inside = nodes_at(run, 1, 0)
    moved = float(run.u[-1][inside, 0].mean())
    return [moved / (1.3 / 1e6 / 3 * (0.4 + 4)), float(stress_at(run, inside)[1, 1]) / (5 / 3)]


def kirsch(run: Finished) -> float:
    """Stress of the hole's side along the pull, over the pull."""
    return float(stress_at(run, nodes_at(run, 0, 1))[0, 0])


def nafems_1(run: Finished) -> float:
    """Stress along y of D, mean over the thickness [MPa], under the whole load."""
    return float(stress_at(run, nodes_at(run, 2, 0))[1, 1]) * 1e3 / 1e6


def nafems_10(run: Finished) -> float:
    """Stress along y of D on the upper face [MPa], under the whole load."""
    return float(stress_at(run, nodes_at(run, 2, 0, 0.6))[1, 1]) * 1e3 / 1e6


def pressure_over_young(gap: Floats) -> Floats:
    """Pressure of the contact layer over E at a gap in units of the layer, -b'/4, 0 beyond 1."""
    s = np.minimum(gap, 1)
    return ((1 - s) ** 2 / s - 2 * (1 - s) * np.log(s)) / 4


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a rising function is 0, by bisection."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if function(middle) > 0 else (middle, high)
    return (low + high) / 2


def approach(force: float, layer: float, poisson: float = 0.3) -> float:
    """How far a plane comes towards the middle of a ball that two press, F over E, radius 1 [m].

    Hertz's d of F = 4/3 E* sqrt(R) d^1.5, less what the force on the other pole moves this one by,
    a point load's F (1 + nu)(3 - 2 nu)/(4 pi E R) at the depth 2 R (Boussinesq; Tatara 1991), more
    what the layer gives, to first order: by reciprocity its mean with the weight 1/sqrt(a^2 - r^2)
    of a flat punch, 2/3 of that in the middle, as it goes with the root of Hertz's pressure.
    """
    radius = (3 * force * (1 - poisson**2) / 4) ** (1 / 3)
    middle = 1.5 * force / (np.pi * radius**2)
    gap = root(lambda s: middle - float(pressure_over_young(np.array(s))), 1e-6, 1)
    other = force * (1 + poisson) * (3 - 2 * poisson) / (4 * np.pi)
    return radius**2 - other + 2 / 3 * layer * (1 - gap)


def hertz(run: Finished) -> list[float]:
    """Force on the plane at each step, over that at which the ball's approach is the plane's."""
    with h5py.File(run.folder / "state.h5") as file:
        layer = float(file["contact"].attrs["layer"])
    ratios = []
    for x, moved in zip(run.state["steps/x"][1:], run.state["contact/offset"][1:, 0, 1]):
        gap = (1 + moved + layer - x[run.state["contact/nodes"], 1]) / layer
        force = 4 * float(run.state["contact/area"] @ pressure_over_young(gap))  # over E; quarters
        wanted = root(lambda F: approach(F, layer) + float(moved), 0, 1)
        ratios.append(force / wanted)
    return ratios


def on(body: str, *sizes: int) -> list[Options]:
    """A sweep over bodies of classic_meshes.py."""
    return [(f"mesh:{body}-{n}",) for n in sizes]


def orders(runs: Sequence[Finished]) -> list[float]:
    """log2 of the ratios of the errors of Lame's inner displacement."""
    errors = [lame(run)[0] - 1 for run in runs]
    return [float(np.log2(coarse / fine)) for coarse, fine in zip(errors, errors[1:])]


# finite width: a hole of diameter d across a plate W wide, K = (2 + (1 - d/W)^3)/(1 - d/W)
HEYWOOD = (2 + 0.98**3) / 0.98
CLASSICS = [
    Row("C1", "Lame's tube, radii 1 and 2, pressed inside, plane strain", "tube", STATIC,
        on("tube", 4, 8), lambda runs: [value for run in runs for value in lame(run)],
        "inner displacement, hoop stress there, over the closed form, 4 8 cells around a quarter",
        (1,) * 4, "Lame 1852", 0.002, short=True),
    Row("C1", "the same: order in h, 8 16 32 cells", "tube", STATIC, on("tube", 8, 16, 32), orders,
        "log2 of the ratios of the displacement's errors", (3, 3),
        "third order of quadratic shape functions", 0.35),
    Row("C2", "Kirsch's hole in a plate 50 times as wide, pulled", "holed", STATIC,
        on("holed", 8, 16), each(kirsch),
        "stress on the hole's side over the pull, 8 16 cells around a quarter", (HEYWOOD,) * 2,
        "Kirsch 1898, width by Heywood 1952", 0.005, True, short=True),
    Row("C3", "NAFEMS LE1, elliptic membrane", "membrane", STATIC, on("membrane", 24, 40),
        each(nafems_1), "stress along y at D [MPa], 24 40 cells around a quarter", (92.7,) * 2,
        "The Standard NAFEMS Benchmarks 1990", 0.01, True, short=True),
    Row("C4", "NAFEMS LE10, thick plate", "plate", STATIC, on("plate", 8, 16), each(nafems_10),
        "stress along y at D [MPa], 8 16 cells around a quarter", (-5.38,) * 2,
        "The Standard NAFEMS Benchmarks 1990", 0.01, True, short=True),
    Row("C5", "Hertz: ball between planes, 8 cells along the radius", "ball", "simulate",
        on("ball", 8), lambda runs: hertz(runs[0]),
        "force over Hertz's of the ball and the layer, approach 0.02 0.03 0.04 R", (1,) * 3,
        "Hertz 1882, the other pole by Boussinesq, the layer to first order", 0.04, short=True),
    Row("C5", "Hertz: ball between planes, 12 cells along the radius", "ball", "simulate",
        on("ball", 12), lambda runs: hertz(runs[0]),
        "force over Hertz's of the ball and the layer, approach 0.02 0.03 0.04 R", (1,) * 3,
        "Hertz 1882, the other pole by Boussinesq, the layer to first order", 0.01),
]
