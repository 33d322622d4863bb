# SPDX-License-Identifier: Apache-2.0
"""What bench/peers gives to other codes."""

from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench" / "peers"))
import c84_mesh  # noqa: E402


class Lattice(unittest.TestCase):
    """Five tetrahedra a cell."""

    def test_tetrahedra_fill_the_beam_and_share_their_faces(self) -> None:
        nodes, tets, cells = c84_mesh.lattice(500)
        self.assertEqual(cells, 20 * 5 * 5)
        self.assertEqual(len(tets), 5 * cells)
        edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]
        volumes = np.linalg.det(edges) / 6
        self.assertGreater(volumes.min(), 0)
        self.assertAlmostEqual(volumes.sum(), 1 / 16, places=14)
        faces = np.sort(np.concatenate([np.delete(tets, k, axis=1) for k in range(4)]), axis=1)
        _, times = np.unique(faces, axis=0, return_counts=True)
        self.assertEqual(times.max(), 2)
        # two triangles a square of the surface: four long sides and both ends
        self.assertEqual((times == 1).sum(), 2 * (4 * 20 * 5 + 2 * 5 * 5))

    def test_no_tetrahedron_has_two_nodes_of_a_colour(self) -> None:
        for size in (4, 32, 500):
            nodes, tets, _ = c84_mesh.lattice(size)
            colours = c84_mesh.colours(size)
            self.assertEqual(len(colours), len(nodes))
            np.testing.assert_array_equal(np.sort(colours[tets], axis=1),
                                          np.tile(np.arange(4), (len(tets), 1)))

    def test_tip_is_the_middle_of_the_free_end(self) -> None:
        for size, count in ((500, 4), (256, 1)):  # odd and even numbers of cells across
            nodes, _, _ = c84_mesh.lattice(size)
            tip = c84_mesh.tip_of(nodes)
            self.assertEqual(len(tip), count)
            np.testing.assert_allclose(nodes[tip].mean(axis=0), [1, 0.125, 0.125], atol=1e-15)


if __name__ == "__main__":
    unittest.main()
