# SPDX-License-Identifier: Apache-2.0
"""The criteria of the stress scenes find what is wrong: a sound run has no fault, each lie has its."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import unittest
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scenes"))
from runs import HERE, Finished, run_scene  # noqa: E402
from stress_checks import BASE, all_faults  # noqa: E402


class StressChecks(unittest.TestCase):
    """Two runs of a falling beam, one of which is told lies about."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.run, self.again = (
            run_scene(Path(os.environ["ELASTOGEN_BINARY"]), "animate",
                      HERE / "stress" / "beam.toml", ("--frames", "5"), Path(folder.name) / name)
            for name in ("a", "b"))

    def faults(self, run: Finished | None = None) -> str:
        return "\n".join(all_faults(run or self.run, self.again, {0}, True))

    def change(self, name: str, how: Callable[[np.ndarray], object]) -> str:
        """Faults after a dataset of the state file was changed in place."""
        with h5py.File(self.run.folder / "state.h5", "r+") as file:
            values = file[name][()]
            how(values)
            file[name][...] = values
        return self.faults()

    def test_a_sound_run_has_no_fault(self) -> None:
        self.assertEqual(self.faults(), "")

    def test_an_exit_code_that_is_not_documented(self) -> None:
        self.assertIn("U1", self.faults(replace(self.run, code=-11)))
        self.assertIn("U1", self.faults(replace(self.run, code=4)))

    def test_a_number_that_is_none(self) -> None:
        self.assertIn("U2", self.change("steps/energy_elastic", lambda e: e.__setitem__(2, np.nan)))

    def test_a_refusal_without_a_word_and_with_an_animation(self) -> None:
        self.assertEqual(self.faults(replace(self.run, code=3, err="")).count("U3"), 2)

    def test_motion_from_nowhere(self) -> None:
        found = self.change("steps/v", lambda v: v[3].__imul__(1.5))
        self.assertIn("U4", found)
        self.assertIn("U8", found)  # the next step does not follow from it

    def test_a_step_of_endless_work(self) -> None:
        self.assertIn("U5", self.change("steps/inner", lambda n: n.__setitem__(1, 100000)))
        report = self.run.folder / "report.json"
        report.write_text(json.dumps(json.loads(report.read_text()) | {"long_steps": [2]}))
        self.assertEqual(self.faults(), "")

    def test_more_memory_than_the_budget(self) -> None:
        self.assertIn("U6", self.faults(replace(self.run, peak=2 * BASE)))

    def test_other_bits(self) -> None:
        self.assertIn("U7", self.change("steps/x", lambda x: x[4].__iadd__(1e-15)))

    def test_a_residual_that_is_not_the_true_one(self) -> None:
        self.assertIn("U8", self.change("steps/residual", lambda r: r.__imul__(0.5)))

    def test_a_step_that_is_not_converged_and_says_so(self) -> None:
        self.assertRegex(self.change("steps/x", lambda x: x[5].__iadd__(1e-3)), "U8: .*step 4")


if __name__ == "__main__":
    unittest.main()
