# SPDX-License-Identifier: Apache-2.0
"""Contact with colliders in float64, from the definitions in docs/formats.md.

    E = sum_pc k_p b(d_pc/D) + mu_c N_pc f(|slip_pc|),   k_p = area_p E D^2/h,
    b(s) = -(1-s)^2 ln s for s < 1, else 0;   f(y) = -y^3/(3e^2) + y^2/e + e/3 for y < e, else y

d_pc is the distance of a point from the core of a collider: a plane D below, a sphere of radius
max(r - D, 0), a box of half edges max(half - D, 0). Written with vectors to the nearest point of
the core, whatever the shape. Stages have friction of another kind, bonds: bonded_contact().
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from state_file import PLANE, SPHERE, Floats, Ints, State

BOND = 10  # stiffness of friction that holds, in units of A E/h


def nearest(state: State, collider: int, offset: Floats, places: Floats) -> Floats:
    """(points, 3) from the nearest point of a collider's core to each place; nan inside of it."""
    contact, layer = state.contact, float(state.contact["layer"])
    away = places - contact["centre"][collider] - offset
    shape = contact["shape"][collider]
    if shape == PLANE:
        height = away @ contact["normal"][collider] + layer
        return np.outer(np.where(height > 0, height, np.nan), contact["normal"][collider])
    if shape == SPHERE:
        radius = max(contact["radius"][collider] - layer, 0.0)
        length = np.linalg.norm(away, axis=1, keepdims=True)
        return np.where(length > radius, away * (1 - radius / length), np.nan)
    half = np.maximum(contact["half"][collider] - layer, 0)
    gap = away - np.clip(away, -half, half)
    return np.where(gap.any(1, keepdims=True), gap, np.nan)


def barrier(s: Floats) -> tuple[Floats, Floats]:
    """b(s) and b'(s); below the cut b is its Taylor polynomial of second degree."""
    cut = 1e-3
    outside = s >= 1
    t = np.clip(np.where(outside, 1.0, s), cut, None)
    curvature = -2 * np.log(t) + 4 * (1 - t) / t + (1 - t) ** 2 / t**2
    below = np.minimum(s - cut, 0)
    value, slope = -(1 - t) ** 2 * np.log(t), 2 * (1 - t) * np.log(t) - (1 - t) ** 2 / t
    value, slope = value + below * (slope + below / 2 * curvature), slope + below * curvature
    return np.where(outside, 0.0, value), np.where(outside, 0.0, slope)


def smooth_length(y: Floats, e: float) -> tuple[Floats, Floats]:
    """f(y) and f'(y)/y."""
    near, safe = y < e, np.maximum(y, e)
    return (np.where(near, -y**3 / (3 * e * e) + y * y / e + e / 3, y),
            np.where(near, 2 / e - y / (e * e), 1 / safe))


def _pressed(state: State, collider: int, offset: Floats, places: Floats,
             stiffness: Floats) -> tuple[Floats, Floats, Floats]:
    """Barrier energy, normal force (both (points,)) and normal (points, 3)."""
    layer = float(state.contact["layer"])
    gap = nearest(state, collider, offset, places)
    distance = np.linalg.norm(gap, axis=1)
    value, slope = barrier(distance / layer)
    return stiffness * value, -stiffness * slope / layer, gap / distance[:, None]


def carriers(state: State) -> tuple[Ints, Floats]:
    """Corners that carry each point (points, 8), and the stiffness A kappa of its barrier [J]."""
    c = state.contact
    held = [max(m.young, 8 * m.density * float(c["impact_speed"]) ** 2) for m in state.materials]
    young = np.array(held)[state.grid["material"][c["voxel"]]]
    return (state.grid["corners"][c["voxel"]].astype(np.int64),
            c["area"] * young * float(c["layer"]) ** 2 / state.h)


def contact(state: State, step: int, x: Floats, x_next: Floats) -> tuple[float, Floats]:
    """Energy [J] of contact at the end of a step and its gradient [N], (nodes, 3).

    @param x, x_next  positions [m] at the start and the end of the step, (nodes, 3)
    """
    c = state.contact
    corners, stiffness = carriers(state)
    start, end = (np.einsum("pk,pki->pi", c["weights"], y[corners]) for y in (x, x_next))
    energy, force = 0.0, np.zeros_like(end)
    for k, friction in enumerate(c["friction"]):
        before, after = c["offset"][step, k], c["offset"][step + 1, k]
        _, lagged, axis = _pressed(state, k, before, start, stiffness)
        value, push, normal = _pressed(state, k, after, end, stiffness)
        energy += value.sum()
        force -= push[:, None] * normal
        slip = end - start - (after - before)
        slip = slip - (slip * axis).sum(1)[:, None] * axis
        f, slope = smooth_length(np.linalg.norm(slip, axis=1), float(c["slip_range"]))
        energy += friction * float(lagged @ f)
        force += (friction * lagged * slope)[:, None] * slip
    return float(energy), to_nodes(state, corners, force)


def to_nodes(state: State, corners: Ints, force: Floats) -> Floats:
    """Forces on points [N], (points, 3), on the nodes that carry them, (nodes, 3)."""
    result = np.zeros_like(state.grid["rest"])
    for d in range(3):
        shares = state.contact["weights"] * force[:, d, None]
        result[:, d] = np.bincount(corners.ravel(), shares.ravel(), len(result))
    return result


@dataclass(frozen=True)
class Bonded:
    """Contact at the end of a stage."""

    energy: float  # [J]
    gradient: Floats  # [N], (nodes, 3)
    nodes: Ints  # a node that carries each point
    places: Floats  # of the points [m], (points, 3)
    force: Floats  # on the points, from the gradient with the other sign [N], (points, 3)
    bonds: Floats  # slip that is held from there on [m], (colliders, points, 3)


def _limited(slip: Floats, longest: Floats) -> Floats:
    """Slips (points, 3), none longer than its `longest`."""
    size = np.linalg.norm(slip, axis=1)
    return slip * np.where(size > longest, longest / np.where(size > 0, size, 1), 1)[:, None]


def bonded_contact(state: State, bonds: Floats, x: Floats, x_end: Floats, before: Floats,
                   after: Floats) -> Bonded:
    """Contact at the end of a stage, with friction as a bond:

        E = sum_pc k_p b(d_pc/D) + mu_c N_pc f(|s_pc|),
        f(y) = y^2/(2 e) for y < e, else y - e/2,     e = mu_c N_pc / k_t,   k_t = 10 A_p E/h.

    N and the normal are those of the stage's own end. s is the motion of the point since the start
    of the step, relative to the collider, plus what it held there, across the normal.

    @param bonds          slip held at the start of the step [m], (colliders, points, 3)
    @param x, x_end       positions at the start of the step and the end of the stage [m]
    @param before, after  offsets of the colliders there [m], (colliders, 3)
    """
    c = state.contact
    corners, stiffness = carriers(state)
    hold = BOND * stiffness / float(c["layer"]) ** 2  # k_t
    start, end = (np.einsum("pk,pki->pi", c["weights"], y[corners]) for y in (x, x_end))
    energy, force, kept = 0.0, np.zeros_like(end), np.zeros_like(bonds)
    for k, friction in enumerate(c["friction"]):
        value, push, normal = _pressed(state, k, after[k], end, stiffness)
        energy += value.sum()
        force += push[:, None] * normal
        limit = friction * push
        rubs = limit > 0
        axis = np.where(rubs[:, None], normal, 0.0)

        def across(slip: Floats) -> Floats:
            return np.where(rubs[:, None], slip - (slip * axis).sum(1)[:, None] * axis, 0.0)

        longest = np.where(rubs, limit / hold, 0.0)
        held = _limited(across(bonds[k]), longest)
        slip = across(end - start - (after[k] - before[k]) + held)
        y, e = np.linalg.norm(slip, axis=1), np.where(rubs, longest, 1.0)
        energy += float((limit * np.where(y < e, y * y / (2 * e), y - e / 2))[rubs].sum())
        force -= np.where(rubs, limit / np.maximum(y, e), 0.0)[:, None] * slip
        kept[k] = _limited(slip, longest)
    return Bonded(float(energy), -to_nodes(state, corners, force), corners[:, 0], end, force, kept)
