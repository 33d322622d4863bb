# SPDX-License-Identifier: Apache-2.0
"""The criteria that every run of the stress scenes must meet, from what it wrote and the formulas
of the referee (tests/python).

    U1  the exit code is one of those documented, and of those that the case allows; no signal
    U2  every number written is finite
    U3  what was refused is said in a sentence, and no animation is left
    U4  E' <= E + W for a passive run by implicit Euler: W is the work of the forces left unbalanced
    U5  a step takes at most 20 times the evaluations of the median one (50 at least), is a draft, or
        is among the long steps of the report
    U6  peak memory is at most 3584 bytes a voxel and 72 MiB for the program and its outputs
    U7  the same bits again, with another number of threads
    U8  a step is converged only below the tolerance, and the reported residual is the true one
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator
from dataclasses import replace

import h5py
import numpy as np

from runs import HERE, Finished, Floats

sys.path.insert(0, str(HERE.parent / "python"))
import collision  # noqa: E402
import equations  # noqa: E402
import referee  # noqa: E402
from equations import Body, Motion  # noqa: E402
from state_file import LayoutError, State, read_state  # noqa: E402

DOCUMENTED = {0, 2, 3, 4, 5, 6, 7, 130, 143}
REFUSED = {2, 3, 6}  # before the first step
ENERGY_SHARE = 1e-6  # of the largest energy of the run
STAGE_SHARE = 5e-3  # of the range of the energy that it may rise by, in steps of stages
SLOW, NOMINAL = 20, 50  # times the median work; evaluations of a step that is no trouble
BYTES_A_VOXEL, BASE = 2560 + 1024, (64 + 8) << 20  # of the steps and of the mesh number


def codes(run: Finished, allowed: set[int]) -> Iterator[str]:
    """U1, and U3 of what was refused."""
    if run.code not in DOCUMENTED:
        yield f"U1: ended with {run.code}, {run.err.strip()[:200]}"
    elif run.code not in allowed:
        yield f"U1: exit code {run.code}, not {sorted(allowed)}: {run.err.strip()[:200]}"
    if run.code in REFUSED | {5} and not run.err.strip():
        yield f"U3: exit code {run.code} without a word"
    if run.code in REFUSED and (run.folder / "out.pc2").exists():
        yield "U3: refused, but an animation is there"


def finite(run: Finished) -> Iterator[str]:
    """U2 of all four files."""
    for name, values in run.state.items():
        if name == "steps/x_stage":  # steps of one stage have none
            values = values[run.state["steps/scheme"] == 2]
        if name.startswith("steps/mesh_error"):  # steps that end no frame have none
            values = values[np.isfinite(run.state["steps/mesh_error"])]
        if isinstance(values, np.ndarray) and values.dtype.kind == "f":
            if not np.isfinite(values).all():
                yield f"U2: {name} of the state file is not finite"
    if not np.isfinite(np.frombuffer((run.folder / "out.pc2").read_bytes()[32:], "<f4")).all():
        yield "U2: a place in the point cache is not finite"
    text = (run.folder / "log.json").read_text() + (run.folder / "report.json").read_text()
    for word in ("NaN", "Infinity", "null", "nan", "inf,"):
        if f": {word}" in text or f":{word}" in text:
            yield f"U2: '{word}' in the log or the report"


def work(run: Finished) -> Iterator[str]:
    """U5."""
    steps = run.state["steps/inner"]
    most = SLOW * max(float(np.median(steps)), NOMINAL)
    report = json.loads((run.folder / "report.json").read_text())
    said = np.isin(np.arange(len(steps)) + 1, report["long_steps"])
    for step in np.flatnonzero((steps > most) & (run.state["steps/converged"] == 1) & ~said)[:1]:
        yield (f"U5: step {step} took {steps[step]} evaluations, the median one "
               f"{np.median(steps):.0f}, and says nothing")


def memory(run: Finished) -> Iterator[str]:
    """U6; the state file and the point cache are written as the run goes on."""
    voxels = len(run.state["grid/corners"])
    if run.peak > BYTES_A_VOXEL * voxels + BASE:
        yield (f"U6: {run.peak >> 20} MiB for {voxels} voxels, "
               f"{(run.peak - BASE) / voxels:.0f} bytes a voxel above the base")


def bits(run: Finished) -> str:
    """Hash of the motion: the point cache, positions and velocities."""
    digest = hashlib.sha256()
    if (run.folder / "out.pc2").exists():
        digest.update((run.folder / "out.pc2").read_bytes())
        for name in ("steps/x", "steps/v", "steps/residual"):
            digest.update(run.state[name].tobytes())
    return f"{run.code} {digest.hexdigest()}"


def floor(state: State, body: Body, x: Floats) -> float:
    """Rounding of a residual in double precision: of strains, and of positions over dt^2."""
    stiffest = max(2 * mu + 3 * lam for mu, lam in
                   (equations.lame(m.young, m.poisson) for m in state.materials))
    strains = 6 * 2.0**-52 * stiffest / min(m.density for m in state.materials)
    places = 16 * 2.0**-53 * float(np.abs(x).max()) / state.dt**2
    return strains / (state.g_ref * state.h) + places / state.g_ref


def barrier(state: State, step: int, x: Floats) -> float:
    """Energy of the colliders' barriers at x [J]."""
    if state.contact is None:
        return 0.0
    slippery = replace(state, contact=state.contact
                       | {"friction": np.zeros_like(state.contact["friction"])})
    return collision.contact(slippery, step, x, x)[0]


def stored(state: State, body: Body, step: int, x: Floats, v: Floats, elastic: float) -> float:
    """Kinetic, elastic, gravity and barrier energy [J]; step is that which ends at x."""
    return (elastic + float(body.mass @ (v * v).sum(1)) / 2 + barrier(state, step, x)
            - float(body.mass @ (x @ state.gravity)))


def judge(run: Finished, passive: bool) -> Iterator[str]:
    """U4 and U8, step by step; of each the first fault."""
    with h5py.File(run.folder / "state.h5") as file, np.errstate(all="ignore"):
        try:
            state = read_state(file)
            if state.words["time_scheme"] == "static":
                verdict = referee.judge(state, False)
                yield from (f"U8: {check.quantity} {check.own:.3e}, recorded {check.recorded:.3e}"
                            for check in verdict.disagreements[:1])
                return
            yield from (judge_stages if state.has_stages else judge_steps)(state, passive)
        except LayoutError as error:
            yield f"U2: {error}"


def judge_stages(state: State, passive: bool) -> Iterator[str]:
    """The same of a run by sdirk2 or auto. The contact energy holds the work of friction in the last stage."""
    verdict = referee.judge(state, False)
    lost = 1e6 * state.tolerance  # a draft there stands on points within rounding of a wall
    body = equations.make_body(state)
    faults = [c for c in verdict.disagreements if c.quantity != "residual" or (
        min(c.own, c.recorded) < lost and abs(c.own - c.recorded)
        > c.allowed + floor(state, body, referee.read_record(state, c.step + 1)[0]))]
    yield from (f"U8: {c.quantity} of step {c.step} is {c.own:.3e}, recorded {c.recorded:.3e}"
                for c in faults[:1])
    if not passive:
        return
    mass = state.grid["mass"]
    total = sum(state.steps[f"energy_{name}"] for name in ("elastic", "hourglass", "gravity", "contact"))
    total = total + [mass @ (referee.read_record(state, k + 1)[1] ** 2).sum(1) / 2 for k in range(len(total))]
    rises = total - np.minimum.accumulate(total)
    worst, scale = int(rises.argmax()), np.ptp(total) + np.abs(total).max() * 1e-9
    if len(total) > 1 and rises[worst] > STAGE_SHARE * max(scale, state.steps["energy_kinetic"].max()):
        yield f"U4: energy rises by {rises[worst] / scale:.1e} of its range up to step {worst}"


def judge_steps(state: State, passive: bool) -> Iterator[str]:
    """The same of a run in time."""
    body, seen = equations.make_body(state), set()
    euler = passive and not state.steps["scheme"].any()
    x_before = v_before = None
    x, v = referee.read_record(state, 0)
    total, largest = None, 0.0
    for step, scheme in enumerate(state.steps["scheme"]):
        motion = Motion(x, v, x_before, v_before) if scheme else Motion(x, v)
        y, w = referee.read_record(state, step + 1)
        R = equations.rotations(body, x)
        found = equations.potential(body, motion, state.gravity, state.dt, y, R)
        if state.contact is not None:
            found = found.with_contact(*collision.contact(state, step, x, y))
        own = equations.residual(body, found.gradient, state.g_ref)
        fault = residual_fault(state, step, own, floor(state, body, y))
        if fault and "U8" not in seen:
            seen.add("U8")
            yield fault
        if euler and "U4" not in seen:
            if total is None:
                start = equations.internal_energy(body, x, R)
                total = stored(state, body, step, x, v, start[0] + start[1])
                lowest = total
            after = stored(state, body, step, y, w, found.elastic + found.hourglass)
            left = float((found.gradient * (y - x))[body.loose].sum())
            lowest = min(lowest, after)
            largest = max(largest, abs(total), abs(after), total - lowest)
            if after - total - max(left, 0.0) > ENERGY_SHARE * largest:
                seen.add("U4")
                gain = (after - total) / largest
                yield f"U4: energy rises by {gain:.1e} of the largest in step {step}"
            total = after
        x_before, v_before, x, v = x, v, y, w


def residual_fault(state: State, step: int, own: float, rounding: float) -> str:
    """What U8 finds in a step; empty if nothing.

    A draft a million tolerances away stands on points within rounding of a wall, where the last
    bits of a position decide the barrier's force.
    """
    reported = float(state.steps["residual"][step])
    if state.steps["converged"][step] and not own <= state.tolerance * (1 + 1e-9) + rounding:
        return f"U8: step {step} is converged at {own:.2e}, tolerance {state.tolerance:.0e}"
    lost = min(own, reported) > 1e6 * state.tolerance
    if not lost and not abs(own - reported) <= 1e-6 + 0.05 * reported + rounding:
        return f"U8: step {step} reports {reported:.3e}, it is {own:.3e}"
    return ""


def all_faults(run: Finished, again: Finished, allowed: set[int], passive: bool) -> list[str]:
    """Every criterion that a run fails; `again` is the same with another number of threads."""
    found = list(codes(run, allowed))
    if bits(run) != bits(again):
        found.append("U7: other bits with another number of threads")
    if run.code in {0, 4, 5} and (run.folder / "state.h5").exists():
        voxel = run.state["element"] in (b"voxel", "voxel")
        found += [*finite(run), *work(run), *memory(run)]
        found += judge(run, passive) if voxel and len(run.state["steps/residual"]) else []
    return found
