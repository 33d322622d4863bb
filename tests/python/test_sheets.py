# SPDX-License-Identifier: Apache-2.0
"""Mass and bending of sheets with a thickness of their own, against the formula of a plate."""

from __future__ import annotations

import re
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
from command import Run, run

LENGTH, WIDTH = 1.0, 0.25
PINNED = 0.001  # of the length; a layer of nodes lies there
YOUNG, POISSON, DENSITY = 1e7, 0.3, 1000.0


def write_strip(path: Path) -> Path:
    """An open strip of 16 x 4 squares in y = 0."""
    lines = [f"v {LENGTH * i / 16!r} 0 {WIDTH * j / 4!r}" for j in range(5) for i in range(17)]
    for j in range(4):
        for i in range(16):
            a = 17 * j + i + 1
            lines.append(f"f {a} {a + 17} {a + 18} {a + 1}")
    path.write_text("\n".join(lines) + "\n")
    return path


class Sheets(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.strip = write_strip(self.folder / "strip.obj")

    def clamped(self, voxels: int, gravity: float, *options: object) -> tuple[Run, float, float]:
        """The equilibrium of the strip held at one end; how far its tip sinks; its mass."""
        state = self.folder / "strip.h5"
        done = run("simulate", self.strip, "--static", "--voxels", voxels, "--pin", "x<0.1%",
                   "--hold", "all: z", "--young", YOUNG, "--poisson", POISSON, "--density",
                   DENSITY, "--gravity", f"0,{-gravity},0", "--tolerance", "1e-8", "--state",
                   state, "-o", self.folder / "strip.pc2", *options)
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(state) as file:
            rest, x = file["/grid/rest"][:], file["/steps/x"][-1]
            mass = float(np.sum(file["/grid/mass"][:]))
        ends = np.unique(np.round(rest[:, 0], 9))[-2:]  # the last two columns of nodes
        sunk = [float(np.mean((rest - x)[np.abs(rest[:, 0] - end) < 1e-8, 1])) for end in ends]
        return done, float(sunk[1] + (LENGTH - ends[1]) * np.diff(sunk)[0] / np.diff(ends)[0]), mass

    def test_mass_and_bending_are_those_of_a_plate_at_any_voxel_size(self) -> None:
        for thickness, gravity in ((0.002, 3e-5), (0.006, 3e-4)):
            stiffness = YOUNG * thickness ** 3 / (12 * (1 - POISSON ** 2))  # of a plate
            free = LENGTH - PINNED
            sag = DENSITY * gravity * thickness * free ** 4 / (8 * stiffness)
            weight = DENSITY * LENGTH * WIDTH * thickness
            for voxels in (16, 32, 64):
                with self.subTest(thickness=thickness, voxels=voxels):
                    done, tip, mass = self.clamped(voxels, gravity, "--thickness",
                                                   f"{1000 * thickness} mm")
                    self.assertAlmostEqual(tip / sag, 1, delta=0.001)
                    self.assertAlmostEqual(mass / weight, 1, delta=1e-9)
                    self.assertIn(f"sheets of {thickness:g} m (--thickness), {weight:g} kg",
                                  done.out)

    def test_without_it_the_thickness_taken_is_said_with_its_mass(self) -> None:
        for voxels in (16, 32):
            done, _, mass = self.clamped(voxels, 1e-3)
            found = re.search(r"sheets of ([\d.]+) m \(a voxel; --thickness sets it\), ([\d.]+) kg",
                              done.out)
            self.assertIsNotNone(found, done.out)
            assert found
            self.assertAlmostEqual(float(found[1]), LENGTH / voxels, delta=1e-5)
            self.assertAlmostEqual(float(found[2]) / mass, 1, delta=1e-3)
            columns = voxels + 1  # the lattice begins before the pinned plane
            self.assertAlmostEqual(mass, DENSITY * WIDTH * columns / voxels ** 2, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
