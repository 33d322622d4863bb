# SPDX-License-Identifier: Apache-2.0
"""Nets of materials that no weight file is shipped for: fitted, checked, cached; without libtorch."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from command import BINARY, Run, turned_box, write_obj

UNSHIPPED = ("--law", "stvk", "--poisson", "0.37")


class Weights(unittest.TestCase):
    """A folder of its own, with a bar and an empty cache."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.bar = write_obj(self.folder / "bar.obj", *turned_box((1, 0.25, 0.25), (0, 0, 1), 0))
        self.cache = self.folder / "cache"

    def animate(self, out: str, *words: str, **variables: str) -> Run:
        """Six frames of the bar by a net."""
        command = [BINARY, "animate", self.bar, "-o", self.folder / out, "--energy", "neural",
                   "--young", "1e5", "--voxels", "8", "--frames", "6", "--pin", "x<5%", "--quiet",
                   *words]
        environment = os.environ | {"XDG_CACHE_HOME": str(self.cache)} | variables
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120,
                              env=environment)
        return Run(done.returncode, done.stdout, done.stderr)

    def cached(self) -> list[Path]:
        """Files of the cache."""
        return sorted((self.cache / "elastogen/weights").glob("*"))

    def test_fits_once_and_keeps_what_it_fitted(self) -> None:
        first = self.animate("a.glb", *UNSHIPPED)
        self.assertEqual(first.code, 0, first.err)
        clip = (self.folder / "a.glb").read_bytes()
        made = self.cached()
        self.assertEqual(len(made), 1)
        self.assertRegex(made[0].name, r"^[0-9a-f]{16}-stvk-0\.37\.weights$")
        content = made[0].read_bytes()
        self.assertEqual(hashlib.sha256(content[:-32]).digest(), content[-32:])
        stamp = made[0].stat().st_mtime_ns
        self.assertEqual(self.animate("a.glb", *UNSHIPPED).code, 0)
        self.assertEqual([path.stat().st_mtime_ns for path in self.cached()], [stamp])
        self.assertEqual((self.folder / "a.glb").read_bytes(), clip)

    def test_makes_a_damaged_file_of_the_cache_again(self) -> None:
        self.assertEqual(self.animate("a.glb", *UNSHIPPED).code, 0)
        path, = self.cached()
        content = path.read_bytes()
        for damaged in (content[:-100], content[:3000] + b"!" + content[3001:], b""):
            path.write_bytes(damaged)
            again = self.animate("b.glb", *UNSHIPPED)
            self.assertEqual(again.code, 0, again.err)
            self.assertEqual(path.read_bytes(), content)

    def test_does_without_a_cache_that_cannot_be_written(self) -> None:
        self.cache.write_text("a file where the folder would be")
        done = self.animate("a.glb", *UNSHIPPED)
        self.assertEqual(done.code, 0, done.err)
        self.assertEqual(self.cache.read_text(), "a file where the folder would be")

    def test_refuses_what_cannot_be_fitted_and_writes_nothing(self) -> None:
        done = self.animate("a.glb", "--law", "stvk", "--poisson", "0.4995")
        self.assertEqual(done.code, 2, done.err)
        self.assertIn("nets are made up to 0.499", done.err)
        self.assertFalse((self.folder / "a.glb").exists())
        self.assertEqual(self.cached(), [])

    def test_refuses_damaged_hidden_layers_by_name(self) -> None:
        own = self.folder / "own"
        own.mkdir()
        (own / "hidden.tensors").write_bytes(b"elastogen-tensor but no more")
        done = self.animate("a.glb", *UNSHIPPED, ELASTOGEN_WEIGHTS=str(own))
        self.assertEqual(done.code, 3, done.err)
        self.assertIn("hidden.tensors", done.err)

    def test_counts_voxels_beyond_the_fit(self) -> None:
        material = ("--law", "neo-hookean", "--poisson", "0.4")
        for gravity, beyond in (("0,-9.81,0", False), ("3000,0,0", True)):
            log, report = self.folder / "l.json", self.folder / "r.json"
            done = self.animate("a.glb", *material, "--gravity", gravity, "--fps", "240",
                                "--log-json", str(log), "--report", str(report))
            self.assertIn(done.code, (0, 4), done.err)
            counts = [json.loads(line)["outside_fit"] for line in log.read_text().splitlines()]
            told = json.loads(report.read_text())
            self.assertEqual(told["outside_fit"], sum(counts))
            self.assertEqual(sum(counts) > 0, beyond)
            warned = [w for w in told["warnings"] if "beyond what their nets were fitted" in w]
            self.assertEqual(len(warned), int(beyond))
            if beyond:
                steps = sum(count > 0 for count in counts)
                self.assertIn(f"in {steps} of {len(counts)} steps", warned[0])

    def test_opens_no_libtorch(self) -> None:
        for material in (("--law", "neo-hookean", "--poisson", "0.4"), UNSHIPPED):
            done = self.animate("a.glb", *material, LD_DEBUG="libs")
            self.assertEqual(done.code, 0, done.err[-2000:])
            self.assertIn("libstdc++", done.err)  # the loader did speak
            for library in ("torch", "c10", "elastogen_learn"):
                self.assertNotIn(library, done.err)


if __name__ == "__main__":
    unittest.main()
