# SPDX-License-Identifier: Apache-2.0
"""What finite elements are told: --hold, --traction, --move, --static."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from command import Floats, Run, animate, run, turned_box, write_obj

EDGES = (0.4, 0.2, 0.2)  # of the bar about the origin [m]
YOUNG, POISSON = 1e5, 0.3  # [Pa], -
LAME = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))
MATERIAL = ("--young", YOUNG, "--poisson", POISSON, "--law", "neo-hookean")
# nodes lie in the planes of symmetry and on the surface
SYMMETRY = ("--hold", "x<0%: x", "--hold", "y<0%: y", "--hold", "z<0%: z")


def uniaxial(stretch: float) -> tuple[float, float]:
    """Nominal stress [Pa] and lateral stretch of psi = mu/2 (I-3) - mu ln J + lambda/2 ln^2 J.

    The lateral stress mu (s - 1/s) + lambda ln(stretch s^2)/s grows with s: bisection.
    """
    low, high = 0.1, 3.0
    for _ in range(100):
        s = (low + high) / 2
        if MU * (s * s - 1) + LAME * np.log(stretch * s * s) > 0:
            high = s
        else:
            low = s
    return MU * (stretch - 1 / stretch) + LAME * np.log(stretch * s * s) / stretch, s


class Simulate(unittest.TestCase):
    """A folder of its own, with a bar in it."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.source = write_obj(self.folder / "bar.obj", *turned_box(EDGES, (0, 0, 1), 0))
        self.state = self.folder / "run.h5"

    def simulate(self, *options: object, element: str = "voxel",
                 material: tuple[object, ...] = MATERIAL) -> Run:
        gravity = () if "--gravity" in options else ("--gravity", "0,0,0")
        return run("simulate", self.source, "--h", 0.1, *gravity, *material,
                   "--element", element, "--state", self.state, "-o", self.folder / "a.glb",
                   "--report", self.folder / "report.json", "--log-json", self.folder / "log.json",
                   "--quiet", *options)

    def done(self, *options: object, element: str = "voxel") -> tuple[Floats, Floats]:
        """Positions at rest and at the last entry of a run that converged."""
        done = self.simulate(*options, element=element)
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(self.state) as file:
            return file["grid/rest"][()], file["steps/x"][-1]

    def refused(self, done: Run, *words: str) -> None:
        self.assertEqual(done.code, 2, done.err)
        for word in words:
            self.assertIn(word, done.err)


class Static(Simulate):
    def test_the_closed_form_is_that_of_the_literature(self) -> None:
        # nominal stress over E and lateral stretch, to the digits given
        for stretch, stress, lateral in ((0.5, -0.935352, 1.210767), (1.5, 0.378280, 0.880175),
                                         (2.0, 0.646745, 0.798078)):
            own = uniaxial(stretch)
            self.assertAlmostEqual(own[0] / YOUNG, stress, delta=6e-7)
            self.assertAlmostEqual(own[1], lateral, delta=6e-7)

    def test_a_bar_between_planes_of_symmetry_stretches_as_its_law_says(self) -> None:
        elements = ("voxel", "hex", "hex-bbar", "tet4", "tet10", "tet10-bbar")
        for stretch in (0.7, 0.9, 1.5):
            stress, lateral = uniaxial(stretch)
            force = f"x>100%: {stress * EDGES[1] * EDGES[2]!r},0,0"
            # tet10-bbar leaves uniform compression for a pattern within its elements at 0.25 E
            for element in elements[:5] if stretch == 0.7 else elements:
                rest, x = self.done(*SYMMETRY, "--traction", force, "--static", element=element)
                lower = np.array(EDGES) / -2
                expected = lower + (rest - lower) * [stretch, lateral, lateral]
                np.testing.assert_allclose(x, expected, rtol=0, atol=1e-6 * EDGES[0])

    def test_a_pressure_is_a_force_on_a_flat_face(self) -> None:
        area, pressure = EDGES[1] * EDGES[2], -0.1 * YOUNG
        for element in ("voxel", "tet10"):
            ends = [self.done(*SYMMETRY, "--traction", f"x>100%: {load}", "--static",
                              element=element)[1]
                    for load in (f"{-pressure * area!r},0,0", f"{pressure / 1e3!r} kPa")]
            np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-9 * EDGES[0])
        self.refused(self.simulate("--static", "--pin", "x<0%", "--traction", "x>100%: 1 N"),
                     "--traction 'x>100%: 1 N'", "known are Pa")

    def test_its_files_say_what_it_was(self) -> None:
        rest, _ = self.done(*SYMMETRY, "--traction", "x>100%: 100,0,-3 N", "--static",
                            element="tet10")
        with h5py.File(self.state) as file:
            self.assertEqual(file.attrs["time_scheme"], b"static")
            np.testing.assert_array_equal(file["steps/time"], [0, 1])
            np.testing.assert_array_equal(file["steps/x"][0], rest)
            lower = np.array(EDGES) / -2
            np.testing.assert_array_equal(file["grid/fixed"], np.abs(rest - lower) < 1e-9)
            self.assertFalse(file["grid/pinned"][()].any())
            np.testing.assert_allclose(file["grid/traction"][()].sum(0), [100, 0, -3], rtol=1e-12)
            steps = {name: file[f"steps/{name}"][0] for name in ("outer", "inner", "converged")}
        log = [json.loads(line) for line in (self.folder / "log.json").read_text().splitlines()]
        self.assertEqual([(row["frame"], row["time"]) for row in log], [(1, 1)])
        self.assertGreaterEqual(steps["outer"], 1)  # Newton steps
        self.assertGreaterEqual(steps["inner"], 1)  # load increments
        self.assertEqual(steps["converged"], 1)
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual((report["frames"], report["steps"]), (1, 1))

    def test_a_load_without_equilibrium_is_a_draft_that_says_how_far_it_came(self) -> None:
        # Hencky at nu = 0: P = E ln s/s, most at s = e; a larger dead load finds no equilibrium
        force = f"x>100%: {0.5 * YOUNG * EDGES[1] * EDGES[2]!r},0,0"
        done = self.simulate(*SYMMETRY, "--traction", force, "--static",
                             material=("--young", YOUNG, "--poisson", 0, "--law", "hencky"))
        self.assertEqual(done.code, 4, done.err)
        factor = float(done.err.split("load factor of ")[1].split()[0])
        self.assertLess(factor, 1 / np.e / 0.5 + 1e-4)
        self.assertGreater(factor, 1 / np.e / 0.5 - 2e-3)
        with h5py.File(self.state) as file:
            self.assertAlmostEqual(file["steps/time"][1], factor, delta=1e-4)

    def test_a_piece_that_nothing_holds_is_named(self) -> None:
        corners, faces = turned_box(EDGES, (0, 0, 1), 0)
        write_obj(self.source, np.concatenate([corners, corners + [0, 0, 1]]),
                  faces + [[v + len(corners) for v in face] for face in faces])
        held = ("--static", "--pin", "z<0%", "--hold", "z>100%: y")
        done = self.simulate(*held)
        self.assertEqual(done.code, 0, done.err)  # nothing pulls at it
        self.assertIn("warning: --static: nothing holds the piece of 45 nodes in -0.2..0.2, "
                      "-0.1..0.1, 0.9..1.1 m along x, z\n", done.err)
        self.assertEqual(done.err.count("nothing holds"), 1)
        self.refused(self.simulate(*held, "--strict"), "--strict", "nothing holds the piece")
        self.assertNotIn("nothing holds", self.simulate(*held, "--hold", "z>100%: xyz").err)

    def test_what_statics_cannot_do_is_refused(self) -> None:
        self.refused(self.simulate("--static", "--pin", "x<0%", "--floor"), "--floor")
        self.refused(self.simulate("--static"), "--static", "--pin")
        self.refused(self.simulate("--static", "--pin", "x<0%", "--traction", "x>200%: 1,0,0"),
                     "--traction 'x>200%: 1,0,0'", "no face")


class Moves(Simulate):
    TURN = ("--pin", "x<0%", "--move", "x>100%: turn(0,0,0, 1,0,0) 0s:0; 1s:90deg")

    def check_turned(self, rest: Floats, x: Floats) -> None:
        """The far face a quarter turn about x: (y, z) -> (-z, y); the near one where it was."""
        far, near = rest[:, 0] > 0.2 - 1e-9, rest[:, 0] < -0.2 + 1e-9
        self.assertGreater(far.sum(), 0)
        np.testing.assert_allclose(x[far], rest[far][:, [0, 2, 1]] * [1, -1, 1], atol=1e-15)
        np.testing.assert_array_equal(x[near], rest[near])

    def test_a_face_turned_by_a_right_angle_ends_where_it_should(self) -> None:
        for element in ("voxel", "tet10"):
            rest, x = self.done(*self.TURN, "--static", element=element)
            self.check_turned(rest, x)
            # half way the section has turned by half of it: the middle of the edge at (y, z) = (1, 1)
            middle = np.flatnonzero(np.all(np.abs(rest - [0, 0.1, 0.1]) < 1e-9, axis=1))[0]
            y, z = x[middle, 1:]
            self.assertAlmostEqual(np.degrees(np.arctan2(z, y)), 45 + 45, delta=1)

    def test_a_path_is_walked_in_time_and_stays_at_its_end(self) -> None:
        self.done(*self.TURN[:2], "--move", "x>100%: shift 0:0,0,0; 0.5:0,10cm,0; 1:5cm,0,0",
                  "--frames", 12, "--fps", 10, "--substeps", 1)
        with h5py.File(self.state) as file:
            rest, x = file["grid/rest"][()], file["steps/x"][()]
        far = rest[:, 0] > 0.2 - 1e-9
        for entry, offset in ((0, (0, 0, 0)), (4, (0, 0.08, 0)), (5, (0, 0.1, 0)),
                              (7, (0.02, 0.06, 0)), (10, (0.05, 0, 0)), (12, (0.05, 0, 0))):
            np.testing.assert_allclose(x[entry, far] - rest[far], np.tile(offset, (far.sum(), 1)),
                                       atol=1e-15)

    def test_a_turn_in_time_steps_ends_where_it_should(self) -> None:
        rest, x = self.done(*self.TURN, "--frames", 10, "--fps", 10, "--substeps", 1)
        self.check_turned(rest, x)

    def test_contradictions_are_refused_with_both_selections(self) -> None:
        shift = "shift 0:0,0,0; 1:0,1cm,0"
        for first in (("--pin", "x<0%"), ("--hold", "y<0%: z"), ("--move", f"z>0%: {shift}")):
            done = self.simulate(*first, "--move", f"x<50%: {shift}", "--static")
            self.refused(done, f"{first[0]} '{first[1]}'", f"--move 'x<50%: {shift}'")

    def test_a_selection_without_nodes_is_a_warning(self) -> None:
        done = self.simulate("--pin", "x<0%", "--hold", "x>9: y", "--move",
                             "x>9: shift 0:0,0,0", "--traction", "x>100%: 1,0,0", "--static")
        self.assertEqual(done.code, 0, done.err)
        self.assertIn("--hold 'x>9: y' holds nothing", done.err)
        self.assertIn("--move 'x>9: shift 0:0,0,0' holds nothing", done.err)


class Tolerance(Simulate):
    def test_it_is_1e8_unless_rounding_leaves_more(self) -> None:
        for young, least, most in (("1e5", 1e-8, 1e-8), ("2e11", 2e-8, 1e-5)):
            for element in ("voxel", "hex-bbar", "tet10"):
                with self.subTest(young=young, element=element):
                    done = self.simulate("--gravity", "0,-9.81,0", "--pin", "x<0%", "--frames", 2,
                                         element=element, material=("--young", young, "--density",
                                                                    7850, "--poisson", 0.3))
                    self.assertEqual(done.code, 0, done.err)
                    with h5py.File(self.state) as file:
                        self.assertTrue(least <= file.attrs["tolerance"] <= most)


class Network(Simulate):
    def test_a_scene_file_says_the_same(self) -> None:
        scene = self.folder / "scene.toml"
        scene.write_text("[asset]\nfile = 'bar.obj'\n[[hold]]\nselect = 'x<0%'\naxes = 'xyz'\n"
                         "[[traction]]\nselect = 'x>100%'\nforce = [0, '1 N', 0]\n"
                         "[[move]]\nselect = 'box(0,0,0,1cm,1cm,1cm)'\nturn = [[0, '30 deg']]\n"
                         "turn_centre = [0, 0, 0]\nturn_axis = [0, 0, 2]\n")
        first = run("animate", "--scene", scene, "--print-resolved")
        self.assertEqual(first.code, 0, first.err)
        resolved = json.loads(first.out)
        self.assertEqual(resolved["holds"], ["x<0%: xyz"])
        self.assertEqual(resolved["tractions"], ["x>100%: 0,1,0"])
        self.assertEqual(resolved["moves"][0].split(" 0:")[0],
                         "box(0,0,0,1cm,1cm,1cm): turn(0,0,0, 0,0,2)")
        done = run("simulate", "--scene", scene, "--h", 0.1, "--static", "--quiet", "-o",
                   self.folder / "a.glb")
        self.assertEqual(done.code, 0, done.err)


if __name__ == "__main__":
    unittest.main()
