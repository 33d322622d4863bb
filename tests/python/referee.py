# SPDX-License-Identifier: Apache-2.0
"""Referee of state files: recomputes every time step with formulas of its own and compares.

    python3 tests/python/referee.py STATE.h5 [--energy-check] [--json]

Checked in each step: the residual |grad Phi|_2 / |M g_ref| over the free nodes (the largest of its
stages), the flag `converged`, the velocity, without contact the time error, the bonds of friction
that the step leaves, loads that change, places, velocities and reactions of what is held; once: the
layout of the file and the nodal masses. Where
the step says that it was guarded, which takes energy from velocities, these are not checked, and
the summary says in how many. `--energy-check` adds the recorded energies of these names; others are
listed as not checked:

    kinetic    1/2 sum m |v|^2               elastic    sum W psi
    hourglass  variance and torsion terms    gravity    -sum m g.x, up to a constant
    contact    barrier and friction

The kinetic energy of the network is that without pinned nodes, which go with what holds them.

Exit status 0 if everything agrees, else 1 with a table of the worst disagreements.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import h5py
import numpy as np

import collision
import damping
import equations
from equations import Body, Motion, Potential
from held_checks import RESIDUAL_FLOOR, ROUND_OFF, Check, check_held, check_reactions, check_stage
from holding import Holding
from loading import Loading
from nets import table_error
from references import Start, find_pieces
from stages import StageStep
from state_file import SDIRK2, Floats, LayoutError, State, read_state, require

RESIDUAL_SHARE = 0.05
VELOCITY_SHARE = 1e-5
BOND_SHARE = 1e-6
LOAD_SHARE = 1e-6
MASS_SHARE = 1e-6
TABLE_SHARE = 2e-3
ESTIMATE_SHARE = 0.01
UNFILTERED = 0.095  # of what is accepted: below a tenth the program leaves its filter out
ENERGY_SHARE, ENERGY_FLOOR = 0.01, 1e-6
TABLE_ROWS = 10


@dataclass(frozen=True)
class Verdict:
    """All comparisons of a file, the density factor of each material, energies left unchecked."""

    steps: int
    checks: list[Check]
    factors: dict[str, float]
    unchecked: list[str]
    guarded: int = 0  # steps whose velocities are not checked

    @property
    def disagreements(self) -> list[Check]:
        """The comparisons that fail, worst first."""
        return sorted((c for c in self.checks if c.excess > 1), key=lambda c: -c.excess)

    def worst(self, quantity: str) -> Check:
        """The comparison of one quantity with the largest excess."""
        return max((c for c in self.checks if c.quantity == quantity), key=lambda c: c.excess)


def check_residual(state: State, step: int, own: float, slack: float = 0) -> list[Check]:
    """The reported residual within 5 % or 1e-6, and the flag that must follow from it.

    @param slack  allowed besides: what the program's integration of rotations leaves
    """
    reported = float(state.steps["residual"][step])
    allowed = max(RESIDUAL_SHARE * abs(reported), RESIDUAL_FLOOR) + slack
    flag = float(reported <= state.steps["tolerance"][step])
    if "time_ratio" in state.steps:
        flag *= float(state.steps["time_ratio"][step] <= 1)
    return [Check(step, "residual", own, reported, allowed),
            Check(step, "converged", flag, float(state.steps["converged"][step]), 0.0)]


def check_time_error(state: State, step: int, rough: float, touches: bool, slack: float) -> list[Check]:
    """The estimate [m] of a step without contact, here or in two steps before: `rough` but for a filter
    that lowers it, and is left out far below what is accepted. @param slack  [m]"""
    said, ratio = (float(state.steps[name][step]) if name in state.steps else 0.0
                   for name in ("time_error", "time_ratio"))
    if ratio == 0 or touches:
        return []
    is_rough = rough * ratio < UNFILTERED * said  # rough over what is accepted
    own = rough if is_rough else min(rough, said)
    return [Check(step, "time_error", own, said, ESTIMATE_SHARE * said + slack)]


def check_velocity(step: int, own: Floats, recorded: Floats, slack: float) -> Check:
    """Largest difference of a component [m/s] against 0.

    @param slack  [m/s] allowed besides the share of the largest recorded component
    """
    allowed = VELOCITY_SHARE * np.abs(recorded).max() + slack
    return Check(step, "velocity", float(np.abs(own - recorded).max()), 0.0, float(allowed))


def velocity_slack(state: State, x: Floats, dt: float) -> float:
    """[m/s] what moves a residual by 1e-6, plus what rounded positions leave in the quotient."""
    return RESIDUAL_FLOOR * state.g_ref * dt + ROUND_OFF * float(np.abs(x).max()) / dt


def check_loads(loading: Loading, step: int, x: Floats, v: Floats) -> list[Check]:
    """Largest difference of a component of the load at the end of a step [N] against 0: rounding, and
    what moves the residual by no more than its own comparison allows of the tolerance.

    @param v  velocities that the scheme gives
    """
    if not loading.changes:
        return []
    recorded = loading.body_at(step).traction
    off = float(np.abs(loading.own(step, x, v) - recorded).max())
    left = RESIDUAL_SHARE * float(loading.state.steps["tolerance"][step]) * loading.state.g_ref
    return [Check(step, "load", off, 0.0,
                  LOAD_SHARE * float(np.abs(recorded).max()) + left * float(loading.body.mass.max()))]


def check_bonds(step: int, own: Floats, recorded: Floats, x: Floats) -> Check:
    """Largest difference of a component of the slip that is held [m] against 0."""
    slack = ROUND_OFF * float(np.abs(x).max())
    return Check(step, "bonds", float(np.abs(own - recorded).max(initial=0.0)), 0.0,
                 BOND_SHARE * float(np.abs(recorded).max(initial=0.0)) + slack)


def energies(state: State, body: Body, found: Potential, x: Floats, v: Floats) -> dict[str, float]:
    """The referee's energies [J] by the name that follows `energy_` in the file."""
    moves = state.grid["pinned"] != 1 if state.is_network else 1
    return {
        "kinetic": float((body.mass * moves) @ (v * v).sum(1) / 2),
        "elastic": found.elastic,
        "hourglass": found.hourglass,
        "gravity": float(-body.mass @ (x @ state.gravity)),
        "contact": found.contact,
    }


def check_energies(state: State, own: list[dict[str, float]]) -> Iterator[Check]:
    """Recorded energies within 1 %, or 1e-6 of the largest energy of the run.

    @param own  one entry a step, from energies()
    """
    names = [name for name in own[0] if f"energy_{name}" in state.steps]
    require(bool(names), f"no recorded energy is one of {list(own[0])}")
    values = {name: np.array([entry[name] for entry in own]) for name in names}
    recorded = {name: state.steps[f"energy_{name}"].astype(float) for name in names}
    if "gravity" in names:
        values["gravity"] -= values["gravity"][0]
        recorded["gravity"] -= recorded["gravity"][0]
    scale = max((float(np.abs(array).max()) for array in recorded.values()), default=0.0)
    for name in names:
        for step, (a, b) in enumerate(zip(values[name], recorded[name])):
            allowed = max(ENERGY_SHARE * abs(b), ENERGY_FLOOR * scale)
            yield Check(step, f"energy_{name}", float(a), float(b), allowed)


def check_masses(state: State) -> tuple[Check, dict[str, float]]:
    """Nodal masses against rho phi h^3 Nbar with one factor a material; the factors by name."""
    factors, error = equations.mass_factors(state)
    used = set(np.unique(state.grid["material"]))
    named = {f"{i}:{m.name}": float(factors[i]) for i, m in enumerate(state.materials) if i in used}
    if min(named.values()) <= 0:
        error = float("inf")
    return Check(-1, "mass", error, 0.0, MASS_SHARE), named


def check_tables(state: State) -> list[Check]:
    """Tables of nets against the nets: error of the stress over the local stress."""
    return [Check(-1, f"table of net {m}", 0.0, table_error(net, material.law, material.poisson),
                  TABLE_SHARE)
            for m, (net, material) in enumerate(zip(state.nets, state.materials))
            if net and net.cells]


def read_record(state: State, record: int) -> tuple[Floats, Floats]:
    """Positions [m] and velocities [m/s] of one record, (nodes, 3)."""
    x, v = state.x[record], state.v[record]
    require(np.isfinite(x).all() and np.isfinite(v).all(),
            f"/steps: x or v of record {record} has values that are not finite")
    return x, v


def judge(state: State, with_energies: bool) -> Verdict:
    """Recomputes all steps of a state file, reading one record at a time."""
    if state.words["time_scheme"] == "static":
        return judge_static(state, with_energies)
    if state.has_stages:
        return judge_stages(state, with_energies)
    body = equations.make_body(state)
    mass_check, factors = check_masses(state)
    holding, loading = Holding(state, body), Loading(state, body)
    checks, own_energies = [mass_check, *check_tables(state)], []
    x_before, v_before = None, None
    x, v = read_record(state, 0)
    checks += check_held(holding, -1, x, v)
    for step, scheme in enumerate(state.steps["scheme"]):
        motion = Motion(x, v, x_before, v_before) if scheme else Motion(x, v)
        x_next, v_next = read_record(state, step + 1)
        found = equations.potential(loading.body_at(step), motion, state.gravity, state.dt, x_next,
                                    equations.rotations(body, x))
        k, weight = (state.dt * 2 / 3, -1 / 3) if scheme else (state.dt, 0.0)
        before = damping.base(body, x, weight, motion.x_before)
        found = found.with_damping(*damping.damping(body, before, k, x_next))
        if state.contact is not None:
            found = found.with_contact(*collision.contact(state, step, x, x_next))
        checks += check_residual(state, step, equations.residual(body, found.gradient, state.g_ref))
        checks += check_held(holding, step, x_next, v_next)
        checks += check_reactions(holding, step, found, x_next)
        velocity = equations.velocity(motion, x_next, state.dt)
        velocity = np.where(holding.carried[:, None], v_next, velocity)  # checked as held
        checks.append(check_velocity(step, velocity, v_next, velocity_slack(state, x_next, state.dt)))
        checks += check_loads(loading, step, x_next, v_next)
        own_energies.append(energies(state, body, found, x_next, v_next))
        x_before, v_before, x, v = x, v, x_next, v_next
    return verdict_of(state, checks, own_energies, factors, with_energies)


def judge_stages(state: State, with_energies: bool) -> Verdict:
    """Recomputes the stages of each step of a run by sdirk2 or auto."""
    body = equations.make_body(state)
    pieces = find_pieces(state, body)
    mass_check, factors = check_masses(state)
    holding, loading = Holding(state, body), Loading(state, body)
    checks, own_energies = [mass_check, *check_tables(state)], []
    touched: list[bool] = []
    start = Start(*read_record(state, 0))
    checks += check_held(holding, -1, start.x, start.v)
    for step, length in enumerate(state.steps["length"]):
        x, v = read_record(state, step + 1)
        own = StageStep(state, body, pieces, step, start).recompute(x, v)
        touched.append(own.touches)
        rounded = own.off + ROUND_OFF * float(np.abs(v).max()) * float(length)
        checks += check_time_error(state, step, own.rough, any(touched[-3:]), rounded)
        checks += check_residual(state, step, own.residual, own.slack)
        checks += check_held(holding, step, x, v)
        checks += check_reactions(holding, step, own.found, x)
        if state.steps["scheme"][step] == SDIRK2:
            checks += check_stage(holding, step, state.x_stage[step])
        follows = body.loose | body.dependent[:, None]
        checks += check_loads(loading, step, x, np.where(follows, own.by_scheme, v))
        if not state.steps["guarded"][step]:
            # those of moved components are no result of the step
            recorded = np.where(follows, v, own.velocity) if state.moved else v
            checks.append(check_velocity(step, own.velocity, recorded,
                                         velocity_slack(state, x, own.k)))
        if own.bonds is not None:
            checks.append(check_bonds(step, own.bonds, state.contact["bonds"][step + 1], x))
        own_energies.append(energies(state, body, own.found, x, v))
        start = Start(x, v, start.x, start.v, float(length))
    return verdict_of(state, checks, own_energies, factors, with_energies)


def judge_static(state: State, with_energies: bool) -> Verdict:
    """Recomputes the equilibrium of a static run, whose time is the load factor."""
    body = equations.make_body(state)
    mass_check, factors = check_masses(state)
    require(len(state.steps["time"]) == 2, "a static run must have one step")
    (_, _), (x, v) = read_record(state, 0), read_record(state, 1)
    held = check_held(Holding(state, body), 0, x, v)
    found, own = equations.equilibrium(body, state.gravity, float(state.steps["time"][1]), x)
    checks = [mass_check, *held, *check_residual(state, 0, own),
              check_velocity(0, np.zeros_like(v), v, 0.0)]
    return verdict_of(state, checks, [energies(state, body, found, x, v)], factors, with_energies)


def verdict_of(state: State, checks: list[Check], own_energies: list[dict[str, float]],
               factors: dict[str, float], with_energies: bool) -> Verdict:
    """All checks, those of the energies too if they are wanted."""
    recorded = {name for name in state.steps if name.startswith("energy_")}
    if with_energies:
        checks += check_energies(state, own_energies)
    unchecked = sorted(recorded - {check.quantity for check in checks})
    guarded = int(state.steps["guarded"].sum()) if "guarded" in state.steps else 0
    return Verdict(len(state.steps["scheme"]), checks, factors, unchecked, guarded)


def summary(verdict: Verdict) -> str:
    """One line: agreement, worst residual comparison, density factors."""
    bad = {check.step for check in verdict.disagreements}
    word = f"DISAGREES ({len(verdict.disagreements)} comparisons)" if bad else "agrees"
    worst = verdict.worst("residual")
    left = [*verdict.unchecked,
            *([f"velocities of {verdict.guarded} guarded steps"] if verdict.guarded else [])]
    factors = ", ".join(f"{name} {factor:.6g}" for name, factor in verdict.factors.items())
    return (f"referee {word}: {verdict.steps - len(bad - {-1})} of {verdict.steps} steps; worst "
            f"residual: step {worst.step}, own {worst.own:.4e}, reported {worst.recorded:.4e}; "
            f"density factors: {factors}; not checked: {', '.join(left) or 'nothing'}")


def table(verdict: Verdict) -> str:
    """The worst disagreements, one a row."""
    rows = [f"{'step':>6} {'quantity':<18} {'own':>12} {'recorded':>12} {'allowed':>10} "
            f"{'excess':>9}"]
    rows += [f"{c.step if c.step >= 0 else 'file':>6} {c.quantity:<18} {c.own:>12.5e} "
             f"{c.recorded:>12.5e} {c.allowed:>10.2e} {c.excess:>9.3g}"
             for c in verdict.disagreements[:TABLE_ROWS]]
    return "\n".join(rows)


def as_json(verdict: Verdict) -> str:
    """The verdict as one JSON object; an excess that is not finite becomes null."""
    def row(check: Check) -> dict[str, Any]:
        values = asdict(check) | {"excess": check.excess}
        return {k: None if isinstance(e, float) and not np.isfinite(e) else e
                for k, e in values.items()}

    quantities = dict.fromkeys(check.quantity for check in verdict.checks)
    return json.dumps({
        "agrees": not verdict.disagreements,
        "steps": verdict.steps,
        "density_factors": verdict.factors,
        "unchecked": verdict.unchecked,
        "guarded": verdict.guarded,
        "worst": [row(verdict.worst(quantity)) for quantity in quantities],
        "disagreements": [row(check) for check in verdict.disagreements],
    })


def main(arguments: list[str]) -> int:
    """Command line; returns the exit status."""
    parser = argparse.ArgumentParser(description="recompute every step of a state file")
    parser.add_argument("state", metavar="STATE.h5")
    parser.add_argument("--energy-check", action="store_true", help="compare the energies too")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead")
    options = parser.parse_args(arguments)
    try:
        with h5py.File(options.state, "r") as file, np.errstate(all="ignore"):
            verdict = judge(read_state(file), options.energy_check)
    except (LayoutError, OSError) as error:
        problem = f"{options.state}: {error}"
        print(json.dumps({"agrees": False, "error": problem}) if options.json else
              f"referee DISAGREES: {problem}")
        return 1
    print(as_json(verdict) if options.json else summary(verdict))
    if verdict.disagreements and not options.json:
        print(table(verdict))
    return 1 if verdict.disagreements else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
