# SPDX-License-Identifier: Apache-2.0
"""Moves and loads of `animate`: against finite elements on the same voxels, and what is refused."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from command import Floats, animate, run, turned_box, write_obj

# a bar from -0.2 to 0.2 m, on a grid that fits none of its pins and moves but the lowest
GRID = ("--h", 0.055, "--young", "1MPa", "--poisson", 0.3, "--law", "neo-hookean", "--analytic",
        "--damping", 0, "--time-scheme", "euler", "--substeps", 2, "--tolerance", 1e-6)
ENDS = ("--pin", "x<7%", "--move", "x>93%: turn(0,0,0,1,0,0) ease 0:0; 0.2:80deg")


class Moves(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.source = write_obj(self.folder / "bar.obj", *turned_box((0.4, 0.2, 0.2), (0, 0, 1), 0))

    def last(self, verb: str, *options: object) -> Floats:
        """Positions of the nodes at the end of a run that converged."""
        state = self.folder / f"{verb}.h5"
        done = run(verb, self.source, *GRID, "--frames", 6, "--state", state, "-o",
                   self.folder / "a.pc2", "--quiet", *options)
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(state) as file:
            return file["steps/x"][-1]

    def check_same(self, *options: object) -> None:
        network = self.last("animate", *options)
        elements = self.last("simulate", "--element", "voxel", *options)
        self.assertLess(np.abs(network - elements).max(), 1e-6)

    def test_a_turn_is_that_of_finite_elements(self) -> None:
        self.check_same(*ENDS)

    def test_a_shift_and_a_traction_are_those_of_finite_elements(self) -> None:
        self.check_same("--move", "x<7%: shift 0:0,0,0; 0.1:0,2cm,1cm", "--traction",
                        "x>100%: 0,30,-20 N")

    def test_holds_along_axes_are_those_of_finite_elements(self) -> None:
        self.check_same("--hold", "x<7%: xy", "--hold", "box(0%,0%,0%, 80%,100%,0%): z", "--move",
                        "x>93%: shift 0:0,0,0; 0.1:3cm,0,2cm", "--gravity", "1,-9.81,0")

    def test_a_hold_and_a_move_of_the_same_node_are_refused(self) -> None:
        done = run("animate", self.source, *GRID, "-o", self.folder / "a.pc2", "--hold", "x>50%: y",
                   "--move", "x>93%: shift 0:0,0,0; 0.1:3cm,0,0")
        self.assertEqual(done.code, 2)
        self.assertIn("contradict each other", done.err)

    def test_pins_hold_alike_in_any_order(self) -> None:
        pins = [("--pin", "x<7%"), ("--pin", "x>93%"), ("--pin", "sphere(50%,50%,50%,0.09m)")]
        for verb in (("animate",), ("simulate", "--element", "voxel")):
            one, other = (self.last(*verb, *(word for pin in order for word in pin))
                          for order in (pins, pins[::-1]))
            np.testing.assert_array_equal(one, other)

    def test_a_pin_beside_the_body_changes_nothing(self) -> None:
        free = self.last("animate")
        for pin in ("x<-5%", "x<-0.1%"):
            np.testing.assert_array_equal(self.last("animate", "--pin", pin), free)

    def test_the_parts_in_a_move_go_along_exactly(self) -> None:
        output = self.folder / "a.pc2"
        done = animate(self.source, output, *GRID, "--frames", 6, *ENDS)
        self.assertEqual(done.code, 0, done.err)
        points = np.frombuffer(output.read_bytes()[32:], np.float32).reshape(7, -1, 3)
        right, angle = points[0, :, 0] > 0, np.radians(80)
        y, z = points[0, right, 1], points[0, right, 2]
        turned = np.stack([points[0, right, 0], np.cos(angle) * y - np.sin(angle) * z,
                           np.sin(angle) * y + np.cos(angle) * z], 1)
        self.assertLess(np.abs(points[-1, right] - turned).max(), 1e-7)
        self.assertLess(np.abs(points[-1, ~right] - points[0, ~right]).max(), 1e-7)

    def test_statics_carry_points_to_the_end_of_a_path_of_any_length(self) -> None:
        output = self.folder / "a.pc2"
        done = run("simulate", self.source, "--h", 0.055, "--static", "--pin", "x<7%", "--move",
                   "x>93%: shift 0:0,0,0; 4:0,2cm,0", "-o", output, "--quiet")
        self.assertEqual(done.code, 0, done.err)
        points = np.frombuffer(output.read_bytes()[32:], np.float32).reshape(2, -1, 3)
        right = points[0, :, 0] > 0
        self.assertLess(np.abs(points[1, right] - points[0, right] - [0, 0.02, 0]).max(), 1e-7)

    def test_reactions_of_statics_and_of_the_network_carry_the_weight(self) -> None:
        report = self.folder / "a.json"
        weight = 0.86 * 0.4 * 0.2 * 0.2 * 1100 * 9.81  # of the part between
        for verb, options in (("simulate", ("--static",)), ("animate", ("--frames", 40))):
            done = run(verb, self.source, "--h", 0.055, "--young", "10MPa", "--time-scheme",
                       "euler", "--substeps", 1, "--pin", "x<7%", "--pin", "x>93%", "-o",
                       self.folder / "a.pc2", "--report", report, "--quiet", *options)
            self.assertEqual(done.code, 0, done.err)
            left, right = (r["force"] for r in json.loads(report.read_text())["reactions"])
            self.assertLess(abs((left[1] + right[1]) / weight - 1), 1e-3)
            self.assertLess(abs(left[1] / right[1] - 1), 1e-3)
            self.assertLess(abs(left[0] + right[0]), 1e-3 * weight)

    def test_a_force_in_time_brings_its_impulse(self) -> None:
        log, output = self.folder / "a.log", self.folder / "a.pc2"
        done = animate(self.source, output, "--voxels", 8, "--frames", 9, "--gravity", "0,0,0",
                       "--force", "all: 0:0,0,0; 0.1:0,60,0; 0.2:0,0,0", "--log-json", log)
        self.assertEqual(done.code, 0, done.err)
        last = [json.loads(line) for line in log.read_text().splitlines()][-1]
        end = last["ledger"]["momentum"]["end"]
        self.assertLess(abs(end[1] - 6), 0.02)  # of the triangle, by the rule of the steps
        self.assertLess(abs(end[0]) + abs(end[2]), 1e-6)

    def test_still_air_brakes_a_plate(self) -> None:
        plate = write_obj(self.folder / "plate.obj", *turned_box((1, 0.05, 1), (0, 0, 1), 0))
        fall = []
        for options in ((), ("--wind", "0,0,0")):
            output = self.folder / "a.pc2"
            done = animate(plate, output, "--h", 0.05, "--young", "1MPa", "--density", 30,
                           "--frames", 15, *options)
            self.assertEqual(done.code, 0, done.err)
            points = np.frombuffer(output.read_bytes()[32:], np.float32).reshape(16, -1, 3)
            fall.append(float((points[0] - points[-1])[:, 1].mean()))
        steady = np.sqrt(2 * 1.5 * 9.81 / 1.2)  # 1.5 kg a square metre
        self.assertLess(abs(fall[0] / (9.81 * 0.25 / 2) - 1), 1e-3)
        expected = steady**2 / 9.81 * np.log(np.cosh(9.81 * 0.5 / steady))
        self.assertLess(abs(fall[1] / expected - 1), 0.03)

    def test_what_cannot_be_is_refused_by_name(self) -> None:
        output = self.folder / "a.pc2"
        for words, options in (
                ("contradict each other", ("--pin", "x>90%", "--move", "x>95%: shift 0:0,0,0")),
                ("contradict each other", ("--move", "x>90%: shift 0:0,0,0",
                                           "--move", "x>90%: shift 0:1,0,0")),
                ("no face of the body", ("--traction", "x>200%: 1,0,0 N")),
                ("no node of the grid", ("--force", "x>200%: 1,0,0 N")),
                ("must end as it begins", ("--move", "x>90%: shift loop 0:0,0,0; 1:1,0,0")),
                ("no holds along single axes", ("--solver", "paper", "--hold", "all: y")),
                ("knows no wind", ("--solver", "paper", "--wind", "1,0,0"))):
            done = animate(self.source, output, "--voxels", 8, "--frames", 1, *options)
            self.assertEqual(done.code, 2, (words, done.err))
            self.assertIn(words, done.err)
            self.assertFalse(output.exists())
        done = run("simulate", self.source, "--voxels", 4, "--static", "--pin", "x<7%", "--wind", "1,0,0", "-o",
                   output, "--quiet")
        self.assertEqual(done.code, 2)
        self.assertIn("no equilibrium in wind", done.err)

    def test_options_that_a_solver_lacks_are_refused_before_the_asset_is_read(self) -> None:
        for options in (("--hold", "all: y"), ("--wind", "1,0,0")):
            done = run("animate", self.folder / "none.obj", "--solver", "paper", "-o",
                       self.folder / "a.pc2", *options)
            self.assertEqual(done.code, 2, done.err)
            self.assertIn(options[0], done.err)

    def test_a_run_ends_where_a_part_that_is_moved_meets_a_floor(self) -> None:
        # the end reaches the floor, 0.15 m below the bar, at 0.3 s; the grid fits the pin and not the move
        output = self.folder / "a.pc2"
        for verb, more in (("animate", ()), ("simulate", ("--element", "voxel")),
                           ("simulate", ("--element", "tet4"))):
            done = run(verb, self.source, *GRID, "--frames", 30, "--fps", 30, "--pin", "x<7%", "--move",
                       "x>93%: shift 0:0,0,0; 1:0,-50cm,0", "--floor", "y=-0.25", "-o", output, *more)
            self.assertNotEqual(done.code, 0, done.err)
            self.assertIn("floor", done.err)
            self.assertIn("--move 'x>93%", done.err)
            frames = int(np.frombuffer(output.read_bytes()[28:32], np.int32)[0])
            self.assertIn(frames, (9, 10), done.err)  # with the rest frame, and the layer of the contact
            output.unlink()

    def test_paper_says_how_far_behind_borders_nodes_hold(self) -> None:
        # planes of nodes every 55 mm from the pin's on; the move's border is 0.344 m from it
        done = animate(self.source, self.folder / "a.pc2", *GRID, "--frames", 1, "--solver", "paper",
                       "--pin", "x<7%", "--move", "x>93%: shift 0:0,0,0; 1:0,1cm,0")
        self.assertIn("--move 'x>93%", done.err)
        self.assertIn("0.041 m (0.75 voxels) too far back", done.err)

    def test_gusts_move_the_network_as_they_do_finite_elements(self) -> None:
        self.check_same("--pin", "x<7%", "--density", 60, "--wind", "0:0,0,0; 0.1:2,9,0; 0.3:0,4,8",
                        "--force", "x>90%: 0:0,0,0; 0.05:0,0,0.3; 0.15:0,0,0")


if __name__ == "__main__":
    unittest.main()
