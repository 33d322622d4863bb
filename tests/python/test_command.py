# SPDX-License-Identifier: Apache-2.0
"""The command as a user sees it: exit codes, messages, files, options."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import glb_check
from command import BINARY, Run, animate, run, turned_box, write_obj
from glb_file import Document, local_positions, parse_glb, read_document

BOX = turned_box((0.3, 0.12, 0.1), (1, 2, 3), 25)


def small(voxels: int = 8, frames: int = 3, substeps: int = 1) -> tuple[object, ...]:
    """Options of a short run of a soft bar that is held at one end."""
    return ("--voxels", voxels, "--frames", frames, "--substeps", substeps, "--young", "1e5",
            "--pin", "x<10%")


SMALL = small()


class Command(unittest.TestCase):
    """A folder of its own, with a mesh in it."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.source = write_obj(self.folder / "box.obj", *BOX)
        self.output = self.folder / "out.glb"

    def files(self) -> set[str]:
        return {path.name for path in self.folder.iterdir()}

    def animated(self, *options: object, name: str = "out.glb", code: int = 0) -> Document:
        """The checked document of a run that must end with `code`."""
        output = self.folder / name
        done = animate(self.source, output, *options)
        self.assertEqual(done.code, code, done.err)
        document = read_document(output)
        glb_check.check_animation(document)
        return document

    def refused(self, done: Run, code: int, *words: str) -> None:
        """The code, a message on standard error with these words, no file that was not there."""
        self.assertEqual(done.code, code, done.err)
        for word in words:
            self.assertIn(word, done.err)
        self.assertEqual(self.files(), {"box.obj"})


class Usage(Command):
    """Exit code 2, and help."""

    def test_help_and_version_end_with_zero(self) -> None:
        verbs = ("animate", "demo", "voxelize", "inspect", "doctor", "materials")
        for words in (["--help"], ["--version"], *([verb, "--help"] for verb in verbs)):
            done = run(*words)
            self.assertEqual(done.code, 0, words)
            self.assertIn("elastogen" if "--version" in words else "Usage", done.out)

    def test_what_cannot_be_meant_is_refused_and_named(self) -> None:
        for options, words in (
                (["--law", "jelly"], ["jelly", "stable-neo-hookean"]),
                (["--material", "unobtainium"], ["unobtainium", "rubber"]),
                (["--young", "5kg"], ["kg", "Pa"]), (["--young", "-1"], ["Young"]),
                (["--young", "nan"], ["nan"]), (["--poisson", "0.5"], ["0.5"]),
                (["--poisson", "-0.1"], ["-0.1"]), (["--density", "0"], ["density"]),
                (["--size", "3Pa"], ["Pa"]), (["--gravity", "1,2"], ["1,2"]),
                (["--pin", "y<"], ["y<"]), (["--pin", "ball(0,0,0,1)"], ["ball"]),
                (["--floor", "q=1"], ["q=1"]), (["--region", "all"], ["all", "colon"]),
                (["--region", "node:top: foam"], ["top"]), (["--collider", "cone(1)"], ["cone"]),
                (["--collider", "sphere(0,0,0,9) name ball"], ["ball", "inside"]), (["--substeps", "0"], ["0"]),
                (["--solver", "papers"], ["papers", "quasi"]), (["--device", "abacus"], ["abacus"]),
                (["--time-scheme", "rk4"], ["rk4"]), (["--hourglass", "on"], ["on"]),
                (["--up", "w"], ["--up"]), (["--tolerance", "0"], ["tolerance"]),
                (["--voxels", "0"], ["--voxels"]), (["--h", "9m"], ["9 m", "longest edge"]),
                (["--frames", "-1"], ["--frames"]),
                (["--frames", "many"], ["many"]), (["--glb-profile", "best"], ["best"]),
                (["--threads", "-2"], ["--threads"]), (["--max-time", "2m"], ["m"]),
                (["--max-time", "0"], ["--max-time"]), (["--max-memory", "0"], ["--max-memory"]),
                (["--no-such-option"], ["--no-such-option"]),
                (["--state", self.output], ["out.glb"]), (["--log-json", self.source], ["box.obj"]),
                (["--state", "s", "--report", "./s"], ["own"])):
            with self.subTest(options):
                self.refused(animate(self.source, self.output, *options), 2, *words)
        self.refused(run("animate", self.source), 2, "--output")
        self.refused(run(), 2)
        self.refused(run("anime"), 2)
        self.refused(animate(self.source, self.folder / "out.txt"), 2, "out.txt")

    def test_a_pin_that_holds_nothing_is_a_warning_and_under_strict_an_error(self) -> None:
        nothing = ("--voxels", 8, "--frames", 1, "--pin", "x>200%", "--pin", "x<10%")
        self.refused(animate(self.source, self.output, *nothing, "--strict"), 2, "x>200%")
        done = animate(self.source, self.output, *nothing)
        self.assertEqual(done.code, 0)
        self.assertIn("x>200%", done.err)

    def test_nothing_moved_is_a_warning_with_its_cause(self) -> None:
        done = animate(self.source, self.output, "--voxels", 8, "--frames", 1, "--pin", "all")
        self.assertEqual(done.code, 0)
        self.assertIn("every node is pinned", done.err)
        self.assertIn("out.glb has no animation", done.err)
        held = run("simulate", self.source, "--voxels", 4, "--frames", 1, "--hold", "all: y", "-o",
                   self.output, "--quiet")
        self.assertIn("pulls along y, along which every node is held", held.err)

    def test_a_motion_too_small_to_see_is_said_with_its_size_and_a_larger_one_is_shown(
            self) -> None:
        cube = write_obj(self.folder / "cube.obj", *turned_box((1, 1, 1), (0, 0, 1), 0))
        gravity, density = 9.81, 1100
        for young, pinned, words in ((1e8, "y<1%", "underside is held"), (1e10, "x<1%", "stiff"),
                                     (2e6, "y<1%", "")):
            done = animate(cube, self.output, "--voxels", 6, "--frames", 4, "--pin", pinned,
                           "--young", young)
            self.assertEqual(done.code, 0)
            document = read_document(self.output)
            glb_check.check_animation(document)
            first, last = (local_positions(document, t)[0, 0] for t in (0, 4))
            motion = np.abs(last - first).max()
            sag = density * gravity / (2 * young)  # of a column of 1 m that stands
            if words:
                self.assertRegex(done.err, f"hardly anything moved, .*{words}")
                self.assertEqual("stiff" in done.err, "stiff" in words)
                self.assertLess(motion, 1e-4)
            else:
                self.assertNotIn("moved", done.err)
                self.assertGreater(motion, sag / 3)
                self.assertLess(motion, 3 * sag)


class Resources(Command):
    """Exit code 6."""

    def test_a_budget_is_refused_with_the_amount(self) -> None:
        self.refused(animate(self.source, self.output, "--voxels", 4000, "--max-voxels", 10000), 6,
                     "needs", "voxels", "10000", "GB")
        self.refused(animate(self.source, self.output, "--voxels", 200, "--max-memory", "1MB"), 6,
                     "needs", "GB", "voxels")

    def test_a_place_that_cannot_be_written_is_named(self) -> None:
        for place in (self.folder / "missing", self.source):  # no folder; a file
            for option, name in (("-o", "x.glb"), ("--state", "x.h5"), ("--log-json", "x.json")):
                with self.subTest(f"{option} {place.name}"):
                    words = [option, place / name]
                    words += [] if option == "-o" else ["-o", self.output]
                    done = run("animate", self.source, *SMALL, *words)
                    self.refused(done, 6, f"{place / name}")

    def test_a_folder_that_takes_no_files_is_named(self) -> None:
        closed = Path("/proc")  # closed to the superuser too
        if os.geteuid() != 0:
            closed = self.folder / "closed"
            closed.mkdir(mode=0o555)
        done = animate(self.source, closed / "x.glb", *SMALL)
        self.assertEqual(done.code, 6)
        self.assertIn(str(closed / "x.glb"), done.err)

    def test_a_full_disk_ends_the_run(self) -> None:
        self.refused(animate(self.source, self.output, *SMALL, "--log-json", "/dev/full"), 6,
                     "/dev/full")


class Endings(Command):
    """Runs that end below the promise or early: whole outputs all the same."""

    LONG = ("--voxels", 12, "--frames", 100000, "--substeps", 1, "--young", "1e5", "--pin",
            "x<10%", "--fps", 60)

    def outputs(self) -> list[object]:
        return ["--state", self.folder / "s.h5", "--log-json", self.folder / "l.json", "--report",
                self.folder / "r.json"]

    def check_whole(self, least: int) -> dict[str, Any]:
        """GLB, state, log and report are there, whole, and of one length; returns the report."""
        document = read_document(self.output)
        glb_check.check_animation(document)
        report = json.loads((self.folder / "r.json").read_text())
        log = [json.loads(line) for line in (self.folder / "l.json").read_text().splitlines()]
        frames = document.json["asset"]["extras"]["elastogen"]["frames"]
        with h5py.File(self.folder / "s.h5") as file:
            self.assertEqual(file["steps/x"].shape[0], len(log) + 1)
            self.assertTrue(np.isfinite(file["steps/x"][()]).all())
        self.assertEqual(len(frames), report["frames"] + 1)
        self.assertEqual(report["steps"], len(log))
        self.assertGreaterEqual(report["frames"], least)
        self.assertLess(report["frames"], 100000)
        self.assertEqual(self.files(), {"box.obj", "out.glb", "s.h5", "l.json", "r.json"})
        return report

    def test_max_time_is_a_draft_with_whole_outputs(self) -> None:
        done = animate(self.source, self.output, *self.LONG, *self.outputs(), "--max-time", "1s")
        self.assertEqual(done.code, 4, done.err)
        self.assertIn("--max-time", done.err)
        self.check_whole(1)

    def test_a_signal_ends_the_run_with_whole_outputs(self) -> None:
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            words = [BINARY, "animate", self.source, *self.LONG, *self.outputs(), "-o", self.output]
            process = subprocess.Popen([str(w) for w in words], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE)
            log = self.folder / "l.json"
            while process.poll() is None and (not log.exists() or log.stat().st_size < 1000):
                time.sleep(0.01)
            process.send_signal(number)
            error = process.communicate(timeout=60)[1].decode()
            self.assertEqual(process.returncode, code, error)
            self.assertTrue(any("interrupted" in w for w in self.check_whole(1)["warnings"]))
            log.unlink()

    def test_a_step_beyond_single_precision_ends_the_clip_before_it(self) -> None:
        # the published recipe diverges here within two steps; the second is finite in float64 alone
        write_obj(self.source, *turned_box((0.9375, 0.125, 0.125), (0, 0, 1), 0))
        done = animate(self.source, self.output, "--h", 0.0625, "--up", "y", "--pin", "x<0%",
                       "--gravity", "0,0,0", "--spin", "48,0,0", "--law", "stvk", "--young", 2.5e6,
                       "--poisson", 0.49, "--density", 1000, "--fps", 1000, "--substeps", 1,
                       "--frames", 6, "--solver", "paper", "--hourglass", "off", "--outer", 5,
                       "--inner", 22, "--modes", 18, *self.outputs())
        self.assertEqual(done.code, 5, done.err)
        self.assertIn("frame 2: step 2: it goes beyond single precision", done.err)
        self.assertEqual(self.check_whole(1)["frames"], 1)

    def test_a_step_above_the_tolerance_is_a_draft_everywhere(self) -> None:
        done = animate(self.source, self.output, *SMALL, "--tolerance", "1e-14", *self.outputs())
        self.assertEqual(done.code, 4, done.err)
        report = self.check_whole(3)
        self.assertLess(report["converged_share"], 1)
        self.assertGreater(report["worst_residual"], 1e-14)
        frames = read_document(self.output).json["asset"]["extras"]["elastogen"]["frames"]
        self.assertFalse(all(frame["converged"] for frame in frames))

    def test_a_step_above_its_time_error_is_a_draft_everywhere(self) -> None:
        # a hard bar lands on a floor
        words = ("--voxels", 6, "--young", 5e6, "--up", "y", "--floor", "y=-0.2", "--velocity", "0,-4,0", "--spin",
                 "0,0,2", "--frames", 3)
        for more, code in (((), 0), (("--strict-time",), 4)):
            done = animate(self.source, self.output, *words, *more, *self.outputs())
            self.assertEqual(done.code, code, done.err)
            report = self.check_whole(3)
            log = [json.loads(line) for line in (self.folder / "l.json").read_text().splitlines()]
            met = [line["time_ratio"] <= 1 for line in log]
            self.assertTrue(all(line["residual"] <= line["tolerance"] for line in log))
            self.assertIn(False, met)
            self.assertEqual([line["converged"] for line in log], met)
            self.assertEqual(report["converged_share"], sum(met) / len(met))
            with h5py.File(self.folder / "s.h5") as file:
                self.assertEqual(list(file["steps/converged"]), met)
                for name in ("time_error", "time_ratio"):
                    self.assertEqual(list(file[f"steps/{name}"]), [line[name] for line in log])
            frames = read_document(self.output).json["asset"]["extras"]["elastogen"]["frames"]
            self.assertEqual([frame["converged"] for frame in frames[1:]],
                             [all(m for m, line in zip(met, log) if line["frame"] == k) for k in (1, 2, 3)])


class Outputs(Command):
    """What the files say."""

    def test_log_and_report_have_the_documented_fields(self) -> None:
        log, report = self.folder / "l.json", self.folder / "r.json"
        self.animated(*small(substeps=2), "--log-json", log, "--report", report)
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        self.assertEqual([(l["frame"], l["step"]) for l in lines],
                         [(1, 1), (1, 2), (2, 3), (2, 4), (3, 5), (3, 6)])
        for line in lines:
            self.assertLessEqual({"frame", "step", "time", "converged", "residual", "outer",
                                  "inner", "min_j", "outside_fit", "energies", "active_share",
                                  "ms"}, set(line))
            self.assertEqual(set(line["energies"]),
                             {"kinetic", "elastic", "hourglass", "gravity", "contact"})
            self.assertAlmostEqual(line["time"], line["step"] / 60, 12)
            self.assertEqual(line["converged"], line["residual"] <= 1e-3)
        r = json.loads(report.read_text())
        self.assertLessEqual({"asset", "voxels", "nodes", "h", "materials", "steps", "frames",
                              "converged_share", "solved_share", "worst_residual", "min_j",
                              "stage_seconds", "ms_per_step", "peak_memory_bytes", "warnings",
                              "command", "commit"},
                             set(r))
        self.assertLessEqual({"vertices", "faces", "closed", "findings"}, set(r["asset"]))
        self.assertEqual((r["asset"]["vertices"], r["asset"]["faces"]), (8, 12))
        self.assertEqual((r["steps"], r["frames"], r["converged_share"]), (6, 3, 1))
        self.assertEqual(set(r["stage_seconds"]), {"read", "voxelize", "setup", "steps", "write"})
        self.assertEqual(set(r["ms_per_step"]), {"median", "p95"})
        self.assertEqual(r["worst_residual"], max(line["residual"] for line in lines))
        self.assertEqual(r["min_j"], min(line["min_j"] for line in lines))

    def test_threads_do_not_change_a_bit(self) -> None:
        held = small(voxels=20)
        dropped = ("--voxels", 16, "--frames", 8, "--young", "3e4", "--floor", "auto=-9cm", "--collider",
                   "sphere(0,-0.13,0, 0.05)", "--size", "20cm")
        for name, options in (("held", held), ("dropped", dropped)):
            states, documents = [], []
            for threads in (1, 2):
                place = self.folder / name / str(threads)
                place.mkdir(parents=True)
                words = [BINARY, "animate", self.source, *options, "--threads", threads, "--state", "s.h5",
                         "-o", "out.glb", "--log-json", "log", "--quiet"]
                done = subprocess.run([str(w) for w in words], cwd=place, timeout=120, check=False,
                                      capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)
                with h5py.File(place / "s.h5") as file:
                    states.append([file[f"steps/{name}"][()].tobytes() for name in "xv"])
                document = parse_glb((place / "out.glb").read_bytes())
                del document.json["asset"]["extras"]["elastogen"]["command"]
                documents.append(document)
            steps = [json.loads(line) for line in (place / "log").read_text().splitlines()]
            self.assertEqual(name == "dropped", any(step["energies"]["contact"] > 0 for step in steps))
            self.assertEqual(states[0], states[1], name)
            self.assertEqual(documents[0], documents[1], name)

    def test_without_load_nothing_moves_by_a_bit(self) -> None:
        for solver in ("quasi", "newton"):
            state = self.folder / "s.h5"
            document = self.animated(*SMALL, "--gravity", "0,0,0", "--solver", solver, "--state",
                                     state)
            with h5py.File(state) as file:
                x = file["steps/x"][()]
                self.assertTrue((x == x[0]).all())
                self.assertTrue((x[0] == file["grid/rest"][()]).all())
                self.assertFalse(file["steps/v"][()].any())
            for key, last in local_positions(document, 3).items():
                self.assertTrue((last == local_positions(document, 0)[key]).all())

    def test_no_skip_gives_the_same_motion(self) -> None:
        tight = (*SMALL, "--tolerance", "1e-6", "--state")
        positions = []
        for options in ([], ["--no-skip"]):
            self.animated(*tight, self.folder / "s.h5", *options)
            with h5py.File(self.folder / "s.h5") as file:
                positions.append(file["steps/x"][()])
        motion = np.abs(positions[0] - positions[0][0]).max()
        self.assertGreater(motion, 1e-3)
        self.assertLess(np.abs(positions[0] - positions[1]).max(), 1e-4 * motion)

    def test_a_floor_is_in_the_state_file(self) -> None:
        state = self.folder / "s.h5"
        self.animated("--voxels", 8, "--frames", 3, "--floor", "--friction", 0.3, "--state", state)
        with h5py.File(state) as file:
            contact = file["contact"]
            self.assertEqual(set(contact.attrs), {"layer", "slip_range", "impact_speed"})
            self.assertEqual(contact["name"][()].tolist(), [b"floor"])
            self.assertEqual(contact["friction"][()].tolist(), [0.3])
            self.assertEqual(contact["normal"][()].tolist(), [[0, 1, 0]])
            height = contact["centre"][0, 1]
            self.assertAlmostEqual(height, BOX[0][:, 1].min(), 12)
            self.assertFalse(contact["offset"][()].any())
            x, corners = file["steps/x"][-1], file["grid/corners"][()]
            place = x[corners[contact["voxel"][()]]]
            points = np.einsum("pc,pcd->pd", contact["weights"][()], place)
            self.assertGreater(points[:, 1].min(), height - contact.attrs["layer"])

    def test_a_collider_moves_and_a_press_on_pins_ends_the_clip_by_name(self) -> None:
        state, low = self.folder / "s.h5", BOX[0][:, 1].min()
        lift = f"plane(0,{low},0, 0,2,0) name lift path 0:0,0,0; 1s:0,30cm,0"
        self.animated("--voxels", 8, "--frames", 3, "--collider", lift, "--state", state)
        with h5py.File(state) as file:
            np.testing.assert_allclose(file["contact/offset"][:, 0, 1],
                                       0.3 * file["steps/time"][()], atol=1e-15)
        done = animate(self.source, self.output, "--voxels", 8, "--frames", 9, "--pin", "y<10%",
                       "--collider", lift.replace("1s", "0.1s"))
        self.assertEqual(done.code, 5, done.err)
        self.assertIn("'lift'", done.err)

    def test_regions_have_materials_of_their_own(self) -> None:
        state = self.folder / "s.h5"
        self.animated("--voxels", 8, "--frames", 1, "--region", "x>50%: foam,density=77", "--pin",
                      "x<10%", "--state", state)
        with h5py.File(state) as file:
            self.assertEqual(file["materials"]["density"].tolist(), [1100, 77])
            right = file["grid/rest"][()][file["grid/corners"][:, 0], 0] + file.attrs["h"] / 2 > 0
            self.assertEqual(file["grid/material"][()].tolist(), right.astype(int).tolist())


if __name__ == "__main__":
    unittest.main()
