# SPDX-License-Identifier: Apache-2.0
"""animate --batch: the files of single runs, clashes, failing scenes, signals."""

from __future__ import annotations

import os
import signal
import subprocess
import time
import unittest
from pathlib import Path

import h5py
import numpy as np

from command import BINARY, Run
from test_verbs import Verbs

TEXT = """
pins = ["x<10%"]
[asset]
file = "box.obj"
voxels = 8
[material]
young = "{young}"
[time]
frames = 3
substeps = 1
[output]
files = ["{name}.glb", "{name}.ply", "{name}.pc2"]
state = "{name}.h5"
"""
YOUNG = {"a": "100 kPa", "b": "200 kPa", "c": "1 MPa"}
FILES = [f"{name}.toml" for name in YOUNG]


class Batch(Verbs):
    """Three scenes in a folder, where the command runs."""

    def setUp(self) -> None:
        super().setUp()
        for name, young in YOUNG.items():
            self.scene(TEXT.format(name=name, young=young), f"{name}.toml")
        self.given = self.names()

    def names(self) -> set[str]:
        return {path.name for path in self.folder.iterdir()}

    def here(self, *words: object) -> Run:
        """The command, run in the folder."""
        done = subprocess.run([BINARY, *(str(word) for word in words)], cwd=self.folder, check=False,
                              capture_output=True, text=True, timeout=120)
        return Run(done.returncode, done.stdout, done.stderr)

    def taken(self) -> dict[str, bytes]:
        """What was written, by its name, and removed; of states the motion, for they have times."""
        found = {}
        for name in sorted(self.names() - self.given):
            path = self.folder / name
            if path.suffix == ".h5":
                with h5py.File(path, "r") as file:
                    found[name] = np.asarray(file["steps/x"]).tobytes()
            else:
                found[name] = path.read_bytes()
            path.unlink()
        return found

    def singly(self, *words: object) -> dict[str, bytes]:
        for file in FILES:
            done = self.here("animate", "--scene", file, *words)
            self.assertEqual(done.code, 0, done.err)
        return self.taken()

    def test_the_files_are_those_of_single_runs_at_any_number_of_jobs(self) -> None:
        single = self.singly("--frames", 5)
        self.assertEqual(len(single), 3 * (3 + 6))
        self.assertEqual(len({single[f"{name}.pc2"] for name in YOUNG}), 3)
        for jobs in (1, 3):
            done = self.here("animate", "--jobs", jobs, "--batch", *FILES, "--frames", 5)
            self.assertEqual(done.code, 0, done.err)
            self.assertEqual(self.taken(), single)
            lines = done.out.splitlines()
            self.assertEqual(len(lines), 4)
            for k, line in enumerate(lines[:3]):
                self.assertRegex(line, rf"^{k + 1}/3 [abc]\.toml: 5 frames, 5 of 5 steps solved")
            self.assertTrue(lines[3].startswith("3 of 3 scenes in "), lines[3])

    def test_quiet_prints_nothing(self) -> None:
        done = self.here("animate", f"--batch={FILES[0]}", FILES[1], "--quiet", "--jobs=2")
        self.assertEqual((done.code, done.out, done.err), (0, "", ""))
        self.assertEqual({"a.glb", "b.glb"}, {n for n in self.names() if n.endswith(".glb")})

    def test_files_that_two_scenes_would_share_are_refused_before_anything_runs(self) -> None:
        box = 'pins = ["x<10%"]\n[asset]\nfile = "box.obj"\n[output]\n'
        for output, name in (('files = ["./b.glb"]', "b.glb"), ('files = ["b.pvd", "b.ply"]', "b_00000.ply"),
                             ('files = ["d.ply"]\nlog = "b.h5"', "b.h5"),
                             ('files = ["d.glb"]\nreport = "b_00002.ply"', "b_00002.ply"),
                             ('files = ["d.glb"]\nreport = "b.toml"', "b.toml")):
            with self.subTest(name):
                self.scene(box + output, "a.toml")
                for files in (FILES, FILES[::-1]):
                    self.refused(self.here("animate", "--batch", *files), 2, name, "a.toml", "b.toml")
                    self.assertEqual(self.names(), self.given)
        self.refused(self.here("animate", "--batch", "c.toml", "c.toml"), 2, "c.toml and c.toml")
        self.assertEqual(self.names(), self.given)

    def test_a_frame_that_is_not_written_is_no_clash(self) -> None:
        text = TEXT.format(name="a", young="1 MPa") + 'report = "b_00004.ply"\n'
        self.scene(text, "a.toml")
        done = self.here("animate", "--batch", *FILES)
        self.assertEqual(done.code, 0, done.err)

    def test_options_that_would_be_of_all_scenes_are_named(self) -> None:
        for words in (["-o", "x.glb"], ["--state", "x.h5"], ["--log-json", "x"], ["--report", "x"],
                      ["--scene", "a.toml"], ["--print-resolved"]):
            name = "--output" if words[0] == "-o" else words[0]
            self.refused(self.here("animate", *words, "--batch", *FILES), 2, name, "--batch")
        self.refused(self.here("animate", "--batch", *FILES, "--jobs", -1), 2, "--jobs")
        self.refused(self.here("animate", "--scene", "a.toml", "--jobs", 2), 2, "--jobs", "--batch")
        self.refused(self.here("animate", "--batch"), 2)
        self.refused(self.here("simulate", "--batch", *FILES), 2, "--batch")
        self.assertEqual(self.names(), self.given)

    def test_a_broken_scene_leaves_the_others_alone(self) -> None:
        whole = self.singly()
        others = {name: data for name, data in whole.items() if not name.startswith("b")}
        (self.folder / "broken.obj").write_text("v 0 0\n")
        text = (self.folder / "b.toml").read_text()
        self.given.add("broken.obj")
        for broken, words in ((text.replace("box.obj", "none.obj"), ["none.obj"]),
                              (text.replace("box.obj", "broken.obj"), ["broken.obj"]),
                              (text.replace("[time]", "[times]"), ["b.toml:", "times"]),
                              (text + "\n[limits]\nmax_voxels = 9\n", ["budget"])):
            with self.subTest(words):
                self.scene(broken, "b.toml")
                single = self.here("animate", "--scene", "b.toml", "--quiet")
                self.assertGreater(single.code, 0)
                self.assertEqual(self.taken(), {})
                done = self.here("animate", "--batch", *FILES, "--jobs", 2)
                self.refused(done, single.code, "elastogen: b.toml:", *words)
                self.assertIn("2 of 3 scenes", done.out)
                self.assertEqual(self.taken(), others)

    def test_the_code_is_that_of_the_first_failing_scene_in_the_order_given(self) -> None:
        missing = TEXT.format(name="d", young="1 MPa").replace("box.obj", "none.obj")
        self.scene(missing, "d.toml")  # exit code 3
        self.scene("[times]\n", "e.toml")  # exit code 2
        for files, code in (("a.toml d.toml e.toml", 3), ("e.toml b.toml d.toml", 2)):
            for jobs in (1, 3):
                done = self.here("animate", "--batch", *files.split(), "--jobs", jobs)
                self.assertEqual(done.code, code, done.err)

    def test_warnings_name_their_scene(self) -> None:
        text = (self.folder / "b.toml").read_text()
        self.scene(text.replace('pins = ["x<10%"]', ""), "b.toml")
        done = self.here("animate", "--batch", *FILES)
        self.assertEqual(done.code, 0, done.err)
        self.assertEqual(len(done.err.splitlines()), 1, done.err)
        self.assertTrue(done.err.startswith("warning: b.toml: nothing holds"), done.err)

    def test_a_signal_ends_all_scenes_and_keeps_what_there_is(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            words = [BINARY, "animate", "--batch", *FILES, "--jobs", "2", "--frames", "100000"]
            with subprocess.Popen(words, cwd=self.folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True) as process:
                self.wait_for("a_00001.ply", "b_00001.ply")
                process.send_signal(number)
                out, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 128 + number, err)
            self.assertEqual(err.count("interrupted"), 2)
            self.assertIn("2 of 3 scenes", out)
            found = self.taken()
            for name in ("a.glb", "a.pc2", "a.h5", "b.glb", "b.pc2", "b.h5"):
                self.assertIn(name, found)
            self.assertFalse([name for name in found if name.startswith("c") or "tmp" in name])

    def wait_for(self, *names: str) -> None:
        end = time.monotonic() + 60
        while not all(os.path.exists(Path(self.folder) / name) for name in names):
            self.assertLess(time.monotonic(), end, "no frames")
            time.sleep(0.01)


if __name__ == "__main__":
    unittest.main()
