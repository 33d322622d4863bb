# SPDX-License-Identifier: Apache-2.0
"""Bodies that fall apart: from an asset to points, one file a frame."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

from command import run
from particle_files import read_ply

EDGE = 0.2


def write_cube(path: Path) -> Path:
    """A cube whose left half (x < 0) is red and whose right half is blue, in two boxes of quads."""
    lines = ["mtllib cube.mtl"]
    for x in (-0.1, 0.0, 0.1):
        for y, z in ((0, 0), (EDGE, 0), (EDGE, EDGE), (0, EDGE)):
            lines.append(f"v {x} {y} {z}")
    sides = [[(k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4)],
             [(k + 4, (k + 1) % 4 + 4, (k + 1) % 4 + 8, k + 8) for k in range(4)]]
    sides[0].append((3, 2, 1, 0))
    sides[1].append((8, 9, 10, 11))
    for name, faces in zip(("red", "blue"), sides):
        lines.append(f"usemtl {name}")
        lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    path.with_name("cube.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    return path


class Particles(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.cube = write_cube(self.folder / "cube.obj")

    def test_a_cube_of_sand_falls_apart_on_a_floor(self) -> None:
        report = self.folder / "report.json"
        done = run("animate", self.cube, "--material", "sand", "--floor", "--voxels", 8, "--frames", 8,
                   "-o", self.folder / "s.ply", "--report", report)
        self.assertEqual(done.code, 0, done.err)
        said = json.loads(report.read_text())
        self.assertEqual(said["converged_share"], 1)
        frames = sorted(self.folder.glob("s_*.ply"))
        self.assertEqual(len(frames), 9)
        first, colours = read_ply(frames[0]).x, read_ply(frames[0]).colour
        last = read_ply(frames[-1]).x
        self.assertEqual(len(first), 8 ** 3 * 8)
        self.assertEqual(len(last), len(first))
        # it spreads, sinks, stays on the floor but for the cell in which contact acts, and nothing
        # pushes it to a side
        self.assertGreater(np.ptp(last[:, 0]), 1.3 * EDGE)
        self.assertLess(last[:, 1].mean(), 0.8 * first[:, 1].mean())
        self.assertGreater(last[:, 1].min(), -EDGE / 8)
        self.assertLess(abs(last[:, 0].mean() - first[:, 0].mean()), 0.02 * EDGE)
        self.assertLess(last[:, 1].mean(), first[:, 1].mean())
        # colours are those of the asset
        inner = np.abs(first[:, 0]) > EDGE / 8
        is_red = colours[:, 0] > 200
        self.assertTrue(np.all(is_red[inner] == (first[inner, 0] < 0)))

    def test_a_pin_holds_what_lies_in_it(self) -> None:
        border = 0.6 * EDGE
        for pin in ("y>60%", "box(-20%,60%,-20%,120%,120%,120%)"):
            with self.subTest(pin):
                done = run("animate", self.cube, "--material", "packed-snow", "--method", "mpm",
                           "--voxels", 10, "--frames", 6, "--fps", 24, "-o",
                           self.folder / "h.ply", "--pin", pin)
                self.assertEqual(done.code, 0, done.err)
                frames = sorted(self.folder.glob("h_*.ply"))
                rest, last = (read_ply(frame).x for frame in (frames[0], frames[-1]))
                # a cell and a half behind the border all nodes around a particle are held
                inner = rest[:, 1] > border + 1.5 * EDGE / 10
                self.assertGreater(inner.sum(), 0)
                np.testing.assert_allclose(last[inner], rest[inner], rtol=0, atol=1e-7)
                # the rest hangs from the border: rho g L^2/2E
                sag = (rest - last)[rest[:, 1] < EDGE / 20, 1].mean()
                self.assertLess(abs(sag / (400 * 9.81 * border ** 2 / (2 * 3e6)) - 1), 0.1)
                for frame in frames:
                    frame.unlink()

    def test_what_particles_cannot_do_is_refused_before_anything_is_written(self) -> None:
        for verb, option, value in (("animate", "--pin", "all"), ("simulate", "--hold", "y<5%: y"),
                                    ("animate", "--move", "y<5%: shift 1cm")):
            with self.subTest(option):
                done = run(verb, self.cube, "--material", "sand", "--voxels", 8, "--frames", 1,
                           "-o", self.folder / "r.ply", option, value)
                self.assertEqual(done.code, 2, done.out)
                self.assertIn(option, done.err)
                self.assertEqual(list(self.folder.glob("r_*")), [])


if __name__ == "__main__":
    unittest.main()
