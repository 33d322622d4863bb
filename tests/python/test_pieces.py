# SPDX-License-Identifier: Apache-2.0
"""Pieces that lie close: joined with a word, kept apart on request, and those that nothing holds."""

from __future__ import annotations

import re
import tempfile
import unittest
from pathlib import Path

import numpy as np
from command import Run, animate, run, turned_box
from glb_check import check_animation
from glb_file import local_positions, read_document

GAP = 0.004
OPTIONS = ("--voxels", 12, "--frames", 6, "--young", "2e4")


def write_boxes(path: Path, offsets: dict[str, tuple[float, float, float]]) -> Path:
    """An OBJ of boxes of half a metre, each an object of its name."""
    position, faces = turned_box((0.5, 0.5, 0.5), (0, 0, 1), 0)
    lines, first = [], 1
    for name, offset in offsets.items():
        lines.append(f"o {name}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in (position + np.array(offset)).tolist()]
        lines += ["f " + " ".join(str(first + v) for v in face) for face in faces]
        first += len(position)
    path.write_text("\n".join(lines) + "\n")
    return path


class Pieces(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.output = self.folder / "out.glb"
        self.pair = write_boxes(self.folder / "pair.obj", {"Body": (0, 0, 0),
                                                           "Hat": (0.5 + GAP, 0.1, 0)})

    def motions(self) -> list[float]:
        """How far the farthest vertex of each mesh has moved at the end."""
        document = read_document(self.output)
        check_animation(document)
        first, last = (local_positions(document, t) for t in (0, 6))
        return [float(np.linalg.norm(last[key] - first[key], axis=1).max())
                for key in sorted(first)]

    def animated(self, source: Path, *options: object) -> Run:
        done = animate(source, self.output, *OPTIONS, *options)
        self.assertEqual(done.code, 0, done.err)
        return done

    def test_pieces_that_voxels_join_are_said_with_names_gap_and_the_voxel_that_parts_them(
            self) -> None:
        pins = ("--pin", "x<1%")
        done = self.animated(self.pair, *pins)
        self.assertIn(f"'Body' and 'Hat' ({GAP:.2g} m)", done.err)
        self.assertGreater(min(self.motions()), 1e-4)  # the hat hangs on the body
        found = re.search(r"voxels of ([\d.e-]+) m would part them", done.err)
        assert found, done.err
        parts = float(found[1])
        self.assertLess(parts, GAP / 2)
        small = write_boxes(self.folder / "small.obj", {"Body": (0, 0, 0), "Hat": (0.54, 0.1, 0)})
        fine = run("doctor", small, "--h", 0.04 / (2 * 3 ** 0.5) * 0.99)
        self.assertNotIn("joined-pieces", fine.out)
        self.assertIn("loose-pieces", fine.out)
        strict = animate(self.pair, self.output, *OPTIONS, *pins, "--strict")
        self.assertEqual(strict.code, 2)

    def test_parted_pieces_move_by_themselves(self) -> None:
        done = self.animated(self.pair, "--pin", "x<1%", "--part-pieces")
        self.assertNotIn("joined", done.err)
        self.assertIn("1 of 2 pieces ('Hat') is held by nothing and above nothing", done.err)
        body, hat = self.motions()
        time = 6 / 30
        self.assertAlmostEqual(hat, 9.81 * time ** 2 / 2, delta=0.1 * 9.81 * time ** 2)
        # the body hangs as it does alone
        alone = write_boxes(self.folder / "alone.obj", {"Body": (0, 0, 0)})
        edge = 1.004 / 12  # the voxel of both
        done = animate(alone, self.output, "--h", edge, *OPTIONS[2:], "--pin", "x<1%")
        self.assertEqual(done.code, 0, done.err)
        self.assertAlmostEqual(self.motions()[0] / body, 1, delta=0.05)

    def test_parts_of_clouds_of_points_move_with_their_own(self) -> None:
        side = np.linspace(-0.25, 0.25, 40)
        shell = np.array([(x, y, z) for x in side for y in side for z in side
                          if max(abs(x), abs(y), abs(z)) > 0.2499])
        cloud = np.vstack([shell, shell + [0.67, 0, 0]])
        source = self.folder / "two.xyz"
        np.savetxt(source, cloud, "%.9g")
        output = self.folder / "two.pc2"
        done = animate(source, output, *OPTIONS[:4], "--young", "1e6", "--pin", "x<1%",
                       "--part-pieces")
        self.assertEqual(done.code, 0, done.err)
        data = output.read_bytes()
        frames = np.frombuffer(data[32:], "<f4").reshape(-1, len(cloud), 3)
        fallen = frames[0, :, 1] - frames[-1, :, 1]
        self.assertGreater(fallen[len(shell):].min(), 0.15)
        self.assertLess(fallen[:len(shell)].max(), 0.15)

    def test_a_piece_that_nothing_holds_is_named_unless_something_is_below(self) -> None:
        loose = write_boxes(self.folder / "loose.obj", {"Body": (0, 0, 0), "Hat": (1, 0, 0),
                                                        "Shoe": (2, 0, 0)})
        for options, names in (
                (("--pin", "x<1%"), "2 of 3 pieces ('Hat', 'Shoe') are held"),
                (("--pin", "y<1%"), ""),
                (("--pin", "x<1%", "--floor"), ""),
                (("--pin", "x<1%", "--collider", "plane(0,-9,0, 0.6,0.8,0)"), ""),
                (("--pin", "x<1%", "--collider", "box(0.8,-9,-1, 1.2,-8,1)"), "('Shoe') is held"),
                (("--pin", "x<1%", "--collider", "sphere(2,-9,0, 0.3)"), "('Hat') is held"),
                (("--pin", "x<1%", "--gravity", "0,0,0"), ""),
                (("--collider", "sphere(1,-9,0, 0.3)"), "('Body', 'Shoe') are held")):
            with self.subTest(options):
                done = self.animated(loose, *options)
                self.assertIn(names, done.err)
                self.assertEqual("held by nothing and above nothing" in done.err, bool(names))
                # where each piece is held none is loose
                self.assertEqual("loose-pieces" in done.err, options != ("--pin", "y<1%"))


if __name__ == "__main__":
    unittest.main()
