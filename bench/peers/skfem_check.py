# SPDX-License-Identifier: Apache-2.0
"""Tests of the reference itself against numbers that do not come from it.

Each line printed is one test: what it is, the measured deviation, its bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import SupportsFloat

import numpy as np
import skfem
from scipy.integrate import solve_bvp
from scipy.sparse.linalg import eigsh
from skfem.helpers import ddot, grad, inv, trace, transpose

from newton import Floats
from richardson import richardson
from scene_file import ELEMENTS, Boundary, Material, Probe, Run, Scene
from skfem_body import TABLE, Body, box_mesh
from skfem_solve import Solution, body_of, prescribed, solve_in_time, solve_static, torque

SOFT = Material("neo-hookean", 1.0, 0.3, 1.0)
TIP = Probe("tip", "face_mean", "x_max")
FAILURES: list[str] = []


def require(name: str, deviation: SupportsFloat, bound: float) -> None:
    """Prints a test and keeps its name if it failed."""
    passed = float(deviation) <= bound
    verdict = "ok  " if passed else "FAIL"
    print(f"{verdict} {name}: {float(deviation):.2e} (bound {bound:g})", flush=True)
    if not passed:
        FAILURES.append(name)


def distorted_body(element: str) -> Body:
    """2 x 2 x 2 cells whose vertices are moved by up to a tenth of a cell."""
    mesh = box_mesh((1.0, 0.8, 0.9), (2, 2, 2), element)
    noise = np.random.default_rng(1).uniform(-0.04, 0.04, mesh.p.shape)
    return Body(type(mesh)(mesh.p + noise, mesh.t), element, SOFT)


def random_displacement(body: Body, size: float) -> Floats:
    """A stretch and shear with noise, all det F positive."""
    random = np.random.default_rng(2)
    A = random.uniform(-size, size, (3, 3))
    u: Floats = body.rest @ A.T + random.uniform(-size / 20, size / 20, body.rest.shape)
    return u


def check_derivatives(element: str) -> None:
    """Central differences of E and of its gradient along a random direction."""
    body = distorted_body(element)
    u = random_displacement(body, 0.4)
    p = np.random.default_rng(3).normal(size=u.shape)
    p /= np.linalg.norm(p)
    eps = 1e-5
    slope = (body.energy(u + eps * p) - body.energy(u - eps * p)) / (2 * eps)
    require(f"{element}: gradient is the derivative of the energy",
            abs(slope / (body.gradient(u) * p).sum() - 1), 1e-7)
    bend = (body.gradient(u + eps * p) - body.gradient(u - eps * p)).ravel() / (2 * eps)
    Kp = body.hessian(u) @ p.ravel()
    require(f"{element}: Hessian is the derivative of the gradient",
            np.linalg.norm(bend - Kp) / np.linalg.norm(Kp), 1e-7)


def check_forms(element: str) -> None:
    """Gradient and Hessian against the forms of scikit-fem, dof for dof."""
    body = distorted_body(element)
    u = random_displacement(body, 0.4)
    shape, degree, _ = TABLE[element]
    basis = skfem.Basis(body.mesh, skfem.ElementVector(shape()), intorder=degree)
    place = np.empty(basis.N, int)
    for a, component in np.ndindex(body.elements.shape[1], 3):
        place[basis.element_dofs[3 * a + component]] = 3 * body.elements[:, a] + component
    mu, lam = SOFT.mu, SOFT.lam

    def state(w: dict[str, skfem.DiscreteField]) -> tuple[Floats, Floats]:
        F = grad(w["u"]) + np.eye(3)[:, :, None, None]
        return F, np.log(np.linalg.det(np.moveaxis(F, (0, 1), (2, 3))))

    def times(A: Floats, B: Floats) -> Floats:
        return np.einsum("ij...,jk...->ik...", A, B)

    @skfem.LinearForm
    def force(v: skfem.DiscreteField, w: dict[str, skfem.DiscreteField]) -> Floats:
        F, log_j = state(w)
        return ddot(mu * F + (lam * log_j - mu) * transpose(inv(F)), grad(v))

    @skfem.BilinearForm
    def stiffness(du: skfem.DiscreteField, v: skfem.DiscreteField,
                  w: dict[str, skfem.DiscreteField]) -> Floats:
        F, log_j = state(w)
        a, b = times(inv(F), grad(du)), times(inv(F), grad(v))
        return (mu * ddot(grad(du), grad(v)) + lam * trace(a) * trace(b)
                + (mu - lam * log_j) * ddot(transpose(a), b))

    field = basis.interpolate(u.ravel()[place])
    f, K = body.gradient(u).ravel()[place], body.hessian(u)[place][:, place]
    require(f"{element}: gradient as assembled by scikit-fem",
            np.abs(force.assemble(basis, u=field) - f).max() / np.abs(f).max(), 1e-13)
    require(f"{element}: Hessian as assembled by scikit-fem",
            abs(stiffness.assemble(basis, u=field) - K).max() / abs(K).max(), 1e-13)


def check_rotation(element: str) -> None:
    """A turn by a large angle costs nothing."""
    body = distorted_body(element)
    Q = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    u = body.rest @ (Q * np.linalg.det(Q)).T - body.rest
    require(f"{element}: no force of a rigid turn", np.abs(body.gradient(u)).max(), 1e-13)
    require(f"{element}: no energy of a rigid turn", abs(body.energy(u)), 1e-13)


def check_moments(element: str) -> None:
    """Moments of a cube, integral y^2 = 1/3 and y^4 = 1/5, with fields that the shape functions
    hold; trilinear ones have y^2 and lumped masses by the trapezoidal rule, h^2/6 more."""
    body = Body(box_mesh((1, 1, 1), (2, 2, 2), element), element, SOFT)
    trapezoidal = 1 / 3 + 0.5**2 / 6
    linear = element == "hex"
    y = body.rest[:, 1]
    mean = body.face_mean("x_max") @ y**2
    require(f"{element}: mean over a face", abs(mean - (trapezoidal if linear else 1 / 3)), 1e-14)
    M = {kind: body.mass(kind)[1::3, 1::3] for kind in ("lumped", "consistent")}
    field = y if linear else y**2
    moment = field @ M["consistent"] @ field
    require(f"{element}: consistent mass", abs(moment - (1 / 3 if linear else 1 / 5)), 1e-14)
    if linear:
        require("hex: lumped mass", abs(y @ M["lumped"] @ y - trapezoidal), 1e-14)


# lambda -> nominal stress, lateral stretch of this law at E = 1, nu = 0.3, lateral faces free
UNIAXIAL = {0.5: (-0.935352, 1.210767), 0.7: (-0.405230, 1.107935), 0.9: (-0.108722, 1.031702),
            1.1: (0.093077, 0.971493), 1.5: (0.378280, 0.880175), 2.0: (0.646745, 0.798078)}


def check_uniaxial(element: str) -> None:
    """Stress and lateral stretch of a block, with all digits of the table."""
    mesh_run = Run(element, (2, 2, 2))
    deviations = []
    for stretch, (stress, lateral) in UNIAXIAL.items():
        held = Boundary("x_max", (0,), shift=(stretch - 1, 0, 0))
        scene = Scene("uniaxial", (1, 1, 1), SOFT,
                      (Boundary("x_min", (0,)), Boundary("y_min", (1,)), Boundary("z_min", (2,)),
                       held), (), (mesh_run,), load_factors=(0.25, 0.5, 0.75, 1.0))
        body = body_of(scene, mesh_run)
        u = solve_static(body, scene).u
        pull = body.gradient(u)[body.face_nodes("x_max"), 0].sum()
        side = 1 + u[body.face_nodes("y_max"), 1]
        deviations += [abs(pull - stress), np.abs(side - lateral).max()]
    require(f"{element}: uniaxial stretch 0.5 ... 2", np.max(deviations), 1e-6)


def beam(element: str, n: int, slenderness: int, poisson: float, K: float) -> Solution:
    """Cantilever of length 1 under its own weight rho g A = K EI, n cells thick."""
    t = 1 / slenderness
    g = K * t * t / 12  # of E = rho = 1
    run = Run(element, (slenderness * n, n, n))
    scene = Scene("beam", (1, t, t), Material("neo-hookean", 1, poisson, 1), (Boundary("x_min"),),
                  (TIP,), (run,), (0, -g, 0))
    return solve_static(body_of(scene, run), scene)


def beam_tip(K: float, slenderness: int) -> float:
    """Deflection of a beam of length 1 that bends, stretches and shears (Reissner's, shear factor
    5/6, square section, nu = 0) under its own weight K EI, by collocation.

    Unknown: angle below the horizontal, moment/EI, deflection. A section at s carries the weight
    q = K (1 - s) EI beyond it.
    """
    axial = 1 / (12 * slenderness**2)  # EI/EA
    shear = axial * 2 * 6 / 5  # EI/(5/6 GA)

    def slopes(s: Floats, state: Floats) -> Floats:
        sine, cosine = np.sin(state[0]), np.cos(state[0])
        q = K * (1 - s)
        stretch, slip = 1 + axial * q * sine, shear * q * cosine
        across, down = stretch * cosine - slip * sine, stretch * sine + slip * cosine
        return np.stack([state[1], -q * across, down])

    s = np.linspace(0, 1, 41)
    guess = np.stack([np.sin(np.pi / 2 * s), 1 - s, s * s / 2])
    solution = solve_bvp(slopes, lambda a, b: np.array([a[0], a[2], b[1]]), s, guess, tol=1e-9)
    return float(solution.sol(1)[2])


def check_large_deflection() -> None:
    """K = 11.772 at nu = 0: the elastica gives 0.73832; shear and stretch add 1.0 % at L/t = 10
    and 0.25 % at 20. A solid of this law yields more, its sections thin where they are bent: by
    terms of the order (t/L)^2, which vanish in the limit."""
    K, elastica = 11.772, 0.73832
    require("Reissner's beam, L/t = 1000, against the elastica",
            abs(beam_tip(K, 1000) / elastica - 1), 1e-5)
    for slenderness, excess in ((10, 0.010), (20, 0.0025)):
        require(f"Reissner's beam over the elastica, L/t = {slenderness}",
                abs(beam_tip(K, slenderness) / elastica - 1 - excess), 5e-4)
    for element in ("hex27", "tet10"):
        ratios = []
        for slenderness in (10, 20, 40):
            tip = -float(beam(element, 2, slenderness, 0, K).probes["tip"][1])
            ratios.append(tip / beam_tip(K, slenderness))
            print(f"     {element}, L/t = {slenderness}: {tip:.5f}, "
                  f"{100 * (tip / elastica - 1):+.2f} % of the elastica, "
                  f"{100 * (ratios[-1] - 1):+.3f} % of the beam")
        require(f"{element}: tip over the beam's, L/t = 40", abs(ratios[-1] - 1), 5e-4)
        limit = richardson([1 / 10, 1 / 20, 1 / 40], ratios)
        require(f"{element}: the same, limit of slender beams", abs(limit.estimate - 1), 1e-4)
        require(f"{element}: order of the difference", abs(limit.order - 2), 0.3)


def check_small_deflection() -> None:
    """Error in per cent against Timoshenko at nu = 0.3 in the limit of small loads: tables of
    linear elasticity for trilinear hexahedra; -0.94 +- 0.05 for the solid, to which the
    uncertainty of the extrapolation, 0.10 and 0.12, comes."""
    timoshenko = 1 / 8 + 0.5 * 2 * 1.3 / 12 / 100 * (12 + 11 * 0.3) / (10 * 1.3)  # of K
    K = 1e-4

    def error(element: str, n: int) -> float:
        return 100 * (-float(beam(element, n, 10, 0.3, K).probes["tip"][1]) / (K * timoshenko) - 1)

    for n, known in ((1, -35.7), (2, -13.4), (4, -4.5)):
        require(f"hex: small deflection, {n} cells thick", abs(error("hex", n) - known), 0.1)
    for element in ("hex27", "tet10"):
        solid = richardson([1, 1 / 2, 1 / 4], [error(element, n) for n in (1, 2, 4)])
        require(f"{element}: small deflection, extrapolated", abs(solid.estimate + 0.94), 0.15)


def check_torque() -> None:
    """The torque of a turned face is the derivative of the energy with respect to the angle."""
    def solution(angle: float) -> tuple[Body, Boundary, Solution]:
        held = Boundary("x_max", angle=angle, centre=(0.05, 0.05))
        run = Run("hex27", (4, 1, 1))
        scene = Scene("twist", (0.4, 0.1, 0.1), SOFT, (Boundary("x_min"), held), (), (run,),
                      load_factors=(0.25, 0.5, 0.75, 1.0))
        body = body_of(scene, run)
        return body, held, solve_static(body, scene)

    eps = 1e-3
    body, held, middle = solution(1.5)
    energy = [float(solution(1.5 + d)[2].probes["elastic"]) for d in (-eps, eps)]
    require("torque is the derivative of the energy",
            abs((energy[1] - energy[0]) / (2 * eps) / torque(body, held, middle.u) - 1), 1e-5)


def check_free_fall(element: str, mass: str) -> None:
    """A free body falls by g t (t + dt)/2."""
    run = Run(element, (2, 1, 1), mass)
    scene = Scene("fall", (1, 0.5, 0.5), replace(SOFT, young=1e3), (), (TIP,), (run,),
                  (0, -9.81, 0), dt=0.01, steps=10)
    u = solve_in_time(body_of(scene, run), scene, mass).u
    require(f"{element}, {mass}: free fall",
            np.abs(u - np.array([0, -9.81 * 0.1 * 0.11 / 2, 0])).max(), 1e-12)


def check_vibration(element: str, mass: str) -> None:
    """The first mode under a small load that begins at once: with z = q - q_static, after n steps
    z = z_0 (1 + w^2)^(-n/2) cos(n atan w), w = omega dt."""
    run = Run(element, (6, 1, 1), mass)
    scene = Scene("vibration", (1, 0.1, 0.1), replace(SOFT, young=1e7), (Boundary("x_min"),), (),
                  (run,), (0, -9.81, 0), tolerance=1e-7, dt=3e-4, steps=37)
    body = body_of(scene, run)
    free = prescribed(body, scene.boundary, 1)[1].ravel()
    K = body.hessian(np.zeros_like(body.rest))[free][:, free]
    M = body.mass(mass)[free][:, free]
    values, modes = eigsh(K, 4, M, sigma=0)
    load = modes.T @ body.weight_force(scene.gravity).ravel()[free]
    # of the two lowest modes, which bend along y and z, the one that the load drives
    k = int(np.argmax(np.where(values < 1.1 * values[0], np.abs(load), 0)))
    w = np.sqrt(values[k]) * scene.dt
    n = scene.steps
    expected = load[k] / values[k] * (1 - (1 + w * w)**(-n / 2) * np.cos(n * np.arctan(w)))
    u = solve_in_time(body, scene, mass).u.ravel()[free]
    require(f"{element}, {mass}: first mode, omega dt = {w:.3f}",
            abs((modes[:, k] @ (M @ u)) / expected - 1), 1e-5)


def check_energy_falls() -> None:
    """Kinetic, elastic and gravity energy together never rise in steps of implicit Euler."""
    run = Run("tet10", (10, 1, 1), "consistent")
    scene = Scene("swing", (1, 0.1, 0.1), Material("neo-hookean", 1e6, 0.3, 1000),
                  (Boundary("x_min"),), (), (run,), (0, -9.81, 0), dt=1 / 120, steps=60)
    probes = solve_in_time(body_of(scene, run), scene, run.mass).probes
    total = probes["kinetic"] + probes["elastic"] + probes["gravity"]
    require("largest rise of the energy over what is lost",
            np.diff(total, prepend=0).max() / -total[-1], 1e-6)


def check_richardson() -> None:
    """Sequences f + c h^p come out exactly; others are not extrapolated."""
    h = np.array([1, 1 / 2, 1 / 3])
    fit = richardson(h, 2 - 0.3 * h**1.7)
    require("Richardson: value", abs(fit.estimate - 2), 1e-12)
    require("Richardson: order", abs(fit.order - 1.7), 1e-9)
    rough = richardson(h, [1, 3, 2])
    require("Richardson: no order", abs(rough.estimate - 2) + abs(rough.uncertainty - 2), 0)


def main() -> int:
    """All tests; 1 if one fails."""
    each: tuple[Callable[[str], None], ...] = (check_derivatives, check_forms, check_rotation,
                                               check_moments, check_uniaxial)
    for element in ELEMENTS:
        for check in each:
            check(element)
    check_large_deflection()
    check_small_deflection()
    check_torque()
    for element, mass in (("hex", "lumped"), ("hex27", "consistent"), ("tet10", "consistent")):
        check_free_fall(element, mass)
        check_vibration(element, mass)
    check_energy_falls()
    check_richardson()
    print(f"{len(FAILURES)} failed" if FAILURES else "all passed")
    return 1 if FAILURES else 0
