# SPDX-License-Identifier: Apache-2.0
"""The referee's rigid references, against closed forms."""

from __future__ import annotations

import unittest

import numpy as np

import equations
import references
from references import Momenta, Start, find_pieces
from synthetic import H, make_state

NOTHING = np.zeros(3, bool)  # is held along an axis


class References(unittest.TestCase):
    """Rigid motions."""

    def test_a_symmetric_top_precesses(self) -> None:
        """w turns about L at |L|/I_1, the body about its axis at the rest."""
        I = np.diag([2.0, 2.0, 3.0])
        L, t = np.array([0.6, 0.0, 1.5]), 1.7
        m = Momenta(np.zeros(3), np.zeros(3), L, I)
        pose = references.loose_pose(m, NOTHING, t)
        size = float(np.linalg.norm(L))
        precession = references.turned(L / size, size / 2 * t)
        own = references.turned(np.array([0, 0, 1.0]), L[2] * (1 / 3 - 1 / 2) * t)
        np.testing.assert_allclose(pose.R, precession @ own, atol=1e-11)
        np.testing.assert_allclose(pose.R @ I @ pose.R.T @ pose.w, L, atol=1e-12)

    def test_velocity_and_acceleration_are_derivatives(self) -> None:
        random = np.random.default_rng(2)
        m = Momenta(random.normal(size=3), random.normal(size=3), random.normal(size=3),
                    np.diag([1.0, 2.0, 2.5]))
        x0, t, e = random.normal(size=(4, 3)), 0.8, 1e-4
        for pose in (lambda t: references.loose_pose(m, NOTHING, t),
                     lambda t: references.loose_pose(m, NOTHING | [False, True, False], t),
                     lambda t: references.pinned_pose(m.centre, m.spin, 0.6, t)):
            low, here, high = (pose(s).motion(x0) for s in (t - e, t, t + e))
            np.testing.assert_allclose((high[0] - low[0]) / (2 * e), here[1], atol=1e-7)
            np.testing.assert_allclose((high[1] - low[1]) / (2 * e), here[2], atol=1e-7)

    def test_a_rigid_turn_has_its_angular_velocity(self) -> None:
        random = np.random.default_rng(3)
        mass, x, w = random.uniform(1, 2, 9), random.normal(size=(9, 3)), np.array([1.0, -2, 0.5])
        about = np.array([0.3, 0.2, -0.1])
        m = references.momenta(mass, x, np.cross(w, x - about))
        np.testing.assert_allclose(references.turn_about(m, mass.sum(), about, NOTHING), w, atol=1e-12)

    def test_holds_along_axes_leave_the_others_and_a_turn_about_the_only_one(self) -> None:
        random = np.random.default_rng(5)
        mass, x, v = random.uniform(1, 2, 9), random.normal(size=(9, 3)), random.normal(size=(9, 3))
        m = references.momenta(mass, x, v)
        one = references.loose_pose(m, NOTHING | [False, True, False], 0.7)
        flat = x - m.centre
        flat[:, 1] = 0  # moments and spin about an axis are those of the mass moved along it
        w = mass @ np.cross(flat, v - m.velocity)[:, 1] / (mass @ (flat**2).sum(1))
        np.testing.assert_allclose(one.w, [0, w, 0], atol=1e-12)
        np.testing.assert_allclose(one.velocity, m.velocity * [1, 0, 1], atol=1e-15)
        np.testing.assert_allclose(one.R, references.turned(np.array([0, 1.0, 0]), 0.7 * w), atol=1e-12)
        two = references.loose_pose(m, NOTHING | [True, True, False], 0.7)
        np.testing.assert_allclose([two.w, two.velocity], [[0] * 3, m.velocity * [0, 0, 1]], atol=1e-15)

    def test_what_dependent_nodes_follow_from_pins_a_piece(self) -> None:
        # dependent nodes at the distances -0.3 and 0.05 from a border, of which theirs and the parent
        # nodes' displacements are in proportion
        state = make_state(cells=[(0, 0, 0), (1, 0, 0), (2, 0, 0)])
        grid, border = state.grid, np.array([0.9, 0, 0]) * H
        cell = np.rint((grid["rest"] - grid["rest"].min(0)) / H).astype(int)
        grid["pinned"] = np.where(cell[:, 0] < 2, 2, 0).astype(grid["pinned"].dtype)
        rows = [(n, np.flatnonzero((cell == [2, *cell[n, 1:]]).all(1))[0], (cell[n, 0] - 0.9) / 1.1)
                for n in np.flatnonzero(cell[:, 0] < 2)]
        for name, values in zip(("dependent", "parent", "parent_weight"), zip(*rows)):
            grid[name] = np.array(values, np.float64 if name == "parent_weight" else np.int32)
        body = equations.make_body(state)
        pieces = find_pieces(state, body)
        self.assertEqual(pieces.loose, [False])
        middle = grid["rest"].min(0) + border + np.array([0, 0.5, 0.5]) * H
        np.testing.assert_allclose(pieces.pins[0], middle, atol=1e-12 * H)
        # the reference of a body that turns there meets the border: u of its points is 0
        w = np.array([0.4, -2.0, 3.0])
        start = Start(body.rest, body.follow(np.cross(w, body.rest - middle)))
        z, speed, pull = references.Reference(body, pieces, start).at(0.1)
        for field in (z - body.rest, speed, pull):
            self.assertGreater(np.abs(field).max(), 0.1 * H)
            np.testing.assert_allclose(body.follow(field), field, atol=1e-14)

    def test_pieces_are_voxels_that_share_nodes(self) -> None:
        state = make_state(cells=[(0, 0, 0), (1, 1, 1), (4, 0, 0), (5, 0, 0), (9, 0, 0)])
        pieces = find_pieces(state, equations.make_body(state))
        voxels = pieces.of[state.grid["corners"][:, 0]]
        self.assertEqual(len(pieces.mass), 3)
        self.assertEqual(voxels[0], voxels[1])
        self.assertEqual(voxels[2], voxels[3])
        self.assertEqual([pieces.loose[p] for p in (voxels[0], voxels[2], voxels[4])],
                         [False, True, True])
        self.assertAlmostEqual(pieces.mass.sum(), state.grid["mass"].sum())
        pinned = state.grid["rest"][state.grid["pinned"] != 0]
        np.testing.assert_allclose(pieces.pins[voxels[0]], pinned.mean(0))


if __name__ == "__main__":
    unittest.main()
