# SPDX-License-Identifier: Apache-2.0
"""Newton's method with the exact Hessian, a direct solver and a line search on the potential."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]
MAX_STEPS = 60
MAX_HALVINGS = 30
ARMIJO = 1e-4
ROUNDING = 1e-10  # differences of Phi below this share of its terms count as rounding


@dataclass(frozen=True)
class Potential:
    """Phi, whose minimum over the free degrees of freedom is sought.

    Displacements are (nodes, 3) [m]. `value` may be infinite; the residual is the 2-norm of the
    gradient over the free degrees of freedom divided by `force_scale`, another one of forces.
    """

    value: Callable[[Floats], float]  # [J]
    gradient: Callable[[Floats], Floats]  # [N], (nodes, 3)
    hessian: Callable[[Floats], sparse.csr_matrix]  # [N/m], of all degrees of freedom
    free: NDArray[np.bool_]  # (nodes, 3)
    force_scale: Callable[[Floats], float]  # [N]


@dataclass
class Report:
    """What a solve says of itself."""

    residual: float
    converged: bool
    newton_steps: int
    halvings: int = 0  # of steps that did not descend


def solve_linear(K: sparse.csr_matrix, f: Floats) -> Floats:
    """K^-1 f for a symmetric K."""
    factors = splu(K.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                   options={"SymmetricMode": True})
    x: Floats = factors.solve(f)
    return x


def carried_along(potential: Potential, u: Floats, target: Floats) -> Floats:
    """u with the prescribed components of target, the free ones following linearly."""
    free = potential.free.ravel()
    K = potential.hessian(u)
    motion = (target - u).ravel()
    motion[free] = 0
    load = potential.gradient(u).ravel() + K @ motion
    motion[free] = solve_linear(K[free][:, free], -load[free])
    return u + motion.reshape(u.shape)


def descends(phi: float, slope: float, trial_phi: float, trial_slope: float) -> bool:
    """Armijo's condition, or where differences of Phi drown in rounding, the same on the mean of
    the slopes at both ends."""
    if not np.isfinite(trial_phi):
        return False
    if abs(trial_phi - phi) <= ROUNDING * abs(phi):
        return (slope + trial_slope) / 2 <= ARMIJO * slope
    return trial_phi <= phi + ARMIJO * slope


def minimise(potential: Potential, u: Floats, tolerance: float) -> tuple[Floats, Report]:
    """Newton from u, whose prescribed components stay; not converging is a value."""
    free = potential.free
    phi, g = potential.value(u), potential.gradient(u)
    report = Report(np.inf, False, 0)
    while True:
        report.residual = float(np.linalg.norm(g[free])) / potential.force_scale(u)
        report.converged = report.residual <= tolerance
        if report.converged or report.newton_steps == MAX_STEPS:
            return u, report
        K = potential.hessian(u)[free.ravel()][:, free.ravel()]
        p = np.zeros_like(u)
        p[free] = solve_linear(K, -g[free])
        slope, share = float((g * p).sum()), 1.0
        if not slope < 0:  # the Hessian is not positive here
            return u, report
        for _ in range(MAX_HALVINGS):
            trial = u + share * p
            trial_phi = potential.value(trial)
            trial_g = potential.gradient(trial) if np.isfinite(trial_phi) else g
            if descends(phi, share * slope, trial_phi, share * float((trial_g * p).sum())):
                break
            share /= 2
            report.halvings += 1
        else:
            return u, report
        u, phi, g = trial, trial_phi, trial_g
        report.newton_steps += 1
