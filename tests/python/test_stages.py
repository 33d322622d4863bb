# SPDX-License-Identifier: Apache-2.0
"""Self-tests of steps by stages, damping and bonds: closed forms and differences."""

from __future__ import annotations

import unittest

import numpy as np

import collision
import damping
import equations
import stages
from stages import Momenta, Start, find_pieces
from state_file import Material
from synthetic import DT, H, add_contact, central_differences, make_state


class Schemes(unittest.TestCase):
    """Weights of the stages."""

    def test_a_constant_force_makes_a_parabola(self) -> None:
        h, before, a, e_0 = 0.03, 0.02, 3.0, 0.7

        def end(s: stages.Stage, d_b: float = 0.0, e_b: float = 0.0) -> tuple[float, float]:
            d = s.w_d * d_b + s.w_e * e_b + s.w_0 * e_0 + s.k**2 * a
            return d, (d - s.w_v * d_b) / s.k

        one, two = stages.sdirk2(h)
        d_a, e_a = end(one)
        exact = (e_0 * h + a * h * h / 2, e_0 + a * h)
        np.testing.assert_allclose(end(two, d_a, e_a), exact, rtol=1e-13)
        back = (-e_0 * before + a * before**2 / 2, e_0 - a * before)
        np.testing.assert_allclose(end(stages.bdf2(h, before), *back), exact, rtol=1e-13)
        self.assertAlmostEqual(end(stages.euler(h))[1], e_0 + a * h, 14)

    def test_of_equal_steps_bdf2_is_the_known_one(self) -> None:
        s = stages.bdf2(0.1, 0.1)
        np.testing.assert_allclose([s.k, s.w_d, s.w_e, s.w_0], [0.2 / 3, -1 / 3, -0.2 / 9, 0.8 / 9])


class References(unittest.TestCase):
    """Rigid motions."""

    def test_a_symmetric_top_precesses(self) -> None:
        """w turns about L at |L|/I_1, the body about its axis at the rest."""
        I = np.diag([2.0, 2.0, 3.0])
        L, t = np.array([0.6, 0.0, 1.5]), 1.7
        m = Momenta(np.zeros(3), np.zeros(3), L, I)
        pose = stages.free_pose(m, t)
        size = float(np.linalg.norm(L))
        precession = stages.turned(L / size, size / 2 * t)
        own = stages.turned(np.array([0, 0, 1.0]), L[2] * (1 / 3 - 1 / 2) * t)
        np.testing.assert_allclose(pose.R, precession @ own, atol=1e-11)
        np.testing.assert_allclose(pose.R @ I @ pose.R.T @ pose.w, L, atol=1e-12)

    def test_velocity_and_acceleration_are_derivatives(self) -> None:
        random = np.random.default_rng(2)
        m = Momenta(random.normal(size=3), random.normal(size=3), random.normal(size=3),
                    np.diag([1.0, 2.0, 2.5]))
        x0, t, e = random.normal(size=(4, 3)), 0.8, 1e-4
        for pose in (lambda t: stages.free_pose(m, t),
                     lambda t: stages.pinned_pose(m.centre, m.spin, 0.6, t)):
            low, here, high = (pose(s).motion(x0) for s in (t - e, t, t + e))
            np.testing.assert_allclose((high[0] - low[0]) / (2 * e), here[1], atol=1e-7)
            np.testing.assert_allclose((high[1] - low[1]) / (2 * e), here[2], atol=1e-7)

    def test_a_rigid_turn_has_its_angular_velocity(self) -> None:
        random = np.random.default_rng(3)
        mass, x, w = random.uniform(1, 2, 9), random.normal(size=(9, 3)), np.array([1.0, -2, 0.5])
        about = np.array([0.3, 0.2, -0.1])
        m = stages.momenta(mass, x, np.cross(w, x - about))
        np.testing.assert_allclose(stages.turn_about(m, mass.sum(), about), w, atol=1e-12)

    def test_pieces_are_voxels_that_share_nodes(self) -> None:
        state = make_state(cells=[(0, 0, 0), (1, 1, 1), (4, 0, 0), (5, 0, 0), (9, 0, 0)])
        pieces = find_pieces(state, equations.make_body(state))
        voxels = pieces.of[state.grid["corners"][:, 0]]
        self.assertEqual(len(pieces.mass), 3)
        self.assertEqual(voxels[0], voxels[1])
        self.assertEqual(voxels[2], voxels[3])
        self.assertEqual([pieces.free[p] for p in (voxels[0], voxels[2], voxels[4])],
                         [False, True, True])
        self.assertAlmostEqual(pieces.mass.sum(), state.grid["mass"].sum())
        pinned = state.grid["rest"][state.grid["pinned"] != 0]
        np.testing.assert_allclose(pieces.pins[voxels[0]], pinned.mean(0))


class Damping(unittest.TestCase):
    """D of the voxels."""

    def make(self, hourglass: str = "full") -> tuple[equations.Body, np.random.Generator]:
        state = make_state(hourglass=hourglass)
        state.materials = [Material(m.name, m.law, m.young, m.poisson, m.density, 0.2, 4.0 + i)
                           for i, m in enumerate(state.materials)]
        return equations.make_body(state), np.random.default_rng(4)

    def test_gradient_is_the_derivative(self) -> None:
        for hourglass in ("full", "off"):
            body, random = self.make(hourglass)
            x, other, end = (body.rest + random.normal(0, 0.1 * H, body.rest.shape)
                             for _ in range(3))
            before = damping.base(body, x, 0.4, other)
            own = damping.damping(body, before, DT, end)[1]
            found = central_differences(lambda y: damping.damping(body, before, DT, y)[0], end,
                                        1e-5 * H)
            np.testing.assert_allclose(own.ravel(), found, atol=1e-6 * np.abs(own).max())

    def test_a_stretch_has_the_energy_of_the_formula(self) -> None:
        body, _ = self.make()
        end = body.rest * np.array([1.1, 1, 1])
        energy = damping.damping(body, damping.base(body, body.rest, 0, None), DT, end)[0]
        strain = (1.1**2 - 1) / 2
        self.assertAlmostEqual(energy, sum(
            b.volume.sum() * b.viscous_time / DT * (b.mu + b.lam / 2) * strain**2
            for b in body.blocks), 10)

    def test_a_turn_costs_nothing(self) -> None:
        body, random = self.make()
        x = body.rest + random.normal(0, 0.1 * H, body.rest.shape)
        R = stages.turned(np.array([0.6, 0, 0.8]), 1.2)
        energy, force = damping.damping(body, damping.base(body, x, 0, None), DT, x @ R.T + 0.3)
        self.assertLess(energy, 1e-20)
        self.assertLess(np.abs(force).max(), 1e-8)


class Bonds(unittest.TestCase):
    """Friction of stages, at a plane across z that stands still."""

    def setUp(self) -> None:
        self.state = make_state(cells=[(0, 0, 0)])
        c_rest = self.state.grid["rest"]
        add_contact(self.state, c_rest, np.zeros((2, 3, 3)))
        c = self.state.contact
        for name in ("shape", "centre", "normal", "radius", "half", "friction"):
            c[name] = c[name][:1]
        c["normal"] = np.array([[0.0, 0, 1]])
        low = c_rest[:, 2].min()
        c["centre"] = np.array([[0, 0, low + float(c["layer"]) / 2]])
        self.stiffness = collision.carriers(self.state)[1]
        self.hold = collision.BOND * self.stiffness / float(c["layer"]) ** 2

    def touch(self, shift: list[float], bond: list[float]) -> collision.Bonded:
        rest = self.state.grid["rest"]
        bonds = np.tile(np.array(bond, float), (1, len(self.stiffness), 1))
        return collision.bonded_contact(self.state, bonds, rest, rest + shift, np.zeros((1, 3)),
                                        np.zeros((1, 3)))

    def test_holds_as_a_spring_up_to_coulombs_force(self) -> None:
        free = self.touch([0, 0, 0], [0, 0, 0])
        pushed = free.force[:, 2] > 0
        limit = 0.3 * free.force[pushed, 2]
        self.assertTrue(pushed.any())
        longest = (limit / self.hold[pushed]).min()
        held = self.touch([0.5 * longest, 0, 0], [0, 0, 0])
        np.testing.assert_allclose(held.force[pushed, 0], -self.hold[pushed] * 0.5 * longest)
        np.testing.assert_allclose(held.bonds[0, pushed, 0], 0.5 * longest)
        # far beyond: Coulomb's force, and the bond is as long as that stretches it
        slides = self.touch([-1e3 * longest, 0, 0], [0, 0, 0])
        np.testing.assert_allclose(slides.force[pushed, 0], limit)
        np.testing.assert_allclose(slides.bonds[0, pushed, 0], -limit / self.hold[pushed])

    def test_what_it_held_before_counts_as_slip(self) -> None:
        free = self.touch([0, 0, 0], [0, 0, 0])
        pushed = free.force[:, 2] > 0
        longest = (0.3 * free.force[pushed, 2] / self.hold[pushed]).min()
        held = self.touch([0.2 * longest, 0, 0], [0.3 * longest, 0, 5 * longest])
        np.testing.assert_allclose(held.force[pushed, 0], -self.hold[pushed] * 0.5 * longest)
        self.assertTrue((held.bonds[0, ~pushed] == 0).all())
        # bonds that are longer than the present force can hold are cut
        cut = self.touch([0, 0, 0], [0, 1e3 * longest, 0])
        np.testing.assert_allclose(cut.force[pushed, 1], -0.3 * free.force[pushed, 2])


class Momentum(unittest.TestCase):
    """Velocities at the end of a step."""

    def test_a_free_fall_has_the_velocity_of_gravity(self) -> None:
        state = make_state(cells=[(1, 0, 0), (2, 0, 0)])
        state.grid["pinned"][:] = 0
        state.steps = {"scheme": np.array([2]), "length": np.array([DT])}
        body = equations.make_body(state)
        v = np.tile([0.3, 0.5, -0.2], (len(body.rest), 1))
        k = stages.SHARE * DT
        state.x_stage = [body.rest + k * v + k * k * state.gravity]
        start = Start(body.rest, v)
        step = stages.StageStep(state, body, find_pieces(state, body), 0, start)
        end = step.recompute(body.rest + DT * v + DT**2 / 2 * state.gravity)
        self.assertLess(end.residual, 1e-9)
        np.testing.assert_allclose(end.velocity, v + DT * state.gravity, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
