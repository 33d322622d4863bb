# SPDX-License-Identifier: Apache-2.0
"""Rigid motions that carry the pieces of a body through a step, from the definitions in docs/formats.md.

Free pieces move as Newton and Euler say, as far as holds along axes admit it; pieces with pins turn about
these as they do at the start and as that changed in the step before. Dependent nodes follow their parent
nodes in all of that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from equations import Body
from state_file import Floats, Ints, State

Bools = NDArray[np.bool_]

ANGLE = 2e-3  # of a step of the integration of a free rotation [rad]
# the program's: in equal parts of at most PART [rad], each with an error up to ERROR a^5
PART, ERROR = 0.05, 0.032


@dataclass(frozen=True)
class Pieces:
    """The connected pieces of a body."""

    of: Ints  # piece of each node
    mass: Floats  # (pieces,) [kg]
    loose: list[bool]  # none of its nodes is held whole, or dependent
    stops: list[Bools]  # (3,): axes along which a node that is not is held
    pins: list[Floats | None]  # mean place of what pins it [m], None: no reference turns it


def find_pieces(state: State, body: Body) -> Pieces:
    """Voxels that share a node belong to one piece."""
    corners, label = state.grid["corners"].astype(np.int64), np.arange(len(body.rest))
    while True:
        least = label[corners].min(1)
        new = label.copy()
        np.minimum.at(new, corners.ravel(), np.repeat(least, 8))
        new = new[new]
        if (new == label).all():
            break
        label = new
    of = np.unique(label, return_inverse=True)[1]
    count = int(of.max()) + 1
    held = ~body.loose
    whole = held.all(1)  # pinned nodes, and dependent ones, X - sum w X_m with the weight 1 - sum w
    nodes, parents, weights = body.parents
    share, point = whole.astype(float), np.where(whole[:, None], body.rest, 0.0)
    np.subtract.at(share, nodes, weights)
    np.subtract.at(point, nodes, weights[:, None] * body.rest[parents])
    loose, stops, pins = [], [], []
    for p in range(count):
        mine = of == p
        loose.append(not whole[mine].any())
        stops.append((held & ~whole[:, None])[mine].any(0))
        pins.append(None if state.moved or loose[p] else point[mine].sum(0) / share[mine].sum())
    return Pieces(of, np.bincount(of, body.mass), loose, stops, pins)


@dataclass(frozen=True)
class Momenta:
    """A piece at one time: centre [m], its velocity [m/s], angular momentum and moments about it."""

    centre: Floats
    velocity: Floats
    spin: Floats  # [kg m^2/s]
    inertia: Floats  # (3, 3) [kg m^2]


def momenta(mass: Floats, x: Floats, v: Floats) -> Momenta:
    """Of point masses."""
    centre, velocity = (mass @ x) / mass.sum(), (mass @ v) / mass.sum()
    r = x - centre
    spin = mass @ np.cross(r, v - velocity)
    inertia = (mass * (r * r).sum(1)).sum() * np.eye(3) - np.einsum("n,ni,nj->ij", mass, r, r)
    return Momenta(centre, velocity, spin, inertia)


def per_inertia(inertia: Floats, stops: Bools) -> Floats:
    """(3, 3): what makes of an angular momentum the angular velocity that holds along axes admit."""
    if not stops.any():
        return np.linalg.inv(inertia)
    about = np.diag(stops.astype(float)) if stops.sum() == 1 else np.zeros((3, 3))
    return about / np.trace(about @ inertia @ about) if about.any() else about


def turn_about(m: Momenta, mass: float, point: Floats, stops: Bools) -> Floats:
    """Angular velocity about a point [rad/s], weighted with mass."""
    arm = m.centre - point
    inertia = m.inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return per_inertia(inertia, stops) @ (m.spin + mass * np.cross(arm, m.velocity))


def skew(w: Floats) -> Floats:
    """[w], [w] r = w x r."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def turned(axis: Floats, angle: float) -> Floats:
    """Rotation matrix (Rodrigues)."""
    K = skew(axis)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


@dataclass(frozen=True)
class Pose:
    """z(t) = place + R (x0 - origin), with the angular velocity and its rate."""

    origin: Floats
    place: Floats
    R: Floats
    velocity: Floats  # of `place`
    w: Floats
    w_rate: Floats

    def motion(self, x0: Floats) -> tuple[Floats, Floats, Floats]:
        """z, z', z'' of nodes that start at x0, (n, 3)."""
        r = (x0 - self.origin) @ self.R.T
        speed = np.cross(self.w, r)
        return (self.place + r, self.velocity + speed,
                np.cross(self.w_rate, r) + np.cross(self.w, speed))


def loose_pose(m: Momenta, stops: Bools, t: float) -> Pose:
    """Newton and Euler without forces: R' = [w] R, w = R I^-1 R^T L, by Runge and Kutta's method; along
    the axes that are not stopped, and about the only one that is."""
    inverse = per_inertia(m.inertia, stops)
    slide = np.where(stops, 0.0, m.velocity)
    m = replace(m, velocity=slide, spin=m.spin * (np.diag(inverse) > 0))

    def w_of(R: Floats) -> Floats:
        return R @ (inverse @ (R.T @ m.spin))

    R = np.eye(3)
    steps = 1 + int(np.linalg.norm(w_of(R)) * abs(t) / ANGLE)
    h = t / steps
    for _ in range(steps):
        a = skew(w_of(R)) @ R
        b = skew(w_of(R + h / 2 * a)) @ (R + h / 2 * a)
        c = skew(w_of(R + h / 2 * b)) @ (R + h / 2 * b)
        d = skew(w_of(R + h * c)) @ (R + h * c)
        U, _, V = np.linalg.svd(R + h / 6 * (a + 2 * b + 2 * c + d))
        R = U @ V
    w = w_of(R)
    return Pose(m.centre, m.centre + t * m.velocity, R, m.velocity, w,
                -R @ (inverse @ (R.T @ np.cross(w, m.spin))))


def pinned_pose(pin: Floats, w: Floats, gain: float, t: float) -> Pose:
    """A turn about a point by |w| t + gain t^2/2 about the axis of w."""
    rate, still = float(np.linalg.norm(w)), np.zeros(3)
    if rate == 0:
        return Pose(pin, pin, np.eye(3), still, still, still)
    axis = w / rate
    return Pose(pin, pin, turned(axis, rate * t + gain * t * t / 2), still,
                (rate + gain * t) * axis, gain * axis)


@dataclass(frozen=True)
class Start:
    """What a step begins with: the start, the start of the step before and that step's length."""

    x: Floats
    v: Floats
    x_before: Floats | None = None
    v_before: Floats | None = None
    h_before: float = 0.0


class Reference:
    """z of all nodes in one step."""

    def __init__(self, body: Body, pieces: Pieces, start: Start) -> None:
        self.body, self.pieces, self.x0 = body, pieces, start.x
        self.now = [self._momenta(body, p, start.x, start.v) for p in range(len(pieces.mass))]
        self.turns: list[tuple[Floats, float] | None] = []
        for p, pin in enumerate(pieces.pins):
            self.turns.append(None if pin is None else self._turn(body, p, pin, start))

    def _momenta(self, body: Body, p: int, x: Floats, v: Floats) -> Momenta:
        mine = self.pieces.of == p
        return momenta(body.mass[mine], x[mine], v[mine])

    def _turn(self, body: Body, p: int, pin: Floats, start: Start) -> tuple[Floats, float]:
        mass, stops = float(self.pieces.mass[p]), self.pieces.stops[p]
        w = turn_about(self.now[p], mass, pin, stops)
        rate = float(np.linalg.norm(w))
        if start.x_before is None or start.v_before is None or rate == 0:
            return w, 0.0
        m = self._momenta(body, p, start.x_before, start.v_before)
        last = turn_about(m, mass, pin, stops)
        return w, float((w - last) @ w) / (rate * start.h_before)

    def at(self, t: float) -> tuple[Floats, Floats, Floats]:
        """z, z', z'' at a time after the start of the step."""
        z, v, a = self.x0.copy(), np.zeros_like(self.x0), np.zeros_like(self.x0)
        follow = self.body.follow
        for p, turn in enumerate(self.turns):
            mine, pin = self.pieces.of == p, self.pieces.pins[p]
            if self.pieces.loose[p]:
                pose = loose_pose(self.now[p], self.pieces.stops[p], t)
                z[mine], v[mine], a[mine] = pose.motion(self.x0[mine])
            elif pin is not None and turn is not None:
                z[mine], v[mine], a[mine] = pinned_pose(pin, *turn, t).motion(self.x0[mine])
        return self.x0 + follow(z - self.x0), follow(v), follow(a)

    def rounding(self, t: float) -> Floats:
        """(nodes,) how far z of the program may be off at a time, by its integration [m]."""
        result = np.zeros(len(self.x0))
        for p in np.flatnonzero(self.pieces.loose):
            mine, m = self.pieces.of == p, self.now[p]
            w = per_inertia(m.inertia, self.pieces.stops[p]) @ m.spin
            angle = float(np.linalg.norm(w)) * abs(t)
            parts = 1 + int(angle / PART)
            off = parts * ERROR * (angle / parts) ** 5
            result[mine] = off * np.linalg.norm(self.x0[mine] - m.centre, axis=1)
        return result
