# SPDX-License-Identifier: Apache-2.0
"""The referee judges the state files of real runs: all solver modes, all time schemes, all laws, all
hourglass terms, pinned, moved, loaded and free bodies, damping. The mesh is a turned box, so that its
border voxels are cut at an angle."""

from __future__ import annotations

import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

import referee
from command import run, turned_box, write_obj
from equations import make_body
from holding import Holding
from state_file import LAWS, read_state

HOURGLASS = ("full", "variance", "off")
HELD = ("--pin", "x<8%")
THROWN = ("--spin", "4,7,-3", "--velocity", "0.5,1,0")
CUT = (*HELD, "--pin", "x>95%", "--pin", "sphere(50%,50%,50%, 3cm)")  # the last two cut voxels
SOFT = ("--young", "1e5", "--poisson", "0.4", "--density", "1000")

# held along some axes, moved and pulled, apart from each other
BOUNDARY = (*SOFT, "--pin", "x<-10cm", "--hold", "box(-4cm,3cm,-1,4cm,1,1): xz", "--traction", "z<-3cm: 0.5,-0.2,1",
            "--move", "x>10cm: turn(10cm,0,0, 1,0,0.2) 0:0; 0.2:25deg")

Case = dict[str, tuple[str, ...]]


def cases() -> Case:
    """A run for every law with every solver and time scheme, and special ones."""
    result: Case = {}
    for i, law in enumerate(LAWS):
        for s, solver in enumerate(("quasi", "newton")):
            for t, scheme in enumerate(("euler", "bdf2")):
                mode, motion = HOURGLASS[(i + s + 2 * t) % 3], (HELD, THROWN)[(i + s + t) % 2]
                name = f"{law} {solver} {scheme} {mode} {motion[0]}"
                result[name] = ("--law", law, "--solver", solver, "--time-scheme", scheme,
                                "--hourglass", mode, *SOFT, *motion)
    near = ("--law", "neo-hookean", "--young", "1e5", "--poisson", "0.49", *HELD)
    result["nearly incompressible"] = (*near, "--solver", "newton")
    result["nearly incompressible bdf2"] = (*near, "--solver", "quasi", "--time-scheme", "bdf2")
    result["stiff, double precision"] = ("--law", "hencky", "--young", "1e9", "--poisson", "0.3",
                                         "--tolerance", "1e-4", *HELD)
    paper = ("--law", "neo-hookean", *SOFT, "--solver", "paper", "--modes", "18", *HELD)
    result["paper"] = paper  # drafts, whose residuals must be right all the same
    result["paper as printed"] = (*paper, "--hourglass", "off", "--fps", "2000")
    learned = ("--energy", "neural", "--young", "1e5", "--poisson", "0.4", "--density", "1000")
    result["net"] = ("--law", "neo-hookean", *learned, "--solver", "newton", *HELD)
    result["net bdf2"] = ("--law", "hencky", *learned, "--time-scheme", "bdf2", *THROWN)
    result["net without table"] = ("--law", "stable-neo-hookean", *learned, "--no-skip", *HELD)
    result["net, paper"] = ("--law", "fixed-corotated", *learned, "--solver", "paper",
                            "--modes", "18", *HELD)
    result["net far from rest"] = ("--law", "neo-hookean", *learned, "--pin", "x<8%",
                                   "--gravity", "3000,0,0", "--fps", "240")
    result["held at borders that cut voxels"] = (*SOFT, *CUT, "--solver", "newton", "--gravity", "0,-90,0")
    result["held at such borders, bdf2"] = (*SOFT, *CUT, "--solver", "quasi", "--time-scheme", "bdf2")
    result["without shortcuts"] = ("--law", "stable-neo-hookean", *SOFT, "--no-skip", *THROWN)
    return result


def collisions() -> Case:
    """Runs with each shape, at rest and moving, two at once, and two materials."""
    drop = ("--young", "2e5", "--poisson", "0.3", "--density", "1000")
    return {
        "floor": (*drop, "--floor", "--friction", "0.4", "--velocity", "0.5,0,0"),
        "sphere": (*drop, "--collider", "sphere(0.02,-0.35,0.01, 20cm) friction 0.3"),
        "box": (*drop, "--collider", "box(-5cm,-0.5,-1, 1,-15cm,1) friction 0.2",
                "--time-scheme", "bdf2"),
        "thin box": (*drop, "--collider", "box(-1,-16cm,-1, 1,-15.9cm,1)", "--solver", "newton"),
        "moving plane": (*drop, "--collider", "plane(0,-16cm,0, 0.1,1,0) friction 0.5 name lift "
                         "path 0:0,0,0; 1:0.3,1m,0"),
        "two with friction": (*drop, "--floor", "--collider",
                              "plane(0,20cm,0, 0,-1,0) path 0s:0,0,0; 250ms:2cm,-6cm,0",
                              "--friction", "0.6"),
        "two materials": (*HELD, "--young", "1e5", "--region", "x>50%: jelly,young=30kPa,law=stvk",
                          "--region", "x>80%: foam"),
    }


def finite_elements() -> Case:
    """The same element by the other program: `simulate` instead of `animate`."""
    soft = ("--young", "2e5", "--poisson", "0.4", "--density", "1000")
    return {
        "finite elements": ("--law", "neo-hookean", *SOFT, *HELD),
        "finite elements bdf2": ("--law", "stable-neo-hookean", *SOFT, *THROWN, "--time-scheme",
                                 "bdf2"),
        "finite elements held at borders that cut voxels": (*SOFT, *CUT),
        "finite elements held at such borders, bdf2": (*SOFT, *CUT, "--time-scheme", "bdf2"),
        "finite elements held at such borders, under a moving plane": (
            *soft, *CUT, "--collider", "plane(0,20cm,0, 0,-1,0) path 0s:0,0,0; 250ms:2cm,-9cm,0"),
        "finite elements on a floor": (*soft, "--floor", "--friction", "0.4", "--velocity",
                                       "0.5,0,0"),
        "finite elements under a moving plane": (
            *soft, "--floor", "--collider",
            "plane(0,20cm,0, 0,-1,0) path 0s:0,0,0; 250ms:2cm,-6cm,0"),
    }


def stage_runs() -> Case:
    """Runs whose steps are made by stages, damped but for one, and the schemes that they have to use."""
    damped = (*SOFT, "--damping", "0.1", "--damping-frequency", "8", "--frames", "6")
    falls = (*damped, "--velocity", "0.5,-1,0", "--floor", "--friction", "0.4")
    return {
        "pendulum by auto": (*damped, *HELD, "--time-scheme", "auto"),
        "held at borders that cut voxels, by auto": (*damped, *CUT, "--time-scheme", "auto"),
        "held at such borders, by sdirk2": (*damped, *CUT, "--time-scheme", "sdirk2"),
        "on an edge that is cut out of voxels, by auto": (
            *damped, "--pin", "box(-13cm,2.9cm,-1,-11cm,3.1cm,1)", "--time-scheme", "auto"),
        "held along an axis in flight, by auto": (
            *SOFT, "--damping", "0", "--frames", "6", "--hold", "x<8%: x", "--spin", "6,0,0", "--velocity", "0,1,2",
            "--time-scheme", "auto"),
        "held along an axis on a floor, by auto": (*falls, "--hold", "z<10%: z", "--time-scheme", "auto"),
        "pendulum by bdf2 of auto": (*damped, *HELD, "--time-scheme", "auto", "--time-error", "20%"),
        "dropped, with friction and damping, by auto": (*falls, "--spin", "0,0,3", "--time-scheme",
                                                        "auto"),
        "spin by auto": (*damped, *THROWN, "--hourglass", "variance", "--time-scheme", "auto"),
        "pendulum by sdirk2": (*damped, *HELD, "--law", "stable-neo-hookean", "--time-scheme",
                               "sdirk2", "--substeps", "2"),
        "pressed by a moving plane, by sdirk2": (
            *SOFT, "--damping", "0", "--frames", "6", "--floor", "--friction", "0.6", "--collider",
            "plane(0,20cm,0, 0,-1,0) path 0s:0,0,0; 250ms:2cm,-6cm,0", "--time-scheme", "sdirk2"),
        "dropped and damped, by bdf2 itself": (*falls, "--time-scheme", "bdf2"),
    }


def held_runs() -> Case:
    """Runs of the network with moves, at borders that cut voxels but where it is said, and with loads."""
    shift = ("--move", "x>92%: shift ease loop 0:0,0,0; 0.06:0,3cm,1cm; 0.12:0,0,0")
    return {
        "shifted, with a pin": (*HELD, *shift),
        "turned, with a pin": (*HELD, "--move", "x>92%: turn(0,0,0, 1,0.3,0.2) 0.02:0; 0.2:60deg"),
        "two moves, one in a plane of nodes, and a ball at rest": (
            "--move", "x<8%: turn(0,0,0, 0.2,1,0) ease 0:0; 0.3:30deg", "--pin", "sphere(50%,50%,50%, 3cm)",
            "--move", "x>92%: shift 0:0,0,0; 0.1:0,1cm,1cm"),
        "on rails, along two axes and one, with a move": (
            "--hold", "box(0%,0%,0%, 80%,100%,20%): z", "--hold", "x<8%: xy", "--move", "x>92%: shift 0:0,0,0; 0.1:2cm,1cm,0"),
        "moved along a floor": (*HELD, "--move", "x>95%: shift 0:0,0,0; 0.2:2cm,0,1cm", "--floor", "y=-0.113",
                                "--friction", "0.5", "--region", "x>50%: jelly", "--gravity", "0,-40,0"),
    }


def loaded_runs() -> Case:
    """Runs with tractions, forces in time and wind, some of them of a body that nothing holds."""
    gusts = ("--wind", "0:0,0,0; 0.03:3,9,0; 0.1:0,2,6", "--density", "60")
    return {
        "thrown into gusts": (*THROWN, *gusts),
        "in gusts, under a force in time, moved at a border that cuts voxels": (
            *HELD, *gusts, "--move", "x>92%: turn(0,0,0, 1,0.3,0.2) ease 0:0; 0.2:60deg", "--force",
            "z<-1cm: 0:0,0,0; 0.03:0.2,0,0.5; 0.09:0,0,0", "--traction", "z<-3cm: 0.05,-0.02,0.1"),
        "under a force in time": (*THROWN, "--force", "all: 0:0,0,0; 0.05:0,3,1"),
        "pulled in flight": (*THROWN, "--traction", "z<-3cm: 0.5,-0.2,1"),
        "pulled and moved": (*HELD, "--move", "x>92%: shift 0:0,0,0; 0.1:0,1cm,1cm", "--traction",
                             "z<-3cm: 0.5,-0.2,1"),
    }


def soft(options: tuple[str, ...]) -> tuple[str, ...]:
    """SOFT, with the density of the options where they have one."""
    return SOFT[:4] if "--density" in options else SOFT


class Runs(unittest.TestCase):
    """Each run's steps are recomputed from its state file."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)
        box = turned_box((0.3, 0.12, 0.1), (1, 2, 3), 25)
        cls.source = write_obj(cls.path / "box.obj", *box)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def verdict(self, options: tuple[str, ...], verb: str = "animate") -> referee.Verdict:
        state = self.path / "state.h5"
        scheme = () if "--time-scheme" in options else ("--time-scheme", "euler")
        done = run(verb, self.source, "-o", self.path / "out.glb", "--quiet", "--voxels", 16,
                   "--frames", 8, "--substeps", 1, "--state", state, *scheme, *options)
        self.assertIn(done.code, (0, 4), done.err)
        with h5py.File(state) as file, np.errstate(all="ignore"):
            read = read_state(file)
            cut = (read.grid["fill"] < 1).mean()
            self.assertTrue(0.1 < cut < 0.9, f"{cut:.0%} of the voxels are border voxels")
            self.assertEqual(len(read.steps["scheme"]), 8)
            self.assertEqual(read.steps["scheme"][1:].any(), "bdf2" in options)
            meets = "--floor" in options or "--collider" in options
            self.assertEqual(bool(read.steps["energy_contact"].max() > 0), meets)
            return referee.judge(read, True)

    def test_boundaries_of_finite_elements_are_what_the_file_says(self) -> None:
        state = self.path / "fem.h5"
        for options in (("--frames", 8, "--substeps", 1), ("--static",),
                        ("--frames", 8, "--substeps", 1, "--time-scheme", "bdf2", "--floor",
                         "y=-0.12"),
                        ("--frames", 6, "--time-scheme", "auto", "--damping", 0.1),
                        ("--static", "--pin", "sphere(0,0,0, 3cm)")):
            done = run("simulate", self.source, "-o", self.path / "out.glb", "--voxels", 16,
                       "--quiet", "--state", state, *BOUNDARY, *options)
            self.assertEqual(done.code, 0, done.err)
            with h5py.File(state) as file:
                read = read_state(file)
                fixed = read.grid["fixed"]
                self.assertTrue((fixed[:, 1] < fixed[:, 0]).any())
                verdict = referee.judge(read, True)
                self.assertFalse(verdict.disagreements,
                                 referee.summary(verdict) + "\n" + referee.table(verdict))
                # the forces count: without them the residuals are others
                for name in ("fixed", "traction"):
                    whole = read.grid.pop(name)
                    wrong = referee.judge(read, False).disagreements
                    self.assertIn("residual", {check.quantity for check in wrong}, name)
                    read.grid[name] = whole

    def judged(self, verb: str, *options: object) -> tuple[referee.Verdict, set[int]]:
        """The verdict on a run, and the schemes of its steps."""
        state = self.path / "stages.h5"
        done = run(verb, self.source, "-o", self.path / "out.glb", "--quiet", "--state", state,
                   *options)
        self.assertIn(done.code, (0, 4), done.err)
        with h5py.File(state) as file, np.errstate(all="ignore"):
            read = read_state(file)
            return referee.judge(read, True), set(read.steps["scheme"].tolist())

    def test_every_stage_is_what_the_referee_computes(self) -> None:
        for name, options in stage_runs().items():
            for verb, size in (("animate", 14), ("simulate", 8)):
                with self.subTest(f"{name}, {verb}"):
                    verdict, schemes = self.judged(verb, "--voxels", size, *options)
                    self.assertFalse(verdict.disagreements,
                                     referee.summary(verdict) + "\n" + referee.table(verdict))
                    self.assertEqual(verdict.unchecked, [])
                    wanted = 1 if "bdf2" in name or name.startswith("spin") else 2
                    self.assertIn(wanted, schemes)

    def check_in_all_schemes(self, runs: Case) -> None:
        """Steps of one length and stages, in the solvers of both kinds."""
        for name, options in runs.items():
            for scheme, more in (("euler", ("--solver", "quasi")), ("bdf2", ("--solver", "newton")),
                                 ("sdirk2", ("--damping", 0.1)), ("auto", ("--damping", 0.1))):
                with self.subTest(f"{name}, {scheme}"):
                    verdict, _ = self.judged("animate", "--voxels", 12, "--frames", 4, "--time-scheme", scheme,
                                             *(() if scheme == "auto" else ("--substeps", 1)), "--analytic",
                                             *soft(options), *more, *options)
                    self.assertFalse(verdict.disagreements,
                                     referee.summary(verdict) + "\n" + referee.table(verdict))
                    self.assertEqual(verdict.unchecked, [])
                    if "--floor" in options:
                        self.assertGreater(max(c.own for c in verdict.checks if c.quantity == "energy_contact"), 0)
                    held = {check.quantity for check in verdict.checks} & {"held places", "reaction_force"}
                    self.assertEqual(len(held), 0 if "--spin" in options else 2)

    def test_what_is_held_and_moved_is_where_the_referee_finds_it(self) -> None:
        self.check_in_all_schemes(held_runs())

    def test_loads_of_the_network_are_what_the_file_says(self) -> None:
        self.check_in_all_schemes(loaded_runs())

    def test_loads_of_finite_elements_are_what_the_file_says(self) -> None:
        for name, options in loaded_runs().items():
            for scheme in ("euler", "bdf2", "sdirk2", "auto"):
                with self.subTest(f"{name}, {scheme}"):
                    verdict, _ = self.judged("simulate", "--voxels", 8, "--frames", 3, "--time-scheme", scheme,
                                             *(() if scheme == "auto" else ("--substeps", 1)), *soft(options), *options)
                    self.assertFalse(verdict.disagreements,
                                     referee.summary(verdict) + "\n" + referee.table(verdict))

    def test_loads_count_each_for_itself(self) -> None:
        """Without the load residuals are others; without wind or forces the load is."""
        state = self.path / "loads.h5"
        options = loaded_runs()["in gusts, under a force in time, moved at a border that cuts voxels"]
        for verb, scheme in (("animate", "sdirk2"), ("simulate", "bdf2")):
            done = run(verb, self.source, "-o", self.path / "out.glb", "--quiet", "--voxels", 10, "--frames", 4,
                       "--substeps", 1, "--time-scheme", scheme, "--state", state, *soft(options), *options)
            self.assertEqual(done.code, 0, done.err)
            with h5py.File(state) as file, np.errstate(all="ignore"):
                read = read_state(file)
                self.assertFalse(referee.judge(read, False).disagreements)
                still = {"force": 0 * read.forces["force"], "share": read.forces["share"]}
                for wrong, quantity in ((replace(read, load=None, load_stage=None), "residual"),
                                        (replace(read, load=np.roll(read.load[()], 1, axis=0)), "residual"),
                                        (replace(read, forces=still), "load"), (replace(read, wind=None), "load")):
                    found = referee.judge(wrong, False).disagreements
                    self.assertIn(quantity, {check.quantity for check in found})

    def test_reactions_bring_what_momentum_lacks_and_stand_in_log_and_report(self) -> None:
        """By Newton's law, from masses and velocities alone; steps of implicit Euler."""
        state, log, report = (self.path / name for name in ("held.h5", "held.jsonl", "held.json"))
        done = run("animate", self.source, "-o", self.path / "out.glb", "--quiet", "--voxels", 12, "--frames", 5,
                   "--time-scheme", "euler", "--tolerance", "1e-7", "--state", state, "--log-json", log,
                   "--report", report, "--substeps", 1, *SOFT, *held_runs()["turned, with a pin"])
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(state) as file:
            read = read_state(file)
            force = read.steps["reaction_force"]
            # of what is not pinned, with the weight that pinned nodes bear
            mass = np.where(read.grid["pinned"] == 1, 0, read.grid["mass"])
            borne = np.where(read.grid["pinned"] == 1, Holding(read, make_body(read)).weighing, 0)
            momentum = np.array([mass @ v for v in read.v])
            for step, length in enumerate(read.steps["length"]):
                lacks = (momentum[step + 1] - momentum[step]) / length - (mass + borne).sum() * read.gravity
                np.testing.assert_allclose(force[step].sum(0), lacks, atol=1e-5 * np.abs(force).max())
            # the other files
            lines = [json.loads(line)["reactions"] for line in log.read_text().splitlines()]
            last = json.loads(report.read_text())["reactions"]
            self.assertEqual([one["holder"] for one in last], list(read.holders.names))
            for key in ("force", "moment", "about"):
                recorded = read.steps[f"reaction_{key}"]
                np.testing.assert_array_equal([[one[key] for one in line] for line in lines], recorded)
                np.testing.assert_array_equal([one[key] for one in last], recorded[-1])

    def test_damping_bonds_and_first_stages_count(self) -> None:
        state = self.path / "counts.h5"
        options = stage_runs()["dropped, with friction and damping, by auto"]
        done = run("animate", self.source, "-o", self.path / "out.glb", "--quiet", "--voxels", 12,
                   "--tolerance", "1e-6", "--state", state, *options)
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(state) as file, np.errstate(all="ignore"):
            read = read_state(file)
            self.assertGreater(np.abs(read.contact["bonds"]).max(), 0)
            # without damping, with the bonds of another step, with the end as the first stage
            undamped = [replace(m, loss_factor=0.0) for m in read.materials]
            others = read.contact | {"bonds": np.roll(read.contact["bonds"], 1, axis=0)}
            for wrong in (replace(read, materials=undamped), replace(read, contact=others),
                          replace(read, x_stage=read.x[1:])):
                found = referee.judge(wrong, False).disagreements
                self.assertIn("residual", {check.quantity for check in found})

    def test_every_recorded_step_is_what_the_referee_computes(self) -> None:
        worst: list[tuple[float, str]] = []
        for name, options in (cases() | collisions() | finite_elements()).items():
            with self.subTest(name):
                verdict = self.verdict(options, "simulate" if name in finite_elements()
                                       else "animate")
                check = verdict.worst("residual")
                worst.append((check.excess, f"{name}: own {check.own:.4e}, reported "
                              f"{check.recorded:.4e}"))
                self.assertFalse(verdict.disagreements,
                                 referee.summary(verdict) + "\n" + referee.table(verdict))
                self.assertNotIn("energy_elastic", verdict.unchecked)
        print(f"{len(worst)} runs; worst share of what is allowed (5 % or 1e-6): "
              f"{max(worst)[0]:.3g}, {max(worst)[1]}")


if __name__ == "__main__":
    unittest.main()
