# SPDX-License-Identifier: Apache-2.0
"""The programs of examples/, each in a folder of its own: each checks its claim itself."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from command import BINARY

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


class Examples(unittest.TestCase):
    def test_every_program_meets_its_claim(self) -> None:
        programs = sorted(set(EXAMPLES.glob("*.py")) - {EXAMPLES / "common.py"})
        self.assertGreaterEqual(len(programs), 10)
        for program in programs:
            with self.subTest(program.stem), tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([sys.executable, "-B", program], cwd=folder, check=False,
                                      capture_output=True, text=True, timeout=300,
                                      env=os.environ | {"ELASTOGEN_BINARY": BINARY})
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertIn("ok  ", done.stdout)

    def test_programs_and_scenes_are_short(self) -> None:
        for path in [*EXAMPLES.glob("*.py"), *EXAMPLES.glob("scenes/*.toml")]:
            self.assertLess(len(path.read_text().splitlines()), 80, path)

    def test_a_claim_that_is_not_met_ends_with_one(self) -> None:
        words = "from common import claim; claim('a number', 2.0, 0, 1)"
        done = subprocess.run([sys.executable, "-B", "-c", words], cwd=EXAMPLES, check=False,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 1)
        self.assertIn("FAIL a number: 2, expected 0 ... 1", done.stdout)


if __name__ == "__main__":
    unittest.main()
