# SPDX-License-Identifier: Apache-2.0
"""Where a clip of the command stands: sizes, axes, formats."""

from __future__ import annotations

import unittest

import numpy as np

import glb_check
import kept
from command import animate, glb_bytes, glb_parts, write_ply, write_stl
from glb_file import Document, local_positions, read_document, world_positions
from test_command import BOX, SMALL, Command, small


class Poses(Command):
    """--size and --up turn and scale a root node; the file's numbers stay."""

    def sizes(self, document: Document, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Place of the first vertices, (8, 3): in the mesh, and as shown."""
        local, world = local_positions(document, frame), world_positions(document, frame)
        return next(iter(local.values()))[:8], next(iter(world.values()))[:8]

    def test_size_is_in_the_root_node(self) -> None:
        plain, sized = self.animated(*SMALL), self.animated(*SMALL, "--size", "60cm")
        np.testing.assert_array_equal(self.sizes(plain, 0)[0], self.sizes(sized, 0)[0])
        self.assertAlmostEqual(np.ptp(self.sizes(sized, 0)[1], axis=0).max(), 0.6, 6)
        self.assertEqual(len(plain.items("nodes")) + 1, len(sized.items("nodes")))

    def test_up_z_falls_along_z_and_is_shown_along_y(self) -> None:
        free = ("--voxels", 8, "--frames", 3, "--fps", 10, "--up", "z", "--size", "1m")
        document = self.animated(*free)
        local = self.sizes(document, 3)[0] - self.sizes(document, 0)[0]
        shown = self.sizes(document, 3)[1] - self.sizes(document, 0)[1]
        scale = 1 / np.ptp(BOX[0], axis=0).max()
        np.testing.assert_allclose(local[:, :2], 0, atol=2e-3)
        self.assertTrue((local[:, 2] < -0.1).all())
        np.testing.assert_allclose(shown, scale * local[:, [0, 2, 1]] * [1, 1, -1], atol=1e-6)

    def test_free_fall_is_that_of_the_time_scheme(self) -> None:
        document = self.animated("--voxels", 8, "--frames", 4, "--substeps", 1, "--fps", 50,
                                 "--glb-profile", "keyframe")
        for frame in range(5):
            fall = 9.81 * (0.02 * frame) ** 2 / 2  # SDIRK2 is exact for a parabola
            moved = self.sizes(document, frame)[1] - self.sizes(document, 0)[1]
            np.testing.assert_allclose(moved, np.tile([0, -fall, 0], (8, 1)), atol=2e-5)

    def test_profiles_agree_within_the_stated_error(self) -> None:
        swing = (*small(frames=12), "--velocity", "0,1,0.5", "--size", "50cm")
        modal = self.animated(*swing)
        keyframe = self.animated(*swing, "--glb-profile", "keyframe", name="keyframe.glb")
        record = modal.json["asset"]["extras"]["elastogen"]
        self.assertEqual(record["tolerance_m"], 0.0005)
        self.assertLessEqual(record["max_error_m"], record["tolerance_m"])
        self.assertLess(record["targets"], 12)
        worst = max(np.linalg.norm(self.sizes(modal, t)[1] - self.sizes(keyframe, t)[1], axis=1
                                   ).max() for t in range(13))
        self.assertLessEqual(worst, record["max_error_m"] + 1e-6)
        self.assertGreater(np.abs(self.sizes(modal, 12)[1] - self.sizes(modal, 0)[1]).max(), 0.05)

    def test_every_format_keeps_vertices_and_their_order(self) -> None:
        box, folder = BOX, self.folder
        sources = [self.source, *(write_ply(folder / f"{e}.ply", *box, e) for e in (
            "ascii", "binary_little_endian", "binary_big_endian"))]
        sources += [write_stl(folder / f"{t}.stl", *box, t) for t in (True, False)]
        glb = folder / "box.glb"
        glb.write_bytes(glb_bytes(*glb_parts(*box)))
        for source in (*sources, glb):
            with self.subTest(source.name):
                done = animate(source, self.output, *SMALL)
                self.assertEqual(done.code, 0, done.err)
                document = read_document(self.output)
                glb_check.check_animation(document)
                kept.check_kept(source, document)


if __name__ == "__main__":
    unittest.main()
