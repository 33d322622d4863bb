# SPDX-License-Identifier: Apache-2.0
"""What holders do, from the definitions in docs/formats.md: the places of nodes, and reactions.

A holder moves the points that it holds as one rigid motion, x = A X + b. A dependent node i follows its
parent nodes m in what they move beyond it, and so has beside them

    offset_i = u_i - sum_m w_im u_m = (A - I) p_i + s_i b,     p_i = X_i - sum_m w_im X_m,   s_i = 1 - sum_m w_im.

The motion itself is not in the file. It is fitted to what is held, in which one motion must leave nothing over;
pinned nodes are p = X, s = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import equations
from equations import Body, Potential
from state_file import Floats, Ints, State

FLAT = 1e-6  # share of the largest extent that counts as none


@dataclass(frozen=True)
class Fit:
    """The rigid motion A p + s b that is nearest to places."""

    A: Floats  # (3, 3), a rotation
    b: Floats  # [m]
    off: float  # the largest distance from a place [m]
    is_unique: bool

    def move(self, X: Floats) -> Floats:
        """A point that the holder would hold [m]."""
        return self.A @ X + self.b


def fit_motion(p: Floats, s: Floats, q: Floats) -> Fit:
    """Least squares of q - A p - s b over rotations A and shifts b (Kabsch, with shares s)."""
    total = float(s @ s)
    mean_p, mean_q = ((s @ y) / total if total > 0 else np.zeros(3) for y in (p, q))
    U, size, V = np.linalg.svd((q - np.outer(s, mean_q)).T @ (p - np.outer(s, mean_p)))
    flip = np.array([1, 1, np.sign(np.linalg.det(U) * np.linalg.det(V))])
    A = (U * flip) @ V
    b = mean_q - A @ mean_p
    off = q - p @ A.T - np.outer(s, b)
    return Fit(A, b, float(np.linalg.norm(off, axis=1).max()), bool(size[1] > FLAT**2 * size[0]))


def fit_velocity(x: Floats, v: Floats) -> float:
    """What the nearest velocities V + w x r leave over, the largest component [m/s]."""
    r = x - x.mean(0)
    r = r / max(float(np.abs(r).max()), 1e-300)  # w is of another unit then
    table = np.zeros((len(r), 3, 6))
    table[:, :, :3] = np.eye(3)
    table[:, :, 3:] = -np.cross(r[:, None, :], np.eye(3))  # column j is e_j x r
    U, size, _ = np.linalg.svd(table.reshape(-1, 6), full_matrices=False)
    U = U[:, size > FLAT * size[0]]
    return float(np.abs(v.ravel() - U @ (U.T @ v.ravel())).max())


@dataclass(frozen=True)
class Part:
    """What one holder holds."""

    pinned: Ints  # nodes
    followers: Ints  # dependent nodes
    rows: Ints  # of these in /holders/offset
    p: Floats  # (pinned and followers, 3) [m]
    s: Floats
    rests: bool

    @property
    def nodes(self) -> Ints:
        """All of them."""
        return np.concatenate([self.pinned, self.followers])


@dataclass(frozen=True)
class AxesPart:
    """What one holder holds along some axes."""

    holder: int
    nodes: Ints
    mask: NDArray[np.bool_]  # (nodes, 3)


class Holding:
    """The holders of a state file; there are none where it does not name them."""

    def __init__(self, state: State, body: Body) -> None:
        self.state, self.body = state, body
        followers = np.flatnonzero(body.dependent)
        self.p, self.s = self.beyond(body.rest), self.beyond(np.ones_like(body.rest))
        # by rounded positions an offset is off by so many of their roundings
        sums = np.bincount(body.parents[0], np.abs(body.parents[2]), len(body.rest))
        self.reach = 1 + float(sums.max())
        self.parts: list[Part] = []
        held = state.holders
        for h in range(len(held.names) if held else 0):
            pinned = np.flatnonzero((held.of_node == h) & ~body.dependent)
            rows = np.flatnonzero(held.of_node[followers] == h)
            nodes = np.concatenate([pinned, followers[rows]])
            self.parts.append(Part(pinned, followers[rows], rows, self.p[nodes], self.s[nodes, 0], held.rests(h)))
        self.axes: list[AxesPart] = []
        if held and held.of_component is not None:
            for h in range(len(held.names)):
                mask = held.of_component == h
                if mask.any():
                    nodes = np.flatnonzero(mask.any(1))
                    self.axes.append(AxesPart(h, nodes, mask[nodes]))
        self.weighing = self._weighing() if "reaction_force" in state.steps else np.zeros(0)

    def beyond(self, values: Floats) -> Floats:
        """Values, those of dependent nodes less what these have from their parent nodes."""
        return np.where(self.body.dependent[:, None], values - self.body.follow(values), values)

    def _weighing(self) -> Floats:
        """(nodes,) mass of the voxels that are not wholly pinned [kg]."""
        grid = self.state.grid
        factor = equations.mass_factors(self.state)[0]
        density = factor * np.array([m.density for m in self.state.materials])
        whole = (grid["pinned"][grid["corners"]] == 1).all(1)
        mass = np.where(whole, 0, density[grid["material"]] * grid["fill"] * self.state.h**3)
        return np.bincount(grid["corners"].ravel(), (mass[:, None] * grid["shape_mean"]).ravel(), len(grid["mass"]))

    @property
    def carried(self) -> NDArray[np.bool_]:
        """(nodes,): pinned nodes, of the network, whose velocities are those of a holder."""
        mask = np.zeros(len(self.body.rest), bool)
        for part in self.parts if self.state.is_network else []:
            mask[part.pinned] = True
        return mask

    def _accelerations(self, step: int, x: Floats) -> Floats:
        """Of pinned nodes that go with their holders, at the end of a step [m/s^2]."""
        result, motion = np.zeros_like(x), self.state.holders.motion if self.state.holders else None
        for h, part in enumerate(self.parts if motion else []):
            rate, change = motion["rate"][step + 1, h], motion["change"][step + 1, h]
            arm = x[part.pinned] - motion["centre"][h]
            turned = np.cross(change, arm) + np.cross(rate, np.cross(rate, arm))
            result[part.pinned] = turned if motion["turns"][h] else change
        return result

    def offset(self, record: int) -> Floats:
        """What dependent nodes have beside their parent nodes at an entry [m], (nodes, 3)."""
        result = np.zeros_like(self.body.rest)
        if self.state.holders is not None and self.state.holders.offset is not None:
            result[self.body.dependent] = self.state.holders.offset[record]
        return result

    def _places(self, part: Part, x: Floats, offset: Floats) -> Floats:
        """What A p + s b must be, where dependent nodes have these offsets [m]."""
        return np.concatenate([x[part.pinned], self.p[part.followers] + offset[part.followers]])

    def off_motion(self, x: Floats, record: int | None) -> float:
        """How far what is held is from a rigid motion of each holder, at rest of pins [m].

        @param record  whose offsets count; None: those that the nodes have at x, of a stage
        """
        offset = self.beyond(x - self.body.rest) if record is None else self.offset(record)
        worst = 0.0
        for part in (part for part in self.parts if len(part.nodes)):
            q = self._places(part, x, offset)
            still = part.rests or (self.state.has_stages and not self.state.moved)
            worst = max(worst, float(np.abs(q - part.p).max()) if still else fit_motion(part.p, part.s, q).off)
        for axes in self.axes:
            worst = max(worst, float(np.abs((x - self.body.rest)[axes.nodes][axes.mask]).max()))
        return worst

    def off_velocity(self, x: Floats, v: Floats) -> float:
        """How far velocities of pinned nodes are from rigid ones, of pins from 0 [m/s]; finite elements
        have those of their scheme where something moves."""
        worst = 0.0
        for part in (part for part in self.parts if len(part.pinned) and (part.rests or self.state.is_network)):
            mine = v[part.pinned]
            worst = max(worst, float(np.abs(mine).max()) if part.rests else fit_velocity(x[part.pinned], mine))
        for axes in self.axes:
            worst = max(worst, float(np.abs(v[axes.nodes][axes.mask]).max()))
        return worst

    def off_about(self, step: int, x: Floats) -> float:
        """How far the points of moments are from the mean of what is held, or a centre of its turn [m]."""
        worst = 0.0
        for part, about in zip(self.parts, self.state.steps["reaction_about"][step]):
            if not len(part.nodes):
                continue
            off = float(np.abs(about - x[part.nodes].mean(0)).max())
            fit = fit_motion(part.p, part.s, self._places(part, x, self.offset(step + 1)))
            if not part.rests:
                off = min(off, float(np.abs(fit.move(about) - about).max()) if fit.is_unique else 0.0)
            worst = max(worst, off)
        for axes in self.axes:
            about = self.state.steps["reaction_about"][step][axes.holder]
            worst = max(worst, float(np.abs(about - x[axes.nodes].mean(0)).max()))
        return worst

    def reactions(self, step: int, found: Potential, x: Floats) -> tuple[Floats, Floats]:
        """Force [N] of each holder, and its moment [N m] about the point in the file, both (holders, 3)."""
        pull = self.state.gravity - self._accelerations(step, x)
        away = found.gradient - found.inertial - self.weighing[:, None] * pull
        lever = self.beyond(x)
        force, moment = np.zeros((2, len(self.parts), 3))
        for h, (part, about) in enumerate(zip(self.parts, self.state.steps["reaction_about"][step])):
            f = np.concatenate([away[part.pinned], found.gradient[part.followers]])
            force[h] = part.s @ f
            moment[h] = np.cross(lever[part.nodes] - np.outer(part.s, about), f).sum(0)
        # along axes, with what dependent nodes bring
        brought = self.body.fold(np.where(self.body.dependent[:, None], found.gradient, 0))
        for axes in self.axes:
            f = np.where(axes.mask, (away + brought)[axes.nodes], 0)
            about = self.state.steps["reaction_about"][step][axes.holder]
            force[axes.holder] = f.sum(0)
            moment[axes.holder] = np.cross(x[axes.nodes] - about, f).sum(0)
        return force, moment

    def slack(self, step: int, x: Floats) -> tuple[Floats, Floats]:
        """How far forces [N] and moments [N m] may be off where gradients are as far off as residuals may
        be by rounding, both (holders,). @see referee.RESIDUAL_FLOOR"""
        size = self.state.g_ref * np.linalg.norm(self.body.mass[self.body.free])
        lever = self.beyond(x)
        force, moment = np.zeros((2, len(self.parts)))
        for h, (part, about) in enumerate(zip(self.parts, self.state.steps["reaction_about"][step])):
            force[h] = size * np.linalg.norm(part.s)
            moment[h] = size * np.linalg.norm(lever[part.nodes] - np.outer(part.s, about))
        for axes in self.axes:
            about = self.state.steps["reaction_about"][step][axes.holder]
            force[axes.holder] = size * np.sqrt(len(axes.nodes))
            moment[axes.holder] = size * np.linalg.norm(x[axes.nodes] - about)
        return force, moment
