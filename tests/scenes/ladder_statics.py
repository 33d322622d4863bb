# SPDX-License-Identifier: Apache-2.0
"""Rows of statics: bending, sheets, large deflections, bars, twist; by `simulate --static`, some by
`animate` in steps of 100 s, in which inertia is nothing.

The cantilever is 1 m long, t = 0.1 m thick, E = 1e8 Pa, rho = 1000 kg/m^3, n voxels thick."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace

import h5py
import numpy as np

from ladder_row import HERE, POISSON, Options, Row, each, on_plane, plane_mean, poissons
from runs import Finished

sys.path.insert(0, str(HERE.parent / "python"))
import equations  # noqa: E402
from state_file import read_state  # noqa: E402

YOUNG, DENSITY, THICK, PULL = 1e8, 1000.0, 0.1, 0.00981
STATIC = "simulate --static"
LONG = ("--gravity", "0,-0.981,0", "--fps", "0.01", "--time-scheme", "euler", "--frames", "4",
        "--substeps", "1", "--tolerance", "1e-6")
SOLIDS = "tables of four elements in linear theory, computed apart from this program"


def poisson_of(run: Finished) -> float:
    """Of the first material."""
    return float(run.state["materials"]["poisson"][0])


def timoshenko(poisson: float, gravity: float) -> float:
    """Tip deflection [m] by its own weight, rho g A L^4/(8EI) + rho g L^2/(2 kappa G)."""
    kappa, shear = 10 * (1 + poisson) / (12 + 11 * poisson), YOUNG / (2 * (1 + poisson))
    return DENSITY * gravity * (12 / (8 * YOUNG * THICK**2) + 1 / (2 * kappa * shear))


def beam_error(run: Finished) -> float:
    """Of the mean end less the mean root, against Timoshenko [per cent]."""
    deflection = plane_mean(run, 0, 0)[1] - plane_mean(run, 0, 1)[1]
    gravity = float(-run.state["gravity"][1])
    return 100 * (float(deflection) / timoshenko(poisson_of(run), gravity) - 1)


def sheet_ratio(run: Finished) -> float:
    """Deflection over that of a plate of width 1 with E/(1-nu^2) and shear factor 5/6; t = 5 cm."""
    t, poisson = 0.05, poisson_of(run)
    plate = DENSITY * PULL * (12 * (1 - poisson**2) / (8 * YOUNG * t**2)
                              + 2 * (1 + poisson) / (2 * 5 / 6 * YOUNG))
    return float(-plane_mean(run, 0, 1)[1]) / plate


def beam(key: str, name: str, n: int, element: Options, reference: Sequence[float],
         ratios: Sequence[float] = POISSON, scene: str = "beam_static",
         sweep: list[Options] | None = None) -> Row:
    """A row of bending."""
    return Row(key, f"{name}, n = {n}", scene, STATIC, sweep or poissons(ratios), each(beam_error),
               "deflection against Timoshenko [per cent], nu " + " ".join(f"{r:g}" for r in ratios),
               reference, SOLIDS, 0.2, options=("--voxels", str(10 * n), *element), short=n <= 2)


def parabola(n: int) -> Options:
    """The weight of the beam on its root, row by row, as 6 s (1 - s) over the height s."""
    words: list[str] = []
    for row in range(n):
        low, high = row / n, (row + 1) / n
        share = (3 * high**2 - 2 * high**3) - (3 * low**2 - 2 * low**3)
        words += ["--traction", f"box(0%,{100 * low - 0.01:.2f}%,0%, 0%,{100 * high + 0.01:.2f}%,"
                  f"100%): 0,{DENSITY * PULL * THICK**2 * share!r},0"]
    return tuple(words)


FULL = {1: (-33.2, -35.7, -49.5, -61.6, -79.8), 2: (-11.2, -13.4, -25.5, -40.8, -62.3),
        4: (-3.05, -4.5, -10.7, -23.3, -45.2), 8: (-0.78, -1.9, -4.9, -11.3, -30.7)}
MEAN = {1: (-7.8, 19.7, 37.0, 37.8), 2: (-3.5, -2.6, -6.1, -6.4), 4: (-1.0, -1.7, -4.0, -4.2),
        8: (-0.27, -1.1, -3.1, -3.2)}
TORSION = {1: (-0.13, -0.15, -0.16, -0.16, -0.16), 2: (-0.13, 0.08, -2.77, -4.00, -4.32),
           4: (-0.04, -0.82, -2.66, -3.38, -3.56)}
VARIANCE = {2: (-0.13, 0.02, -2.94, -4.21, -4.53), 4: (-0.04, -0.85, -2.74, -3.47, -3.65),
            8: (-0.01, -0.91, -2.37, -2.92, -3.05)}
SLIDING = {1: TORSION[1], 2: (-0.13, 1.19, 0.24, -0.17, -0.27),
           4: (-0.04, 0.23, -0.06, -0.18, -0.21)}
SHEET = {1: (1.000, 1.000, 0.999, 0.999, 0.999), 2: (1.000, 1.047, 1.073, 1.079, 1.080),
         4: (1.000, 1.009, 1.010, 1.009, 1.008)}


def bending() -> list[Row]:
    """D1, D2, D3 and D4."""
    rows = [beam("D1", "clamped, `voxel`", n, (), values) for n, values in TORSION.items()]
    rows += [beam("D1", "clamped, `voxel`, `--hourglass variance`", n,
                  ("--hourglass", "variance"), values) for n, values in VARIANCE.items()]
    rows += [replace(beam("D1", "clamped, `animate`", n, LONG, TORSION[n]), verb="animate")
             for n in (2, 4)]
    rows += [beam("D2", "root slides in its plane, `voxel`", n, parabola(n), values,
                  scene="beam_sliding") for n, values in SLIDING.items()]
    for n, values in SHEET.items():
        rows.append(Row("D3", f"wide sheet, `voxel`, n = {n}", "sheet_static", STATIC, poissons(),
                        each(sheet_ratio), "deflection over the plate's, nu 0 0.3 0.45 0.49 0.499",
                        values, SOLIDS, 0.005, options=("--voxels", str(20 * n)), short=n == 1))
    rows += [beam("D4", "clamped, `hex`", n, ("--element", "hex"), values)
             for n, values in FULL.items()]
    rows += [beam("D4", "clamped, `hex-bbar`", n, ("--element", "hex-bbar"), values,
                  (0, 0.3, 0.49, 0.499)) for n, values in MEAN.items()]
    rows.append(Row("D4", "order in h of `hex`, nu 0, n = 4, 8", "beam_static", STATIC,
                    [("--voxels", "40"), ("--voxels", "80")],
                    lambda runs: [float(np.log2(beam_error(runs[0]) / beam_error(runs[1])))],
                    "log2 of the errors' ratio", (2,), "second order of linear shape functions",
                    0.1, options=("--element", "hex", "--poisson", "0")))
    return rows


def reissner(load: Callable[[float], float], axial: float, shear: float) -> float:
    """Deflection of the end over L of a clamped beam, EI = L = 1, that shears and stretches.

    theta' = M, M' = -V x', x' = (1 + V sin/axial) cos - V cos/shear sin and y' alike, with the load
    V(s) beyond s, axial and shear stiffness over EI/L^2; M(0) by bisection for M(1) = 0. Infinite
    stiffnesses give the elastica. Runge-Kutta, 400 steps: off by less than 1e-7.
    """
    def slope(s: float, state: tuple[float, ...]) -> tuple[float, ...]:
        theta, moment, _ = state
        V, c, d = load(s), np.cos(theta), np.sin(theta)
        stretch, slip = 1 + V * d / axial, V * c / shear
        return moment, -V * (stretch * c - slip * d), stretch * d + slip * c

    def shoot(moment: float) -> tuple[float, ...]:
        count, state = 400, (0.0, moment, 0.0)
        for k in range(count):
            s, h = k / count, 1 / count
            a = slope(s, state)
            b = slope(s + h / 2, tuple(p + h / 2 * q for p, q in zip(state, a)))
            c = slope(s + h / 2, tuple(p + h / 2 * q for p, q in zip(state, b)))
            d = slope(s + h, tuple(p + h * q for p, q in zip(state, c)))
            state = tuple(p + h / 6 * (w + 2 * x + 2 * y + z)
                          for p, w, x, y, z in zip(state, a, b, c, d))
        return state

    low, high = 0.0, load(0)  # the moment of the load at its full arm is larger
    for _ in range(40):
        moment = (low + high) / 2
        low, high = (moment, high) if shoot(moment)[1] < 0 else (low, moment)
    return shoot(low)[2]


ELASTICA = {0.5: 0.06231, 1: 0.12347, 2: 0.23851, 5: 0.49591, 10: 0.70020, 20: 0.82988, 50: 0.90792}
TIP = {0.25: (0.08275, 0.99588), 0.5: (0.16214, 0.98408), 1: (0.30172, 0.94357),
       2: (0.49346, 0.83936), 3: (0.60325, 0.74558), 5: (0.71379, 0.61237), 10: (0.81061, 0.44500)}


def heavy(length: float) -> list[Options]:
    """E = 12 rho g L^3/(K t^2) for the weights K = w L^3/EI of the table."""
    return [("--young", repr(12 * DENSITY * 9.81 * length**3 / (K * THICK**2))) for K in ELASTICA]


def pulled() -> list[Options]:
    """A dead load P at the end for the loads P L^2/EI of the table, E = 1e7 Pa."""
    return [("--traction", f"x>100%: 0,{-load * 1e7 * THICK**4 / 12!r},0") for load in TIP]


def drop(run: Finished) -> float:
    """Deflection of the middle of the end over the length."""
    return float(-plane_mean(run, 0, run.rest[:, 0].max())[1] / run.rest[:, 0].max())


def places(runs: Sequence[Finished]) -> list[float]:
    """Deflection and place along x of the end over the length, of every run."""
    return [value for run in runs for value in (drop(run), 1 + float(plane_mean(run, 0, 1)[0]))]


def large_deflection() -> list[Row]:
    """Beams bent far beyond small rotations, nu = 0."""
    law = ("--law", "neo-hookean", "--poisson", "0")
    weight, thick = (*law, "--gravity", "0,-9.81,0"), "deflection over L, K "
    # a square beam at nu = 0: EA L^2/EI = 12 (L/t)^2, 5/6 G A L^2/EI = 5 (L/t)^2
    solid = [reissner(lambda s, K=K: K * (1 - s), 1200, 500) for K in ELASTICA]
    loads = " ".join(f"{K:g}" for K in ELASTICA)
    rows = [Row("D", "weight, `voxel`, n = 8, L/t = 10: elastica", "beam_static", STATIC,
                heavy(1)[:-1], each(drop), thick + loads[:-3], list(ELASTICA.values())[:-1],
                "elastica", 0.02, True, options=(*weight, "--voxels", "80"))]
    for n in (4, 8):
        rows.append(Row("D", f"weight, `voxel`, n = {n}, L/t = 10: beam that shears and stretches",
                        "beam_static", STATIC, heavy(1), each(drop), thick + loads, solid,
                        "Reissner's beam by shooting", 0.01, True, short=n == 4,
                        options=(*weight, "--voxels", str(10 * n))))
    rows.append(Row("D", "weight, `tet10`, 2 cells thick, L/t = 20: elastica", "slender_static",
                    STATIC, heavy(2), each(drop), thick + loads, list(ELASTICA.values()),
                    "elastica", 0.02, True, options=(*weight, "--element", "tet10", "--mass",
                                                     "consistent", "--voxels", "40")))
    for element, n in (("voxel", 8), ("tet10", 2)):
        rows.append(Row("D", f"load at the end, `{element}`, n = {n}, L/t = 10: elastica",
                        "beam_static", STATIC, pulled(), places,
                        "deflection, place along the axis, over L, P L^2/EI "
                        + " ".join(f"{load:g}" for load in TIP),
                        [value for pair in TIP.values() for value in pair], "elastica", 0.02, True,
                        options=(*law, "--young", "1e7", "--gravity", "0,0,0", "--element", element,
                                 "--voxels", str(10 * n))))
    return rows


def hanging(run: Finished) -> list[float]:
    """Lengthening over rho g L^2/(2E), stress of the upper end over rho g L.

    The stress is E times the strains of two layers of nodes, carried on to the face.
    """
    levels = np.unique(np.round(run.rest[:, 0], 9))
    u = [float(plane_mean(run, 0, place)[0]) for place in (*levels[:3], levels[-1])]
    h = levels[1] - levels[0]
    strain = 1.5 * (u[1] - u[0]) / h - 0.5 * (u[2] - u[1]) / h
    return [u[3] / (DENSITY * PULL / (2 * YOUNG)), YOUNG * strain / (DENSITY * PULL)]


def torque_of_load(run: Finished) -> float:
    """Moment [N m] of the nodal forces of all tractions about the beam's axis."""
    arm, force = run.rest - [0, THICK / 2, THICK / 2], run.state["grid/traction"]
    return float((arm[:, 1] * force[:, 2] - arm[:, 2] * force[:, 1]).sum())


def twist_ratio(run: Finished) -> float:
    """Torque over 0.140577 G t^4 theta/L, theta between the sections at 0.3 and 0.7 L."""
    arm, u, turned = run.rest - [0, THICK / 2, THICK / 2], run.u[-1], []
    for place in (0.3, 0.7):
        w = on_plane(run.rest, 0, place)
        turned.append(float(w @ (arm[:, 1] * u[:, 2] - arm[:, 2] * u[:, 1])
                            / (w @ (arm[:, 1] ** 2 + arm[:, 2] ** 2))))
    shear = YOUNG / (2 * (1 + poisson_of(run)))
    return torque_of_load(run) / (0.140577 * shear * THICK**4 * (turned[1] - turned[0]) / 0.4)


def couples(n: int) -> Options:
    """Forces on the end, along z by its rows, along y by its columns, in proportion to the arm."""
    words: list[str] = []
    for row in range(n):
        low, high = f"{100 * row / n - 0.01:.2f}%", f"{100 * (row + 1) / n + 0.01:.2f}%"
        force = (2 * row + 1) / n - 1
        words += ["--traction", f"box(100%,{low},0%, 100%,{high},100%): 0,0,{force!r}",
                  "--traction", f"box(100%,0%,{low}, 100%,100%,{high}): 0,{-force!r},0"]
    return tuple(words)


def reaction(run: Finished) -> float:
    """Torque [N m] that holds the moved end, from the referee's formulas."""
    with h5py.File(run.folder / "state.h5") as file:
        state = read_state(file)
        body, x = equations.make_body(state), state.x[-1]
    force = equations.internal_energy(body, x, equations.rotations(body, x))[2]
    end = np.isclose(body.rest[:, 0], 1)
    arm = x - [0, THICK / 2, THICK / 2]
    return float((arm[:, 1] * force[:, 2] - arm[:, 2] * force[:, 1])[end].sum())


def antisymmetry(runs: Sequence[Finished]) -> list[float]:
    """|T(a) + T(-a)|/|T(a)| of pairs of runs."""
    torque = [reaction(run) for run in runs]
    return [abs(a + b) / abs(a) for a, b in zip(torque[::2], torque[1::2])]


def bars() -> list[Row]:
    """Hanging bar and twist."""
    along = ("--gravity", f"{PULL},0,0", "--poisson", "0", "--voxels", "40")
    rows = [Row("D", "hanging bar, nu 0", "beam_static", STATIC,
                [("--element", e) for e in ("voxel", "hex", "hex-bbar", "tet10")],
                lambda runs: [value for run in runs for value in hanging(run)],
                "lengthening over rho g L^2/(2E), stress above over rho g L: `voxel` `hex` "
                "`hex-bbar` `tet10`", (1.0,) * 8, "closed form", 0.005, options=along, short=True)]
    stiff = {2: 1.186, 3: 1.090, 4: 1.052, 6: 1.024, 8: 1.014}
    rows.append(Row("D", "twist of a square bar, `voxel`, free to warp", "beam_static", STATIC,
                    [(*couples(n), "--voxels", str(10 * n)) for n in stiff],
                    each(twist_ratio), "stiffness over 0.140577 G t^4/L, n = 2 3 4 6 8",
                    list(stiff.values()), SOLIDS + "; 1 in the limit (Saint-Venant)", 0.002,
                    options=("--gravity", "0,0,0", "--poisson", "0.3")))
    turns = [("--move", f"x>100%: turn(0,50%,50%, 1,0,0) 0s:0; 1s:{angle}deg")
             for size in (180, 360, 720) for angle in (size, -size)]
    far = ("--gravity", "0,0,0", "--poisson", "0.3", "--law", "neo-hookean", "--voxels", "40")
    rows.append(Row("D", "twist by 180, 360, 720 degrees, n = 4: torque antisymmetric",
                    "beam_static", STATIC, turns, antisymmetry, "|T(a) + T(-a)|/|T(a)|", (0,) * 3,
                    "symmetry", 1e-6, options=far))
    rows.append(Row("D", "the same: nothing inverted", "beam_static", STATIC, turns,
                    each(lambda run: -float(run.state["steps/min_j"].min())),
                    "smallest det F, negated", (0,) * 6, "above 0", 0.0, bound=True, options=far))
    return rows


STATICS = [*bending(), *large_deflection(), *bars()]
