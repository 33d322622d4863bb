# SPDX-License-Identifier: Apache-2.0
"""Comparisons of the referee (referee.py), and those of what is held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equations import Potential
from holding import Holding
from state_file import Floats

RESIDUAL_FLOOR = 1e-6
ROUND_OFF = 16 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Check:
    """One comparison; `step` is the entry in the arrays of /steps, -1 for the whole file."""

    step: int
    quantity: str
    own: float
    recorded: float
    allowed: float  # of |own - recorded|

    @property
    def excess(self) -> float:
        """|own - recorded| / allowed; above 1 they disagree. Infinite where it is no number."""
        difference = abs(self.own - self.recorded)
        if difference == 0:
            return 0.0
        ratio = difference / self.allowed if self.allowed > 0 else np.inf
        return float(ratio) if np.isfinite(ratio) else float("inf")


def check_held(holding: Holding, step: int, x: Floats, v: Floats) -> list[Check]:
    """Places [m] and velocities [m/s] of what is held at the end of a step; -1: at the start.

    Dependent nodes against what their parent nodes and the holder make of them, holders against one
    rigid motion each, to rounding.
    """
    body, checks = holding.body, []
    slack = ROUND_OFF * float(np.abs(x).max())
    if body.dependent.any():
        u = x - body.rest
        off = float(np.abs(body.follow(u) + holding.offset(step + 1) - u).max())
        checks.append(Check(step, "dependent nodes", off, 0.0, slack))
    if holding.parts:
        checks += [Check(step, "held places", holding.off_motion(x, step + 1), 0.0, holding.reach * slack),
                   Check(step, "held velocities", holding.off_velocity(x, v), 0.0,
                         ROUND_OFF * float(np.linalg.norm(v)))]
    return checks


def check_stage(holding: Holding, step: int, x: Floats) -> list[Check]:
    """What is held at the end of a first stage. The file has no offsets of that time; those that the
    dependent nodes have must, with the pinned nodes, be of one rigid motion of each holder."""
    if not holding.parts:
        return []
    slack = holding.reach * ROUND_OFF * float(np.abs(x).max())
    return [Check(step, "held places of stage", holding.off_motion(x, None), 0.0, slack)]


def check_reactions(holding: Holding, step: int, found: Potential, x: Floats) -> list[Check]:
    """Reactions at the end of a step. Gradients that differ by what residuals may differ by, 1e-6 of
    the weight in their 2-norm, move them by no more than this times the norm of the lever arms."""
    steps = holding.state.steps
    if not holding.parts or "reaction_force" not in steps:
        return []
    checks = [Check(step, "reaction_about", holding.off_about(step, x), 0.0, ROUND_OFF * float(np.abs(x).max()))]
    for name, own, slack in zip(("force", "moment"), holding.reactions(step, found, x), holding.slack(step, x)):
        off = np.linalg.norm(own - steps[f"reaction_{name}"][step], axis=1)
        worst = int(np.argmax(off / np.where(slack > 0, slack, np.where(off > 0, 1e-300, 1.0))))
        checks.append(Check(step, f"reaction_{name}", float(off[worst]), 0.0, RESIDUAL_FLOOR * float(slack[worst])))
    return checks
