# SPDX-License-Identifier: Apache-2.0
"""What the command says of the device that it runs on."""

from __future__ import annotations

import json
import unittest

import h5py

from test_command import Command, animate, run


class Device(Command):
    """Exit code 7, and what iterations ran on."""

    def test_a_card_that_is_asked_for_must_be_there(self) -> None:
        report = self.folder / "r.json"
        options = ("--voxels", 8, "--frames", 1, "--pin", "x<10%", "--report", report)
        done = animate(self.source, self.output, *options, "--device", "cuda")
        if done.code == 0:  # there is one
            self.assertNotEqual(json.loads(report.read_text())["device"], "cpu")
        else:
            self.refused(done, 7, "CUDA", "--device")
        self.assertEqual(animate(self.source, self.output, *options, "--device", "cpu").code, 0)
        self.assertEqual(json.loads(report.read_text())["device"], "cpu")

    def test_a_drop_has_the_same_bits_again(self) -> None:
        options = ("--voxels", 8, "--frames", 6, "--fps", 24, "--material", "jelly", "--size", "20cm",
                   "--floor", "y=-15cm", "--device", "cuda", "--quiet")
        states = []
        for name in "ab":
            state = self.folder / f"{name}.h5"
            done = animate(self.source, self.output, *options, "--state", state)
            if done.code == 7:
                self.skipTest("no card")
            self.assertEqual(done.code, 0, done.err)
            with h5py.File(state) as file:
                states.append([file[f"steps/{table}"][()].tobytes() for table in "xv"])
        self.assertEqual(*states)

    def test_finite_elements_have_none(self) -> None:
        self.refused(run("simulate", self.source, "-o", self.output, "--device", "cuda"), 2,
                     "simulate", "--device")


if __name__ == "__main__":
    unittest.main()
