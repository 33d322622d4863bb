# SPDX-License-Identifier: Apache-2.0
"""Bodies that fall apart: from an asset to points, one file a frame."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np
from command import run
from numpy.typing import NDArray

EDGE, GRAVITY = 0.2, 9.81


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


def read_points(path: Path) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Places and colours of the points of a PLY file."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    types = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    fields = [line.split()[1:] for line in head.decode().splitlines() if line.startswith("property")]
    rows = np.frombuffer(body, [(name, types[kind]) for kind, name in fields])
    x = np.column_stack([rows[a].astype(float) for a in "xyz"])
    colours = ("red", "green", "blue")
    return x, np.column_stack([rows[c] for c in colours]) if "red" in rows.dtype.names else None


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
        first, colours = read_points(frames[0])
        last, _ = read_points(frames[-1])
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

    def test_what_particles_cannot_do_is_refused_before_anything_is_written(self) -> None:
        for options, word in ((["--pin", "y<5%"], "--pin"), (["--state", "x.h5"], "--state")):
            with self.subTest(word):
                done = run("animate", self.cube, "--material", "sand", "--voxels", 8, "--frames", 1,
                           "-o", self.folder / "r.ply", *options)
                self.assertEqual(done.code, 2, done.out)
                self.assertIn(word, done.err)
                self.assertEqual(list(self.folder.glob("r_*")), [])
        for ending in ("glb", "pvd"):
            done = run("animate", self.cube, "--material", "sand", "--voxels", 8, "--frames", 1,
                       "--floor", "-o", self.folder / f"r.{ending}")
            self.assertEqual(done.code, 2, done.out)
            self.assertIn(".ply", done.err)
            self.assertFalse((self.folder / f"r.{ending}").exists())


if __name__ == "__main__":
    unittest.main()
