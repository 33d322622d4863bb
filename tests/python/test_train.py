# SPDX-License-Identifier: Apache-2.0
"""`elastogen train mtl`: files, exit codes, interruption, and the library it opens."""

from __future__ import annotations

import csv
import hashlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from command import BINARY, run

SHORT = ("--steps", 12, "--samples", 12, "--last-layer", 0)
LIST = "# two\nsoft, neo-hookean, 0.1\nmix, 0.5*stvk+0.5*hencky, 0.4\n"


class Train(unittest.TestCase):
    """A folder of its own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_writes_weights_that_miss_the_limits_with_code_4(self) -> None:
        out = self.folder / "a.weights"
        done = run("train", "mtl", "--law", "stvk", "--poisson", 0.3, "-o", out, *SHORT)
        self.assertEqual(done.code, 4, done.err)
        self.assertIn("FAILS", done.out)
        content = out.read_bytes()
        self.assertEqual(hashlib.sha256(content[:-32]).digest(), content[-32:])
        self.assertIn(b"error.stress.p99", content)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["a.weights"])

    def test_writes_a_folder_for_a_list(self) -> None:
        names = self.folder / "list.csv"
        names.write_text(LIST)
        out = self.folder / "out"
        done = run("train", "mtl", "--list", names, "-o", out, "--quiet", *SHORT)
        self.assertEqual((done.code, done.out), (4, ""), done.err)
        self.assertEqual(sorted(path.name for path in out.iterdir()),
                         ["mix.weights", "report.csv", "soft.weights"])
        rows = list(csv.DictReader((out / "report.csv").read_text().splitlines()))
        self.assertEqual([row["name"] for row in rows], ["soft", "mix"])
        for row in rows:
            self.assertGreater(float(row["stress_p99"]), float(row["stress_median"]))
            self.assertEqual(row["passes"], "no")

    def test_shares_hidden_layers_and_fits_the_last_on_them(self) -> None:
        names = self.folder / "list.csv"
        names.write_text(LIST)
        done = run("train", "mtl", "--list", names, "-o", self.folder / "out", "--quiet",
                   "--shared-hidden", *SHORT)
        self.assertEqual(done.code, 4, done.err)
        hidden = self.folder / "out/hidden.tensors"
        self.assertIn(b"log stretches 2", hidden.read_bytes())
        mix = self.folder / "mix.weights"
        done = run("train", "mtl", "--law", "0.5*stvk+0.5*hencky", "--poisson", 0.46, "-o", mix,
                   "--start", hidden, "--steps", 0)
        self.assertEqual(done.code, 0, done.out + done.err)  # on layers hardly trained
        self.assertIn("1 of 1 inside all limits", done.out)

    def test_goes_on_after_an_interruption(self) -> None:
        whole, parts = self.folder / "whole", self.folder / "parts"
        options = ["train", "mtl", "--steps", "120", "--samples", "48", "--last-layer", "0", "-o"]
        self.assertEqual(run(*options, whole).code, 4)
        process = subprocess.Popen([BINARY, *options, str(parts)], stdout=subprocess.PIPE)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
        if process.returncode == 130:  # else it was done before the signal came
            self.assertTrue((self.folder / "parts.part").exists())
            self.assertFalse(parts.exists())
            self.assertEqual(run(*options, parts, "--resume").code, 4)
        self.assertEqual(parts.read_bytes(), whole.read_bytes())
        self.assertFalse((self.folder / "parts.part").exists())

    def test_refuses_what_it_cannot_fit(self) -> None:
        out = self.folder / "a"
        names = self.folder / "list.csv"
        names.write_text("soft, jam, 0.1\n")
        for code, words in ((2, ("--law", "jam")), (2, ("--poisson", 0.5)), (2, ("--steps", 0)), (2, ("--steps", -1)),
                            (2, ("--last-layer", -1)),
                            (2, ("--device", "tpu")), (3, ("--list", names)),
                            (3, ("--list", self.folder / "none"))):
            with self.subTest(words=words):
                done = run("train", "mtl", "-o", out, *words)
                self.assertEqual(done.code, code, done.err)
                self.assertFalse(out.exists())

    def test_names_the_places_where_its_library_is_not(self) -> None:
        alone = self.folder / "elastogen"
        shutil.copy(BINARY, alone)
        done = subprocess.run([alone, "train", "mtl", "-o", self.folder / "a"],
                              capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("libelastogen_learn.so: no such file", done.stderr)

    def test_other_verbs_open_no_libtorch(self) -> None:
        done = subprocess.run([BINARY, "materials"], capture_output=True, text=True, check=False,
                              timeout=60, env={"LD_DEBUG": "libs"})
        self.assertEqual(done.returncode, 0)
        self.assertIn("libc.so", done.stderr)
        self.assertNotIn("torch", done.stderr)


if __name__ == "__main__":
    unittest.main()
