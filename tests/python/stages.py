# SPDX-License-Identifier: Apache-2.0
"""Steps made by stages in float64, from the definitions in docs/formats.md: references, predictors,
velocities with the momentum that external forces leave.

    r_n  = m_n (x'_n - xhat_n)/k^2 + ...,
    xhat = z(t) + w_d d_b + w_e e_b + w_0 e_0 + k^2 (g - z''(t)),     d = x - z,   e = v - z'

with z the rigid motion that carries a piece from the start of the step (references.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import collision
import damping
import equations
from equations import Body, Potential
from loading import Loading
from references import Pieces, Reference, Start, momenta, per_inertia
from state_file import BDF2, SDIRK2, Floats, State

SHARE = 1 - 1 / np.sqrt(2)  # of a step that SDIRK2's first stage takes
SAFETY, OF_SDIRK2 = 1.8, 0.0808  # of the estimate of the time error, and of y by SDIRK2


@dataclass(frozen=True)
class Stage:
    """Times after the start of the step [s] and weights; b is the other point, None: there is none."""

    t: float
    k: float
    t_b: float | None = None
    w_d: float = 0.0
    w_v: float = 0.0
    w_e: float = 0.0
    w_0: float = 0.0


def euler(h: float) -> Stage:
    """Implicit Euler."""
    return Stage(h, h, w_0=h)


def bdf2(h: float, before: float) -> Stage:
    """BDF2 behind a step of another length."""
    r = h / before
    k, w = (1 + r) / (1 + 2 * r) * h, -r * r / (1 + 2 * r)
    return Stage(h, k, -before, w, w, k * w, k * (1 - w))


def sdirk2(h: float) -> tuple[Stage, Stage]:
    """Both stages of SDIRK2 (Alexander 1977); the other point of the second one is the first."""
    k = SHARE * h
    return Stage(k, k, w_0=k), Stage(h, k, k, 2 * (h - k) / k, (h - k) / k, 0.0, 2 * k - h)


@dataclass(frozen=True)
class Solved:
    """The end of a stage."""

    stage: Stage
    x: Floats
    found: Potential
    velocity: Floats  # by the scheme alone
    load: Floats  # [N]
    touch: collision.Bonded | None


@dataclass(frozen=True)
class Step:
    """A step as it is recomputed."""

    residual: float  # the largest of its stages
    slack: float  # of the residual, by the integration of rotations
    off: float  # places of the reference by that [m]
    velocity: Floats
    found: Potential  # at its end
    by_scheme: Floats  # velocity before momentum is set
    k: float  # of its last stage [s]
    bonds: Floats | None  # that it leaves
    rough: float  # estimate of the time error before the filter, without that of contact [m]
    touches: bool  # a collider acts on the body in it


class StageStep:
    """Recomputes one step of a state file; `step` is its entry in the arrays of /steps."""

    def __init__(self, state: State, body: Body, pieces: Pieces, step: int, start: Start) -> None:
        self.state, self.body, self.pieces, self.step, self.start = state, body, pieces, step, start
        self.loading = Loading(state, body)
        self.reference = Reference(body, pieces, start)
        self.R = equations.rotations(body, start.x)

    def _touch(self, share: float, x_end: Floats) -> collision.Bonded | None:
        """Contact where the colliders have made a share of their path in the step."""
        c = self.state.contact
        if c is None:
            return None
        before, after = c["offset"][self.step], c["offset"][self.step + 1]
        return collision.bonded_contact(self.state, c["bonds"][self.step], self.start.x, x_end,
                                        before, before + share * (after - before))

    def _solved(self, stage: Stage, share: float, x_end: Floats, x_b: Floats | None,
                v_b: Floats | None) -> Solved:
        """@param x_b, v_b  of the other point; v_b None: that of SDIRK2's first stage"""
        s, g, h = stage, self.state.gravity, float(self.state.steps["length"][self.step])
        z, z_v, z_a = self.reference.at(s.t)
        e_0 = self.start.v - self.reference.at(0.0)[1]
        d_b = e_b = np.zeros_like(z)
        if x_b is not None and s.t_b is not None:
            other = self.reference.at(s.t_b)
            d_b = x_b - other[0]
            e_b = d_b / s.k if v_b is None else v_b - other[1]
        xhat = z + s.w_d * d_b + s.w_e * e_b + s.w_0 * e_0 + s.k**2 * (g - z_a)
        body = self.loading.body_at(self.step, of_stage=s.t < h)
        found = equations.potential_about(body, 1 / s.k**2, xhat, x_end, self.R)
        before = damping.base(self.body, self.start.x, s.w_v, x_b)
        found = found.with_damping(*damping.damping(self.body, before, s.k, x_end))
        touch = self._touch(share, x_end)
        if touch is not None:
            found = found.with_contact(touch.energy, touch.gradient)
        velocity = z_v + (x_end - z - s.w_v * d_b) / s.k
        return Solved(s, x_end, found, velocity, body.traction, touch)

    def _loads(self, p: int, solved: Solved) -> tuple[Floats, Floats]:
        """Force on a piece, but for gravity, and its torque about the centre of mass."""
        mine = self.pieces.of == p
        centre = self.body.mass[mine] @ solved.x[mine] / self.pieces.mass[p]
        f = solved.load[mine]
        force, torque = f.sum(0), np.cross(solved.x[mine] - centre, f).sum(0)
        if solved.touch is not None:
            points = self.pieces.of[solved.touch.nodes] == p
            f = solved.touch.force[points]
            force = force + f.sum(0)
            torque = torque + np.cross(solved.touch.places[points] - centre, f).sum(0)
        return force, torque

    def _corrected(self, first: Solved | None, last: Solved) -> Floats:
        """Velocities with the linear and angular momentum that external forces give loose pieces."""
        follows = self.body.loose | self.body.dependent[:, None]
        s, v = last.stage, np.where(follows, last.velocity, 0.0)
        start, before = self.start, None
        for p in np.flatnonzero(self.pieces.loose):
            mine, mass, stops = self.pieces.of == p, self.pieces.mass[p], self.pieces.stops[p]
            end, now = momenta(self.body.mass[mine], last.x[mine], v[mine]), self.reference.now[p]
            velocity, spin = now.velocity.copy(), now.spin.copy()
            if s.t_b is not None and s.t_b < 0:
                before = momenta(self.body.mass[mine], start.x_before[mine], start.v_before[mine])
                velocity += s.w_d * (before.velocity - now.velocity)
                spin += s.w_d * (before.spin - now.spin)
            for solved, time in ((first, s.t - s.k), (last, s.k)):
                if solved is not None:
                    force, torque = self._loads(p, solved)
                    velocity += time / mass * force
                    spin += time * torque
            velocity += (s.t if before is None else s.k) * self.state.gravity
            turn = per_inertia(end.inertia, stops) @ (spin - end.spin)
            slide = np.where(stops, 0.0, velocity - end.velocity)
            v[mine] += slide + np.cross(turn, last.x[mine] - end.centre)
        return v

    def _slack(self, stage: Stage) -> float:
        off = self.body.mass * self.reference.rounding(stage.t) / stage.k**2
        return equations.residual(self.body, off[:, None] * np.array([1.0, 0, 0]), self.state.g_ref)

    def _rough(self, first: Solved | None, last: Solved, v_end: Floats | None) -> float:
        """1.8 rms(y), of the piece where it is largest. @param v_end  None: by the scheme, corrected"""
        s, start = last.stage, self.start
        h, kind = s.t, float(s.t_b or 0)
        e_1 = (self._corrected(first, last) if v_end is None else v_end) - self.reference.at(h)[1]
        e_0 = start.v - self.reference.at(0.0)[1]
        if first is not None:
            e_a = first.velocity - self.reference.at(first.stage.t)[1]
            y = OF_SDIRK2 * h * (e_0 / SHARE - e_a / (SHARE * (1 - SHARE)) + e_1 / (1 - SHARE))
        elif kind < 0:
            r, e_b = -h / kind, start.v_before - self.reference.at(kind)[1]
            second = 2 * ((e_1 - e_0) / h - (e_0 - e_b) / -kind) / (h - kind)
            y = (1 + r) ** 2 / (6 * r * (1 + 2 * r)) * h**3 * second
        else:
            y = h / 2 * (e_1 - e_0)
        y = self.body.follow(np.where(self.body.loose, y, 0.0))
        squares = np.bincount(self.pieces.of, self.body.mass * (y * y).sum(1))
        return SAFETY * float(np.sqrt(squares / self.pieces.mass).max())

    def recompute(self, x_end: Floats, v_end: Floats | None = None) -> Step:
        """All stages, and the velocities at the end. @param v_end  recorded ones, for the estimate"""
        kind, h = self.state.steps["scheme"][self.step], float(self.state.steps["length"][self.step])
        first = None
        if kind == SDIRK2:
            one, two = sdirk2(h)
            x_a = self.state.x_stage[self.step]
            first = self._solved(one, SHARE, x_a, None, None)
            last = self._solved(two, 1.0, x_end, x_a, None)
        elif kind == BDF2:
            start = self.start
            last = self._solved(bdf2(h, start.h_before), 1.0, x_end, start.x_before, start.v_before)
        else:
            last = self._solved(euler(h), 1.0, x_end, None, None)
        residual = max(equations.residual(self.body, s.found.gradient, self.state.g_ref)
                       for s in (first, last) if s is not None)
        off = float(self.reference.rounding(last.stage.t).max())
        return Step(residual, self._slack(last.stage), off, self._corrected(first, last), last.found,
                    last.velocity, last.stage.k,
                    last.touch.bonds if last.touch is not None else None,
                    self._rough(first, last, v_end),
                    any(s.touch is not None and bool(np.any(s.touch.force)) for s in (first, last) if s))
