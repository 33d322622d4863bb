# SPDX-License-Identifier: Apache-2.0
"""The metal frame of examples/scenes: its mesh, and its way under the plate."""

from __future__ import annotations

import json
import sys
import tempfile
import unittest
from pathlib import Path

from command import run

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "scenes"))
from frame_mesh import tets, triangles, write_triangles  # noqa: E402

SCENES = ROOT / "examples" / "scenes"


class Frames(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_the_mesh_is_what_its_script_makes(self) -> None:
        mesh = triangles()
        self.assertEqual((len(mesh.x), len(mesh.tets)), (512, 768))
        made = write_triangles(self.folder / "frame.msh", mesh).read_text()
        self.assertEqual(made, (SCENES / "metal_frame_2d.msh").read_text())
        deep = tets()
        self.assertEqual((len(deep.x), len(deep.tets)), (5632, 23040))

    def test_the_plate_bends_the_frame_for_good(self) -> None:
        for name in ("metal_frame_2d", "metal_frame_nh_2d"):
            log = self.folder / f"{name}.jsonl"
            done = run("simulate", "--scene", SCENES / f"{name}.toml", "--frames", 8, "--log-json",
                       log, "-o", self.folder / "frame.ply")
            self.assertEqual(done.code, 0, done.err)
            steps = [json.loads(line) for line in log.read_text().splitlines()]
            self.assertEqual(len(steps), 16)
            self.assertTrue(all(step["converged"] for step in steps))
            work = [step["energies"]["plastic"] for step in steps]
            self.assertEqual(work, sorted(work))
            self.assertGreater(work[-1], 0)

    def test_triangles_are_what_they_are(self) -> None:
        mesh = SCENES / "metal_frame_2d.msh"
        done = run("simulate", mesh, "--element", "tet4", "-o", self.folder / "a.glb")
        self.assertEqual(done.code, 2)
        self.assertIn("plane triangles, which are tri3", done.err)
        done = run("simulate", mesh, "--traction", "y>90%: 1,0,0", "--pin", "y<5%", "-o",
                   self.folder / "a.glb")
        self.assertEqual(done.code, 2)
        self.assertFalse((self.folder / "a.glb").exists())


if __name__ == "__main__":
    unittest.main()
