# SPDX-License-Identifier: Apache-2.0
"""Self-tests of the equations: finite differences, closed forms, invariances."""

from __future__ import annotations

import unittest

import numpy as np

import collision
import equations
from equations import Motion
from laws import law_of
from state_file import LAWS, Floats
from synthetic import DT, GRAVITY, H, add_contact, central_differences, make_state, shape_means


def random_rotation(random: np.random.Generator) -> Floats:
    """A rotation drawn without preference."""
    Q = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return Q * np.linalg.det(Q)


def signed_svd(F: Floats) -> tuple[Floats, Floats, Floats]:
    """U, sigma, V^T of one F, U and V rotations, the sign of det F on the smallest stretch."""
    U, sigma, Vt = np.linalg.svd(F)
    sign_u, sign_v = np.linalg.det(U), np.linalg.det(Vt)
    U[:, 2] *= sign_u
    Vt[2] *= sign_v
    sigma[2] *= round(sign_u * sign_v)
    return U, sigma, Vt


def log_below(s: float) -> float:
    """ln s above 0.1, else its quadratic continuation."""
    d = (s - 0.1) / 0.1
    return float(np.log(s)) if s > 0.1 else float(np.log(0.1)) + d - d * d / 2


def psi_of_stretches(law: str, s: Floats, mu: float, lam: float) -> float:
    """The laws as functions of the principal stretches."""
    J, I = s.prod(), (s * s).sum()
    if law == "fixed-corotated":
        return mu * ((s - 1) ** 2).sum() + lam / 2 * (J - 1) ** 2
    if law == "neo-hookean":
        return mu / 2 * (I - 3) - mu * log_below(J) + lam / 2 * log_below(J) ** 2
    if law == "stable-neo-hookean":
        m, k = 4 * mu / 3, lam + 5 * mu / 6
        a = 1 + 0.75 * m / k
        return m / 2 * (I - 3 - np.log((I + 1) / 4)) + k / 2 * ((J - a) ** 2 - (1 - a) ** 2)
    e = (s * s - 1) / 2 if law == "stvk" else np.array([log_below(value) for value in s])
    if "=" in law:
        return psi_of_family(law, e - e.mean(), mu) + (lam / 2 + mu / 3) * e.sum() ** 2
    return mu * (e * e).sum() + lam / 2 * e.sum() ** 2


def psi_of_family(law: str, e: Floats, mu: float) -> float:
    """The part of deviatoric log stretches."""
    name, _, text = law.partition("=")
    a = float(text)

    def power_sum(power: float) -> float:
        return float(sum(np.exp(x) if x < 12 else np.exp(12) * (1 + (x - 12) + (x - 12) ** 2 / 2)
                         for x in power * e)) - 3
    if name == "ogden":
        return 2 * mu / a ** 2 * power_sum(a)
    if name == "mooney-rivlin":
        return mu / 2 * ((1 - a) * power_sum(2) + a * power_sum(-2))
    return -mu * a / 2 * log_below(1 - power_sum(2) / a)


class Laws(unittest.TestCase):
    """Every law, one F at a time."""

    def setUp(self) -> None:
        self.random = np.random.default_rng(5)
        self.mu, self.lam = equations.lame(1e5, 0.35)

    def states(self) -> list[Floats]:
        """F near rest, strongly deformed, below the continuation limits, and mirrored."""
        near = [np.eye(3) + 0.3 * self.random.normal(size=(3, 3)) for _ in range(6)]
        flat = [random_rotation(self.random) @ np.diag([1.3, 0.9, s]) @ random_rotation(self.random)
                for s in (0.06, -0.04, -0.7)]
        return near + flat

    def test_stress_is_the_gradient_of_the_energy(self) -> None:
        for law in LAWS:
            for F in self.states():
                P = law_of(law)(F[None], self.mu, self.lam)[1][0]
                slope = central_differences(
                    lambda G: law_of(law)(G[None], self.mu, self.lam)[0][0], F, 1e-6).reshape(3, 3)
                np.testing.assert_allclose(P, slope, atol=2e-7 * max(self.mu, np.abs(P).max()),
                                           err_msg=law)

    def test_energy_equals_its_form_in_principal_stretches(self) -> None:
        for law in LAWS:
            for F in self.states():
                psi = law_of(law)(F[None], self.mu, self.lam)[0][0]
                own = psi_of_stretches(law, signed_svd(F)[1], self.mu, self.lam)
                self.assertAlmostEqual(psi / self.mu, own / self.mu, places=10, msg=law)

    def test_moduli_at_rest_are_those_of_linear_elasticity(self) -> None:
        strain = self.random.normal(size=(3, 3))
        sym = strain + strain.T
        wanted = self.mu * sym + self.lam * np.trace(strain) * np.eye(3)
        for law in LAWS:
            up, down = (law_of(law)(np.eye(3)[None] + s * strain, self.mu, self.lam)[1][0]
                        for s in (1e-6, -1e-6))
            np.testing.assert_allclose((up - down) / 2e-6, wanted, atol=1e-4 * self.mu, err_msg=law)

    def test_rotation_is_that_of_the_signed_svd(self) -> None:
        for F in self.states():
            U, _, Vt = signed_svd(F)
            np.testing.assert_allclose(equations.rotation(F[None])[0], U @ Vt, atol=1e-12)


class Step(unittest.TestCase):
    """Phi of a ragged grid with full and border voxels, one material a law."""

    def deformed(self, seed: int, size: float) -> Floats:
        """The rest positions turned by a random rotation, plus noise of `size` voxels."""
        random = np.random.default_rng(seed)
        rest = make_state().grid["rest"]
        return rest @ random_rotation(random).T + size * H * random.normal(size=rest.shape)

    def test_gradient_is_the_derivative_of_the_potential(self) -> None:
        x, x1, x0 = (self.deformed(2, s) for s in (0.2, 0.1, 0.05))
        random = np.random.default_rng(4)
        v1, v0 = random.normal(size=(2, *x.shape))
        for law, motion in ((law, m) for law in LAWS
                            for m in (Motion(x1, v1), Motion(x1, v1, x0, v0))):
            body = equations.make_body(make_state(laws=(law,)))
            R = equations.rotations(body, x1)
            found = equations.potential(body, motion, GRAVITY, DT, x, R)
            slope = central_differences(
                lambda y: equations.potential(body, motion, GRAVITY, DT, y, R).value, x, 1e-5 * H)
            error = np.abs(slope.reshape(x.shape) - found.gradient).max()
            self.assertLess(error, 2e-7 * np.abs(found.gradient).max(), law)

    def test_inner_forces_have_no_sum_and_without_torsion_no_torque(self) -> None:
        x = self.deformed(7, 0.1)
        for mode in ("full", "variance"):
            body = equations.make_body(make_state(hourglass=mode))
            force = equations.internal_energy(body, x, equations.rotations(body, x))[2]
            scale = np.abs(force).sum()
            self.assertLess(np.abs(force.sum(0)).max(), 1e-12 * scale)
            if mode == "variance":
                self.assertLess(np.abs(np.cross(x, force).sum(0)).max(), 1e-12 * scale)

    def test_rigid_motion_costs_nothing_and_its_forces_turn_with_it(self) -> None:
        body, Q = equations.make_body(make_state()), random_rotation(np.random.default_rng(8))
        x = self.deformed(7, 0.1)
        force = equations.internal_energy(body, x, equations.rotations(body, x))[2]
        turned = equations.internal_energy(body, x @ Q.T, equations.rotations(body, x @ Q.T))[2]
        np.testing.assert_allclose(turned, force @ Q.T, atol=1e-11 * np.abs(force).max())
        rigid = body.rest @ Q.T + 1.0
        elastic, hourglass, _ = equations.internal_energy(body, rigid,
                                                          equations.rotations(body, rigid))
        self.assertLess(max(abs(elastic), abs(hourglass)), 1e-16)

    def test_mean_gradients_reproduce_linear_fields(self) -> None:
        state, A = make_state(), np.random.default_rng(9).normal(size=(3, 3))
        for block in equations.make_body(state).blocks:
            F = equations.deformation_gradient(block, state.grid["rest"] @ A.T)
            np.testing.assert_allclose(F, np.broadcast_to(np.eye(3) + A, F.shape), atol=1e-12)

    def test_border_voxel_takes_the_mean_of_the_gradient_over_its_fill(self) -> None:
        points = np.random.default_rng(10).uniform(0, 1, (40, 3))
        ours = equations.mean_gradients(shape_means(points)[None], H)[0]
        for d in range(3):
            up, down = (points + s * 1e-6 * np.eye(3)[d] for s in (1, -1))
            slope = (shape_means(up) - shape_means(down)) / (2e-6 * H)
            np.testing.assert_allclose(ours[:, d], slope, atol=1e-8 / H)

    def test_patterns_are_second_derivatives_at_the_centroid_of_the_fill(self) -> None:
        random = np.random.default_rng(12)
        points, u = random.uniform(0, 1, (40, 3)), random.normal(size=8)
        ours = equations.patterns(shape_means(points)[None], H)[0] @ u

        def slope(point: Floats) -> Floats:
            return u @ equations.mean_gradients(shape_means(point[None])[None], H)[0]

        mixed = central_differences(slope, points.mean(0), 0.1) / H
        np.testing.assert_allclose(ours[:3], [mixed[0, 1], mixed[1, 2], mixed[2, 0]], rtol=1e-10)
        corners = [slope(np.array([0.5, y, z]))[0] for y in (0.0, 1.0) for z in (0.0, 1.0)]
        third = (corners[3] - corners[2] - corners[1] + corners[0]) / H**2
        self.assertAlmostEqual(ours[3] / third, 1, 10)

    def test_variance_term_is_the_integral_of_the_deviation_from_the_mean(self) -> None:
        state = make_state(laws=("stvk",), hourglass="variance", cells=[(0, 0, 0)], full=1)
        state.grid["hourglass"][:] = 7e3
        u = 0.1 * H * np.random.default_rng(11).normal(size=(8, 3))
        nodes = equations.BITS @ [4, 2, 1]  # the rest nodes are sorted by x, then y, then z
        np.testing.assert_array_equal(state.grid["corners"][0], nodes)
        gauss = 0.5 + np.array([-1, 1]) * np.sqrt(1 / 12)
        points = np.array([[a, b, c] for a in gauss for b in gauss for c in gauss])
        local = [equations.mean_gradients(shape_means(p[None])[None], H)[0] for p in points]
        F = np.array([u[nodes].T @ g for g in local])
        wanted = 7e3 / 2 * H**3 * ((F - F.mean(0)) ** 2).sum((1, 2)).mean()
        body = equations.make_body(state)
        found = equations.internal_energy(body, body.rest + u, [])[1]
        self.assertAlmostEqual(found / wanted, 1, 12)


class TimeSchemes(unittest.TestCase):
    """Predictor and velocity against the two formulas that define each scheme."""

    def test_the_force_is_mass_times_the_scheme_s_own_acceleration(self) -> None:
        x, x1, x0, v1, v0 = np.random.default_rng(13).normal(size=(5, 4, 3))
        for motion in (Motion(x1, v1), Motion(x1, v1, x0, v0)):
            a0, xhat = equations.predictor(motion, GRAVITY, DT)
            v = equations.velocity(motion, x, DT)
            two_step = (3 * v - 4 * v1 + v0) / (2 * DT)
            acceleration = (v - v1) / DT if motion.x_before is None else two_step
            np.testing.assert_allclose(a0 * (x - xhat) / DT**2, acceleration - GRAVITY, rtol=1e-9)


class ZeroModes(unittest.TestCase):
    """Null space of the Hessian of one free voxel at rest."""

    def count(self, hourglass: str, full: int) -> int:
        state = make_state(laws=("neo-hookean",), hourglass=hourglass, cells=[(0, 0, 0)], full=full)
        mu, _ = equations.lame(state.materials[0].young, state.materials[0].poisson)
        state.grid["hourglass"][:] = mu
        body = equations.make_body(state)
        R = equations.rotations(body, body.rest)
        hessian = central_differences(
            lambda x: equations.internal_energy(body, x, R)[2].ravel(), body.rest, 1e-5 * H)
        eigenvalues = np.linalg.eigvalsh((hessian + hessian.T) / 2)
        self.assertGreater(eigenvalues[0], -1e-7 * eigenvalues[-1])
        return int((eigenvalues < 1e-6 * eigenvalues[-1]).sum())

    def test_six_with_and_eighteen_without_the_variance_term(self) -> None:
        for full in (1, 0):
            self.assertEqual(self.count("full", full), 6)
            self.assertEqual(self.count("variance", full), 6)
            self.assertEqual(self.count("off", full), 18)

    def test_torsion_term_gives_the_three_modes_their_exact_stiffness(self) -> None:
        state = make_state(laws=("stvk",), cells=[(0, 0, 0)], full=1)
        mu, _ = equations.lame(state.materials[0].young, state.materials[0].poisson)
        state.grid["hourglass"][:] = 0.9 * mu
        body = equations.make_body(state)
        a = np.array([3.0, -1.0, 2.0])  # x with pattern yz, y with zx, z with xy
        X = body.rest - body.rest.mean(0)
        u = a * np.stack([X[:, 1] * X[:, 2], X[:, 2] * X[:, 0], X[:, 0] * X[:, 1]], axis=1)
        pairs = (a[0] + a[1]) ** 2 + (a[1] + a[2]) ** 2 + (a[2] + a[0]) ** 2
        hourglass = equations.internal_energy(body, body.rest + u,
                                              equations.rotations(body, body.rest))[1]
        self.assertAlmostEqual(hourglass / (H**5 / 24 * mu * pairs), 1, 12)

class Contact(unittest.TestCase):
    """Contact with plane, sphere and box."""

    def test_forces_are_the_derivative_of_the_energy(self) -> None:
        state, random = make_state(), np.random.default_rng(8)
        x = state.grid["rest"] + random.normal(0, 0.002 * H, state.grid["rest"].shape)
        offsets = np.zeros((2, 3, 3))
        offsets[1] = 0.01 * H
        add_contact(state, x, offsets)
        for k in range(3):  # one collider at a time, each must act
            state.contact["friction"] = np.array([0.3, 0.2, 0.6]) * (np.arange(3) == k)
            y = x + random.normal(0, 0.005 * H, x.shape)
            energy, gradient = collision.contact(state, 0, x, y)
            own = central_differences(lambda z: collision.contact(state, 0, x, z)[0], y, 1e-9)
            self.assertGreater(energy, 0)
            np.testing.assert_allclose(own, gradient.ravel(), rtol=0,
                                       atol=1e-5 * np.abs(gradient).max())

    def test_distances_of_known_points(self) -> None:
        state = make_state()
        add_contact(state, state.grid["rest"], np.zeros((2, 3, 3)))
        layer = H / 4
        state.contact["centre"] = np.zeros((3, 3))
        place = np.array([[1.1, 2.0, 2.0]])  # of the box: beyond its face x = 0.1 and two edges
        for k, gap in ((0, 0.6 * 1.1 + 0.8 * 2 + layer), (1, np.sqrt(9.21) - 1 + layer),
                       (2, np.sqrt(3) * (1 + layer))):
            own = float(np.linalg.norm(collision.nearest(state, k, np.zeros(3), place)))
            self.assertAlmostEqual(own, gap, 12)
        for k, inside in enumerate(([0, 0, -1], [0.5, 0, 0], [0.05, 0.5, 0.5])):
            gap = collision.nearest(state, k, np.zeros(3), np.array([inside]))
            self.assertTrue(np.isnan(gap).any())


if __name__ == "__main__":
    unittest.main()
