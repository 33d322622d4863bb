# SPDX-License-Identifier: Apache-2.0
"""Statics by load increments and steps of implicit Euler on a body, with the probes of a scene."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from newton import Floats, Potential, Report, carried_along, minimise
from scene_file import Boundary, Run, Scene
from skfem_body import Body, box_mesh

STANDARD_GRAVITY = 9.81  # g_ref [m/s^2]
PATH_TOLERANCE = 1e-3  # of the residual at load factors before the last


@dataclass(frozen=True)
class Seconds:
    """On the clock, and of the processor, which other programs disturb less."""

    wall: float
    cpu: float

    @staticmethod
    def now() -> Seconds:
        return Seconds(time.perf_counter(), time.process_time())

    def since(self, start: Seconds) -> Seconds:
        return Seconds(self.wall - start.wall, self.cpu - start.cpu)


@dataclass(frozen=True)
class Solution:
    """What a run gives; in time the probes have one entry a step."""

    u: Floats  # at the end, (nodes, 3) [m]
    report: Report  # sums of all solves; residual: the last one in statics, the largest in time
    min_j: float  # at the end
    seconds: Seconds  # of Newton: assembly, factorization, line search
    probes: dict[str, Floats]


def prescribed(body: Body, boundary: tuple[Boundary, ...],
               factor: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Displacements [m] of the held components at a load factor, and 1 where not held."""
    u, free = np.zeros((body.nodes, 3)), np.ones((body.nodes, 3), bool)
    for held in boundary:
        nodes = body.face_nodes(held.face)
        angle = factor * held.angle
        arm = body.rest[nodes] - np.array([0, *held.centre])
        turned = np.stack([arm[:, 0], np.cos(angle) * arm[:, 1] - np.sin(angle) * arm[:, 2],
                           np.sin(angle) * arm[:, 1] + np.cos(angle) * arm[:, 2]], axis=1)
        for c in held.components:
            u[nodes, c] = factor * held.shift[c] + (turned - arm)[:, c]
            free[nodes, c] = False
    return u, free


def torque(body: Body, held: Boundary, u: Floats) -> float:
    """Moment about the axis of the turn [N m] that the holder exerts on the face."""
    nodes = body.face_nodes(held.face)
    force = body.gradient(u)[nodes]
    arm = (body.rest + u)[nodes] - np.array([0, *held.centre])
    return float((arm[:, 1] * force[:, 2] - arm[:, 2] * force[:, 1]).sum())


def probe_values(body: Body, scene: Scene, u: Floats) -> dict[str, Floats]:
    """The probes of the scene and the energies elastic and gravity = -integral rho g.u [J]."""
    values: dict[str, Floats] = {}
    for probe in scene.probes:
        if probe.quantity == "face_mean":
            values[probe.name] = body.face_mean(probe.face) @ u
        elif probe.quantity == "point":
            values[probe.name] = u[body.node_at(probe.at)]
        else:
            held = next(b for b in scene.boundary if b.face == probe.face)
            values[probe.name] = np.array(torque(body, held, u))
    values["elastic"] = np.array(body.energy(u))
    if any(scene.gravity):
        values["gravity"] = np.array(-(body.weight_force(scene.gravity) * u).sum())
    return values


def loaded(body: Body, f: Floats, free: NDArray[np.bool_]) -> Potential:
    """E(u) - f.u with forces f [N], (nodes, 3).

    The scale of the residual is |f| over the free nodes, without forces the norm of dE/du at all
    nodes, which are then the reactions.
    """
    load = float(np.linalg.norm(f[free]))
    return Potential(
        value=lambda u: body.energy(u) - float((f * u).sum()),
        gradient=lambda u: body.gradient(u) - f,
        hessian=body.hessian,
        free=free,
        force_scale=lambda u: load or float(np.linalg.norm(body.gradient(u))))


def solve_static(body: Body, scene: Scene) -> Solution:
    """Equilibrium at the last load factor, each one starting from that before."""
    weight = body.weight_force(scene.gravity)
    u = np.zeros((body.nodes, 3))
    total = Report(np.inf, False, 0)
    start = Seconds.now()
    for factor in scene.load_factors:
        target, free = prescribed(body, scene.boundary, factor)
        potential = loaded(body, factor * weight, free)
        if not np.array_equal(u[~free], target[~free]):
            u = carried_along(potential, u, target)
            total.newton_steps += 1
        last = factor == scene.load_factors[-1]
        u, report = minimise(potential, u, scene.tolerance if last else PATH_TOLERANCE)
        total = Report(report.residual, report.converged, total.newton_steps + report.newton_steps,
                       total.halvings + report.halvings)
        if not report.converged:
            break
    seconds = Seconds.now().since(start)
    return Solution(u, total, body.min_j(u), seconds, probe_values(body, scene, u))


def euler_step(body: Body, M: sparse.csr_matrix, dt: float, uhat: Floats,
               free: NDArray[np.bool_]) -> Potential:
    """Phi(u) = 1/(2 dt^2) (u - uhat).M (u - uhat) + E(u); the scale of its residual is the weight
    |m| g_ref of the free nodes."""
    mass = np.asarray(M.sum(1)).reshape(uhat.shape)
    scale = STANDARD_GRAVITY * float(np.linalg.norm(mass[free]))

    def inertia(u: Floats) -> Floats:
        return (M @ (u - uhat).ravel()).reshape(u.shape) / dt**2

    return Potential(
        value=lambda u: body.energy(u) + float((inertia(u) * (u - uhat)).sum()) / 2,
        gradient=lambda u: body.gradient(u) + inertia(u),
        hessian=lambda u: body.hessian(u) + M / dt**2,
        free=free,
        force_scale=lambda _: scale)


def solve_in_time(body: Body, scene: Scene, mass: str) -> Solution:
    """Steps of implicit Euler from rest: each the minimum of Phi with uhat = u + dt v + dt^2 g,
    sought from u + dt v, and v the difference quotient."""
    dt, M = scene.dt, body.mass(mass)
    held, free = prescribed(body, scene.boundary, 1)
    u, v = held.copy(), np.zeros_like(held)
    records: list[dict[str, Floats]] = []
    worst, seconds = Report(0, True, 0), Seconds(0, 0)
    for _ in range(scene.steps):
        start = Seconds.now()
        potential = euler_step(body, M, dt, u + dt * v + dt * dt * np.array(scene.gravity), free)
        ahead = np.where(free, u + dt * v, held)
        end, report = minimise(potential, ahead if np.isfinite(body.energy(ahead)) else u,
                               scene.tolerance)
        u, v = end, (end - u) / dt
        step = Seconds.now().since(start)
        seconds = Seconds(seconds.wall + step.wall, seconds.cpu + step.cpu)
        worst = Report(max(worst.residual, report.residual), worst.converged and report.converged,
                       worst.newton_steps + report.newton_steps, worst.halvings + report.halvings)
        kinetic = np.array(v.ravel() @ (M @ v.ravel()) / 2)
        records.append(probe_values(body, scene, u) | {"kinetic": kinetic})
    probes = {name: np.array([r[name] for r in records]) for name in records[0]}
    return Solution(u, worst, body.min_j(u), seconds, probes)


def body_of(scene: Scene, run: Run) -> Body:
    """The mesh of a run."""
    return Body(box_mesh(scene.box, run.cells, run.element), run.element, scene.material)


def solve(scene: Scene, run: Run, body: Body) -> Solution:
    """A run of the scene on its mesh."""
    return solve_in_time(body, scene, run.mass) if scene.dt else solve_static(body, scene)
