# SPDX-License-Identifier: Apache-2.0
"""Rows of dynamics: vibrations, integrators, waves, impact, momentum, energy, order in time."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence

import h5py
import numpy as np

from ladder_row import HERE, Options, Row, each, on_plane
from runs import Finished, Floats

sys.path.insert(0, str(HERE.parent / "python"))
import equations  # noqa: E402
import referee  # noqa: E402
from state_file import read_state  # noqa: E402

STEPS = (0.01, 0.1, 0.5, 1.0)  # omega dt, omega = 100/s
ROOTS = (1.87510407, 4.69409113)  # of cos b cosh b = -1
SPEED = np.sqrt(1e6 / 1e3)  # of a bar, E = 1 MPa, rho = 1000 [m/s]
EDGE = 1 / 64  # of a voxel of the rod [m]
RAMP = 12  # half the length of the pulse in voxels


def shape(beta: float, x: Floats) -> Floats:
    """Bending mode of the clamped beam of length 1."""
    ratio = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
    return np.cosh(beta * x) - np.cos(beta * x) - ratio * (np.sinh(beta * x) - np.sin(beta * x))


def euler_bernoulli(beta: float) -> float:
    """Frequency [Hz] of the clamped beam, L = 1, t = 0.1, E = 1e8, rho = 1000."""
    return float(beta**2 / (2 * np.pi) * np.sqrt(1e8 * 0.1**2 / 12 / 1000))


def timoshenko(beta: float) -> float:
    """The same with shear (factor 10/12, nu = 0) and rotary inertia [Hz].

    (w, psi, M, Q)' = A (w, psi, M, Q); the root of the determinant that leaves M and Q of the end
    0, by bisection between 0.8 and 1.02 of Euler's and Bernoulli's.
    """
    E, area, inertia = 1e8, 0.01, 0.1**4 / 12
    shear = 10 / 12 * E / 2 * area

    def determinant(f: float) -> float:
        load = 1000 * (2 * np.pi * f) ** 2
        A = np.array([[0, 1, 0, 1 / shear], [0, 0, 1 / (E * inertia), 0],
                      [0, -load * inertia, 0, -1], [-load * area, 0, 0, 0]])
        value, vector = np.linalg.eig(A)
        end = (vector * np.exp(value)) @ np.linalg.inv(vector)
        return float(np.linalg.det(end[2:, 2:]).real)

    low, high = 0.8 * euler_bernoulli(beta), 1.02 * euler_bernoulli(beta)
    side = determinant(low)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if determinant(middle) * side > 0 else (low, middle)
    return low


def crossings(signal: Floats, times: Floats) -> Floats:
    """Times of the changes of sign, linear between entries; that of the start left out."""
    at = np.flatnonzero(signal[1:-1] * signal[2:] < 0) + 1
    share = signal[at] / (signal[at] - signal[at + 1])
    return times[at] + share * (times[at + 1] - times[at])


def frequency(signal: Floats, times: Floats) -> float:
    """From the first to the last change of sign [Hz]."""
    found = crossings(signal, times)
    return (len(found) - 1) / 2 / (found[-1] - found[0])


def beam_frequency(beta: float) -> Callable[[Finished], float]:
    """Frequency [Hz] of the part of the motion along a mode."""
    def measure(run: Finished) -> float:
        weight = run.mass * shape(beta, run.rest[:, 0])
        return frequency(run.u[:, :, 1] @ weight, run.state["steps/time"])
    return measure


def mostly_second() -> Options:
    """Velocity and spin about the middle whose sum x + a has no part along the first mode."""
    x = np.linspace(0, 1, 2001)
    first = shape(ROOTS[0], x)
    a = -float((x * first).sum() / first.sum())
    return ("--spin", "0,0,0.2", "--velocity", f"0,{0.2 * (a + 0.5)!r},0")


def beams() -> list[Row]:
    """E1."""
    rows = []
    for n in (4, 8):
        for name, wanted in (("Euler and Bernoulli", euler_bernoulli), ("Timoshenko", timoshenko)):
            rows.append(Row("E1", f"first frequency, n = {n}: {name}", "vibration", "animate", [()],
                            each(beam_frequency(ROOTS[0])), "[Hz]", [wanted(ROOTS[0])], name, 0.01,
                            True, short=n == 4, options=(
                                "--voxels", str(10 * n), "--fps", repr(100 * wanted(ROOTS[0])))))
    fps = ("--fps", repr(100 * timoshenko(ROOTS[1])), "--frames", "260")
    rows.append(Row("E1", "second frequency, n = 4: Timoshenko", "vibration", "animate",
                    [mostly_second()], each(beam_frequency(ROOTS[1])), "[Hz]",
                    [timoshenko(ROOTS[1])], "Timoshenko", 0.01, True, options=fps))
    return rows


def root(scheme: str, z: float) -> complex:
    """What a step multiplies v + i omega u by, z = omega dt."""
    if scheme == "euler":
        return 1 / (1 - 1j * z)
    if scheme == "bdf2":
        return (2 + np.sqrt(1 + 2j * z)) / (3 - 2j * z)
    return (1 + 0.5j * z) / (1 - 0.5j * z)  # Newmark 1/4, 1/2


def period(factor: complex, z: float) -> list[float]:
    """Amplitude kept a period, frequency over omega."""
    return [float(abs(factor) ** (2 * np.pi / np.angle(factor))), float(np.angle(factor) / z)]


def measured_roots(runs: Sequence[Finished]) -> list[float]:
    """`period` of the factor between the steps 25 and 30, behind the start of BDF2."""
    found: list[float] = []
    for run, z in zip(runs, STEPS):
        top = np.argmax(run.rest[:, 1])
        w = run.v[:, top, 1] + 100j * run.u[:, top, 1]
        factors = w[26:31] / w[25:30]
        found += period(complex(factors.mean()), z)
    return found


def modes() -> list[Row]:
    """E2."""
    rows, sweep = [], [("--fps", repr(100 / z)) for z in STEPS]
    # what a residual of 1e-9 of the weight leaves in the accelerations is 1e-8 of omega^2 u; the
    # laws themselves, because tables of nets have seven digits
    for verb, schemes, tolerance, law in (
            ("simulate", ("euler", "bdf2", "newmark"), 1e-8, ()),
            ("animate", ("euler", "bdf2"), 1e-6, ("--analytic",))):
        for scheme in schemes:
            rows.append(Row(
                "E2", f"one mode, {scheme}, `{verb}`", "one_mode", verb, sweep, measured_roots,
                "amplitude kept a period, frequency over omega, omega dt 0.01 0.1 0.5 1",
                [v for z in STEPS for v in period(root(scheme, z), z)], "root of the scheme",
                tolerance, options=("--time-scheme", scheme, "--tolerance", "1e-9", *law),
                short=True))
    return rows


# along x, sideways; what is held besides; Poisson's ratio, speed over that of a bar
WAVES = {"bar": (0, None, 0.0, 1.0), "bulk": (0, "yz", 0.3, np.sqrt(0.7 / 1.3 / 0.4)),
         "shear": (1, "xz", 0.3, np.sqrt(1 / 2.6))}


def wave_options(held: str | None, poisson: float) -> Options:
    """Of a rod in which one component moves."""
    return ("--poisson", repr(poisson), *(("--hold", f"x>{EDGE}: {held}") if held else ()))


def bell(axis: int, speed: float) -> str:
    """Moves the end by a raised cosine in 24 straight pieces."""
    keys = []
    for k in range(2 * RAMP + 1):
        place = ["0", "0", "0"]
        place[axis] = repr(0.5e-5 * (1 - np.cos(np.pi * k / RAMP)))
        keys.append(f"{k * EDGE / speed!r}s:{','.join(place)}")
    return "x<0%: shift " + "; ".join(keys)


def arrival(axis: int, speed: float) -> Callable[[Finished], float]:
    """Time between the largest displacements of the end and of the 90th section, in h/c."""
    def measure(run: Finished) -> float:
        signal = run.u[:, :, axis] @ on_plane(run.rest, 0, 90 * EDGE)
        k = int(np.argmax(signal))
        a, b, c = signal[k - 1:k + 2]
        top = k + 0.5 * (a - c) / (a - 2 * b + c)  # of the parabola through three entries
        return (top * float(run.state["dt"])) * speed / EDGE - RAMP
    return measure


def standing(axis: int) -> Callable[[Finished], float]:
    """Wavelength over period, over the speed of a bar."""
    def measure(run: Finished) -> float:
        signal = run.u[:, :, axis] @ np.sin(np.pi * run.rest[:, 0] / (50 * EDGE))
        return 100 * EDGE * frequency(signal, run.state["steps/time"]) / SPEED
    return measure


def waves() -> list[Row]:
    """E3: a pulse that the end of a rod is moved by, and a quarter of a wave of 100 voxels."""
    rows = []
    for name, (axis, held, poisson, speed) in WAVES.items():
        c = speed * SPEED
        common = wave_options(held, poisson)
        rows.append(Row("E3", f"{name}: pulse over 90 voxels", "rod", "simulate", [()],
                        each(arrival(axis, c)), "arrival [h/c]", [90], "wave equation", 1.25,
                        options=(*common, "--move", bell(axis, c), "--fps", repr(4 * c / EDGE)),
                        short=True))
        throw = [0.0, 0.0, 0.0]
        throw[axis] = 1e-3
        rows.append(Row("E3", f"{name}: standing wave of 100 voxels", "wire", "simulate", [()],
                        each(standing(axis)), "speed over that of a bar", [float(speed)],
                        "wave equation", 0.02, True, short=True,
                        options=(*common, "--velocity", ",".join(map(repr, throw)), "--fps",
                                 repr(2 * c / EDGE))))
    return rows


def wall(runs: Sequence[Finished]) -> list[float]:
    """Contact over 2L/c, wall stress over rho c v0, rebound over v0; force from the momentum."""
    found: list[float] = []
    for run in runs:
        momentum, times = run.v[:, :, 1] @ run.mass, run.state["steps/time"]
        force = np.diff(momentum) / np.diff(times)
        touched = times[1:][force > 0.1 * 0.4]  # rho c v0 times the area is 0.4 N
        held = (times[1:] > 40) & (times[1:] < 120)
        found += [(touched[-1] - touched[0]) / 160, float(force[held].mean()) / 0.4,
                  float(momentum[-1]) / (0.1 * float(run.mass.sum()))]
    return found


def drift(run: Finished) -> float:
    """Largest change of sum m v over sum m |v| of the start."""
    momentum = np.einsum("n,tnd->td", run.mass, run.v)
    size = run.mass @ np.linalg.norm(run.v[0], axis=1)
    return float(np.linalg.norm(momentum - momentum[0], axis=1).max() / size)


def spin_kept(run: Finished) -> float:
    """Angular momentum about z of the last entry over that of the first."""
    def about_z(k: int) -> float:
        x, v = run.state["steps/x"][k], run.v[k]
        centre = run.mass @ x / run.mass.sum()
        arm = x - centre
        return float(run.mass @ (arm[:, 0] * v[:, 1] - arm[:, 1] * v[:, 0]))
    return about_z(-1) / about_z(0)


def rigid_spin(angle: float, steps: int) -> float:
    """The same of a rigid body, implicit Euler: tan a' = sin a/(2 - cos a), first tan a = angle."""
    a = np.arctan(angle)
    for _ in range(steps - 1):
        a = np.arctan(np.sin(a) / (2 - np.cos(a)))
    return float(np.sin(a) / angle)


def fall(run: Finished) -> float:
    """Largest error of g t^2/2, by implicit Euler of g t (t + dt)/2, over the depth at the end."""
    times, dt = run.state["steps/time"], float(run.state["dt"])
    depth = 9.81 * times * (times + (0 if run.state["steps/scheme"].any() else dt)) / 2
    error = run.u + np.array([0, 1, 0]) * depth[:, None, None]
    return float(np.abs(error).max() / depth[-1])


def energy(run: Finished) -> Floats:
    """Sum of all energies in the file after each step [J]."""
    return sum(run.state[f"steps/energy_{part}"] for part in
               ("kinetic", "elastic", "hourglass", "gravity", "contact"))


def rise(run: Finished) -> float:
    """Largest rise of the energy within a step over the range of its values."""
    total = energy(run)
    return float(np.diff(total).max() / np.ptp(total))


def g_norm_rise(run: Finished) -> float:
    """Largest rise of the G-norm of BDF2, (|w|^2 + |2w - w_|^2)/4 in energy, over its start.

    |w|^2 of w = (u, v) is the kinetic energy plus the elastic one of the referee's formulas.
    """
    with h5py.File(run.folder / "state.h5") as file:
        state = read_state(file)
        body = equations.make_body(state)

    def size(u: Floats, v: Floats) -> float:
        x = body.rest + u
        elastic, hourglass, _ = equations.internal_energy(body, x, equations.rotations(body, x))
        return elastic + hourglass + float(body.mass @ (v * v).sum(1)) / 2
    u, v = run.u, run.v
    norm = [size(u[k], v[k]) + size(2 * u[k] - u[k - 1], 2 * v[k] - v[k - 1])
            for k in range(1, len(u))]
    return float(np.diff(norm).max() / norm[0])


def judged(run: Finished) -> float:
    """Largest difference of a residual to the referee's, in units of what it allows."""
    with h5py.File(run.folder / "state.h5") as file:
        return max(check.excess for check in referee.judge(read_state(file), False).checks)


EULER = ("--time-scheme", "euler")


def passive() -> list[Row]:
    """E4 to E6 and E8."""
    still = ("--gravity", "0,0,0")
    spin = (*still, "--spin", "0,0,12", "--frames", "20", "--young", "1e9")
    tumble = (*still, "--spin", "3,2,1", "--frames", "10000", "--tolerance", "1e-7")
    rows = [
        Row("E4", "bar on a wall", "column", "simulate", [()], wall,
            "contact over 2L/c, wall stress over rho c v0, rebound over v0", (1, 1, 1),
            "wave equation", 0.02),
        *(Row("E5", f"momentum, 10 000 steps in place, `{verb}`", "free_cube", verb, [()],
              each(drift), "drift over sum m abs(v)", (0,), "conservation", 1e-12, options=tumble)
          for verb in ("animate", "simulate")),
        Row("E5", "momentum, 10 000 steps of flight", "free_cube", "animate", [()], each(drift),
            "drift over sum m abs(v)", (0,), "conservation", 1e-12,
            options=(*tumble, "--velocity", "1,0.5,-0.3")),
        Row("E6", "spin, 20 steps of 0.2 rad, implicit Euler", "free_cube", "animate", [()],
            each(spin_kept), "angular momentum kept", [rigid_spin(0.2, 20)],
            "rigid body in implicit Euler", 0.004, options=(*spin, *EULER), short=True),
        *(Row("E6", f"spin, 20 steps of 0.2 rad, `{verb}`", "free_cube", verb, [()], each(spin_kept),
              "angular momentum kept", (1,), "conservation", 1e-11, options=spin, short=True)
          for verb in ("animate", "simulate"))]
    for verb in ("animate", "simulate"):
        for options, depth in (((), "g t^2/2"), (EULER, "g t (t + dt)/2")):
            rows.append(Row("E8", f"free fall, `{verb}`, {depth}", "free_cube", verb, [()],
                            each(fall), "error over the depth", (0,), depth, 1e-12,
                            options=options, short=True))
    return rows


def energies() -> list[Row]:
    """E7."""
    rows = []
    for scene in ("network_beam", "network_twist", "network_torus"):
        rows.append(Row("E7", f"energy, {scene}, implicit Euler", scene, "animate", [()],
                        each(rise), "largest rise in a step over the range", (0,), "never rises",
                        1e-6, bound=True, options=("--tolerance", "1e-6"),
                        short=scene == "network_beam"))
    return [
        *rows,
        Row("E7", "energy, vibrating beam, Newmark, 10 000 steps", "vibration",
            "simulate", [()], each(lambda run: float(np.ptp(energy(run)) / energy(run)[0])),
            "range over start", (0,), "kept", 1e-3, options=(
                "--time-scheme", "newmark", "--voxels", "10", "--fps", "500", "--frames", "10000")),
        Row("E7", "G-norm, vibrating beam, BDF2", "vibration", "animate", [()], each(g_norm_rise),
            "largest rise in a step over the start", (0,), "never rises", 1e-6, bound=True,
            options=("--voxels", "20", "--hourglass", "variance", "--fps", "500", "--velocity",
                     "0,1e-3,0", "--tolerance", "1e-8"), short=True)]


def residuals() -> list[Row]:
    """E9."""
    referees = [("--law", law) for law in ("neo-hookean", "stable-neo-hookean", "fixed-corotated")]
    return [Row("E9", f"residuals against the referee's, `{verb}`", "network_beam", verb, referees,
                each(judged), "excess over 5 % or 1e-6, three laws", (0,) * 3,
                "formulas of their own", 1.0, options=("--frames", "20"), short=True)
            for verb in ("animate", "simulate")]


def observed_order(run: Finished) -> float:
    """Of the sweep over dt of a study."""
    sweeps = json.loads((run.folder / "study.json").read_text())["sweeps"]
    return float(next(sweep for sweep in sweeps if sweep["variable"] == "dt")["order"])


def orders() -> list[Row]:
    """2.F, order in time, through `study`."""
    common = ("--refine", "0", "--repeat", "1", "--solvers", "newton", "--tolerances", "1e-6",
              "--time-steps", "1,2,4,8")
    return [Row("F", f"order in dt, {scheme}, `study`", "swing", "study", [()],
                each(observed_order), "order of the free run", (wanted,), "order of the scheme",
                0.1, options=("--time-scheme", scheme, *common), short=True)
            for scheme, wanted in (("euler", 1), ("bdf2", 2))]


DYNAMICS = [*beams(), *modes(), *waves(), *passive(), *energies(), *residuals(), *orders()]
