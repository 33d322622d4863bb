# SPDX-License-Identifier: Apache-2.0
"""Damping of voxels in float64, from the definitions in docs/formats.md.

    D = sum_v W_v beta (mu |E - E_b|^2 + lambda/2 tr(E - E_b)^2)
      + beta times the strain-variance energy at A - A_b,        beta = tau / k,
    E = (F^T F - I)/2,   A_p = F^T q_p

E_b = E(x) + w (E(x_other) - E(x)), A_b likewise: what the rate of a step or stage is measured from.
"""

from __future__ import annotations

import numpy as np

from equations import Block, Body, deformation_gradient
from state_file import Floats

Strain = tuple[Floats, Floats]  # of a block: E (n, 3, 3), A (n, 4, 3) in the units of Block.patterns


def _moved(block: Block, u: Floats) -> tuple[Floats, Floats]:
    """F (n, 3, 3) and the patterns of the displacement (n, 4, 3)."""
    return deformation_gradient(block, u), block.patterns @ u[block.corners]


def strains(body: Body, x: Floats) -> list[Strain]:
    """E and A of every block at positions x [m]."""
    result = []
    for block in body.blocks:
        F, a = _moved(block, x - body.rest)
        result.append(((F.transpose(0, 2, 1) @ F - np.eye(3)) / 2, a @ F))
    return result


def base(body: Body, x: Floats, weight: float, other: Floats | None) -> list[Strain]:
    """E_b and A_b of every block from positions x at the start and those of another point."""
    start = strains(body, x)
    if weight == 0 or other is None:
        return start
    return [(E + weight * (E_o - E), A + weight * (A_o - A))
            for (E, A), (E_o, A_o) in zip(start, strains(body, other))]


def damping(body: Body, before: list[Strain], k: float, x: Floats) -> tuple[float, Floats]:
    """D [J] at positions x and its gradient [N], (nodes, 3).

    @param before  E_b, A_b
    @param k       of the stage [s]
    """
    energy, gradient = 0.0, np.zeros_like(body.rest)
    for block, (E_b, A_b) in zip(body.blocks, before):
        beta = block.viscous_time / k
        if beta == 0:
            continue
        F, a = _moved(block, x - body.rest)
        scale = beta * block.volume[:, None, None]
        # of the mean strain
        change = (F.transpose(0, 2, 1) @ F - np.eye(3)) / 2 - E_b
        trace = np.trace(change, axis1=1, axis2=2)[:, None, None]
        S = scale * (2 * block.mu * change + block.lam * trace * np.eye(3))
        energy += float((S * change).sum() / 2)
        P = F @ S
        force = 0.0
        if body.variance:  # of what varies within the voxel
            h = body.h
            moments = np.array([h**2 / 6, h**2 / 6, h**2 / 6, h**4 / 48])
            apart = a @ F - A_b
            slope = scale * (block.weights * moments)[:, :, None] * apart
            energy += float((slope * apart).sum() / 2)
            P = P + a.transpose(0, 2, 1) @ slope
            force = block.patterns.transpose(0, 2, 1) @ (slope @ F.transpose(0, 2, 1))
        force = force + block.gradients @ P.transpose(0, 2, 1)
        for d in range(3):
            gradient[:, d] += np.bincount(block.corners.ravel(), force[:, :, d].ravel(),
                                          len(gradient))
    return energy, gradient
