# SPDX-License-Identifier: Apache-2.0
"""Self-tests of steps by stages, damping, bonds and holders: closed forms, differences, changed files."""

from __future__ import annotations

import unittest

import h5py
import numpy as np

import collision
import damping
import equations
import references
import stages
from holding import Holding, fit_motion, fit_velocity
from references import Start, find_pieces
from state_file import Material
from synthetic import DT, H, add_contact, central_differences, held_records, held_state, make_state
from test_referee import Records, add


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
        R = references.turned(np.array([0.6, 0, 0.8]), 1.2)
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


class Held(unittest.TestCase):
    """What holders do."""

    def setUp(self) -> None:
        self.random = np.random.default_rng(7)

    def test_a_rigid_motion_is_found_from_points_and_shares(self) -> None:
        axis, b = np.array([2.0, -1, 2]) / 3, np.array([0.3, 2, -1])
        for count, flat in ((9, 1.0), (4, 0.0)):  # in space, in a plane
            p = self.random.normal(size=(count, 3)) * [1, 1, flat]
            s = self.random.uniform(-3, 5, count)
            for angle in (0.0, 1.2, np.pi, 5.5):
                A = references.turned(axis, angle)
                fit = fit_motion(p, s, p @ A.T + np.outer(s, b))
                self.assertTrue(fit.is_unique)
                np.testing.assert_allclose(fit.A, A, atol=1e-12)
                np.testing.assert_allclose(fit.b, b, atol=1e-12)
                self.assertLess(fit.off, 1e-13)
                off = fit_motion(p, s, p @ A.T * 1.001 + np.outer(s, b)).off
                self.assertGreater(off, 1e-5)
        # a mirror image is no motion, and points of a line do not tell the turn about it
        p = self.random.normal(size=(9, 3))
        self.assertGreater(fit_motion(p, np.ones(9), p * [1, 1, -1]).off, 0.1)
        line = np.outer(np.arange(4.0), axis)
        self.assertFalse(fit_motion(line, np.ones(4), line).is_unique)

    def test_velocities_of_a_rigid_motion_leave_nothing(self) -> None:
        for flat in (1.0, 0.0):
            x = self.random.normal(size=(7, 3)) * [1, flat, flat] + 5
            v = np.cross([1, 2, -0.5], x - 3)
            self.assertLess(fit_velocity(x, v), 1e-13)
            v[2, 0] += 1e-3
            self.assertGreater(fit_velocity(x, v), 1e-4)

    def test_reactions_are_derivatives_by_the_motion_of_a_holder(self) -> None:
        """Phi without the inertia of pinned nodes, and with the weight that they bear."""
        state = held_state()
        cell = np.rint((state.grid["rest"] - state.grid["rest"].min(0)) / H)
        near = cell[:, 0] <= 1  # pins a voxel as a whole
        state.grid["pinned"][near] = 1
        state.holders.of_node[near] = 0
        state.steps = {"reaction_force": None, "reaction_about": self.random.normal(size=(1, 3, 3))}
        body = equations.make_body(state)
        x, xhat = (body.rest + self.random.normal(0, 0.05 * H, body.rest.shape) for _ in range(2))
        R, weight = equations.rotations(body, body.rest), 1 / DT**2
        pinned = (state.grid["pinned"] == 1)[:, None]
        borne = np.zeros(len(body.mass))
        for v, corners in enumerate(state.grid["corners"]):
            if not near[corners].all():
                density = state.materials[state.grid["material"][v]].density
                borne[corners] += density * state.grid["fill"][v] * H**3 * state.grid["shape_mean"][v]
        self.assertLess(borne[near].sum(), 0.9 * body.mass[near].sum())

        def energy(y: np.ndarray) -> float:
            found = equations.potential_about(body, weight, xhat, y, R)
            inertia = weight / 2 * (body.mass[:, None] * (y - xhat) ** 2)[pinned[:, 0]].sum()
            return found.value - inertia - float((borne[:, None] * y * state.gravity)[pinned[:, 0]].sum())

        found = equations.potential_about(body, weight, xhat, x, R)
        force, moment = Holding(state, body).reactions(0, found, x)
        for h, about in enumerate(state.steps["reaction_about"][0]):
            held = (state.holders.of_node == h)[:, None]
            for d, axis in enumerate(np.eye(3)):
                for own, bar in ((force, np.tile(axis, (len(x), 1))), (moment, np.cross(axis, x - about))):
                    # dependent nodes go along but for what their parents would have brought
                    rate = np.where(held, np.where(body.dependent[:, None], bar - body.follow(bar), bar), 0)
                    e = 1e-6 * H
                    found_rate = (energy(x + e * rate) - energy(x - e * rate)) / (2 * e)
                    self.assertAlmostEqual(own[h, d] / (1 + abs(found_rate)), found_rate / (1 + abs(found_rate)), 5)
        self.assertGreater(np.abs(force[:2]).min(), 1e-2)
        np.testing.assert_array_equal(force[2], 0)


class HeldFile(Records):
    """What holds nodes: a pin, and a move that turns pinned and dependent nodes."""

    records = staticmethod(held_records)

    def node(self, kind: int, holder: int) -> int:
        """A node that is pinned (1) or dependent (2)."""
        return int(np.flatnonzero((self.state.grid["pinned"] == kind) & (self.state.holders.of_node == holder))[1])

    def test_what_it_finds_itself_agrees(self) -> None:
        status, output = self.run_tool()
        self.assertEqual(status, 0, output)
        self.assertIn("4 of 4 steps", output)

    def test_a_wrong_number_of_each_field_is_caught(self) -> None:
        rests, moved, follows = self.node(1, 0), self.node(1, 1), self.node(2, 1)
        last = len(self.state.grid["mass"]) - 1  # of the free piece
        for place, index, by, word in (
                ("holders/offset", (2, 1, 0), 1e-12, "dependent nodes"),
                ("holders/offset", (0, 1, 0), 1e-12, "dependent nodes"),
                ("steps/x", (2, follows, 1), 1e-12, "dependent nodes"),
                ("steps/x", (3, moved, 2), 1e-12, "held places"), ("steps/x", (1, rests, 0), 1e-12, "held places"),
                ("steps/x_stage", (0, moved, 2), 1e-12, "held places of stage"),
                ("steps/x_stage", (2, follows, 1), 1e-12, "held places of stage"),
                ("steps/x_stage", (2, rests, 1), 1e-12, "held places of stage"),
                ("steps/v", (2, moved, 0), 1e-9, "held velocities"),
                ("steps/v", (1, rests, 0), 1e-9, "held velocities"),
                ("steps/v", (4, follows, 1), 1e-3, "velocity"),
                ("steps/reaction_force", (1, 1, 2), 1e-4, "reaction_force"),
                ("steps/reaction_force", (0, 0, 0), 1e-4, "reaction_force"),
                ("steps/reaction_moment", (3, 1, 0), 1e-5, "reaction_moment"),
                ("steps/reaction_about", (1, 0, 0), 1e-9, "reaction_about"),
                ("steps/reaction_about", (2, 1, 1), 1e-9, "reaction_about"),
                ("grid/traction", (last, 1), 0.01, "residual"),
                ("grid/traction", (rests, 1), 0.01, "reaction_force"),
                ("grid/parent_weight", 3, 1e-9, "held places")):
            self.assert_says(word, add(place, index, by))

    def test_a_wrong_time_error_is_caught(self) -> None:
        for step in range(4):  # by SDIRK2, BDF2 and implicit Euler
            for factor in (0.98, 1.02):
                self.assert_says("time_error", add("steps/time_error", step, 0, factor))

    def test_a_filter_may_lower_a_time_error_and_never_raises_it(self) -> None:
        """At a time error near what is accepted the program takes out what a frame cannot show."""
        self.assertEqual(self.run_tool(add("steps/time_ratio", 1, 0.5))[0], 0)

        def change(by: float) -> Any:
            return lambda file: (add("steps/time_ratio", 1, 0.5)(file), add("steps/time_error", 1, 0, by)(file))
        self.assertEqual(self.run_tool(change(0.3))[0], 0)
        self.assert_says("time_error", change(1.1))

    def test_a_step_above_its_time_error_is_not_converged(self) -> None:
        def solved(ratio: float) -> Any:
            def change(file: h5py.File) -> None:
                file["steps/tolerance"][...] = 1e9
                file["steps/converged"][...] = 1
                add("steps/time_ratio", 3, ratio)(file)
            return change
        self.assertEqual(self.run_tool(solved(0))[0], 0)
        self.assert_says("converged", solved(1))

    def test_files_of_version_4_are_read(self) -> None:
        def older(file: h5py.File) -> None:
            file.attrs.modify("version", 4)
            del file["steps/time_error"], file["steps/time_ratio"]
        self.assertEqual(self.run_tool(older)[0], 0)
        self.assert_says("time_error", lambda file: file.attrs.modify("version", 4))

    def test_places_that_fit_together_but_no_rigid_motion_are_caught(self) -> None:
        """Offsets and the nodes that they move, stretched alike."""
        def stretch(file: h5py.File) -> None:
            extra = 1e-9 * file["holders/offset"][1]
            add("holders/offset", 1, extra)(file)
            add("steps/x", (1, np.flatnonzero(self.state.grid["pinned"] == 2)), extra)(file)
        self.assert_says("held places", stretch)

    def test_a_pin_rests(self) -> None:
        def rename(file: h5py.File) -> None:
            names = file["holders/name"][()]
            names[1] = b"--pin 'x>99%'"
            file["holders/name"][...] = names
        for word in ("held places", "held velocities"):
            self.assert_says(word, rename)

    def test_wrong_layout_is_named(self) -> None:
        def resized(file: h5py.File) -> None:
            offset = file["holders/offset"][:, 1:]
            del file["holders/offset"]
            file["holders/offset"] = offset

        free = int(np.flatnonzero(self.state.grid["pinned"] == 0)[0])
        for change, word in (
                (lambda f: f["holders"].pop("of_node"), "of_node"),
                (lambda f: f.pop("holders"), "without /holders"),
                (lambda f: f["steps"].pop("reaction_moment"), "reaction_moment"),
                (lambda f: f["holders"].create_dataset("path", data=[1.0]), "path"),
                (lambda f: f["holders"].pop("offset"), "dependent nodes"),
                (lambda f: f.attrs.modify("moved", 0), "moved"), (resized, "dependent nodes"),
                (add("holders/of_node", free, 1), "of_node must be -1"),
                (add("holders/of_node", self.node(1, 0), 3), "of_node must lie in -1..2"),
                (add("holders/offset", (1, 0, 0), np.nan), "/holders/offset"),
                (add("steps/reaction_force", (1, 0, 0), np.nan), "/steps/reaction_force"),
                (add("steps/reaction_force", (1, 2, 0), 1), "holds no node"),
                (lambda f: f["holders/name"].write_direct(np.array([b"", b"", b""], f["holders/name"].dtype)),
                 "/holders/name")):
            self.assert_says(word, change)


if __name__ == "__main__":
    unittest.main()
