# SPDX-License-Identifier: Apache-2.0
"""`elastogen study` of a small beam: what its files say of errors that are known to fall."""

from __future__ import annotations

import csv
import json
import math
import signal
import subprocess
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from command import BINARY, run, turned_box, write_obj

BEAM = ("--young", "1e6", "--poisson", "0.3", "--density", "1000", "--size", "1 m",
        "--voxels", 16, "--fps", 60, "--substeps", 1)


class Balance(HTMLParser):
    """Counts what is opened and closed."""

    VOID = {"meta", "link", "br", "hr", "img", "input"}

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.tags.add(tag)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: Any) -> None:
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            raise ValueError(f"</{tag}>")


class Study(unittest.TestCase):
    """One study, looked at from several sides."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)
        cls.source = write_obj(cls.path / "bar.obj", *turned_box((1, 0.12, 0.12), (0, 0, 1), 0))
        done = run("study", cls.source, *BEAM, "--pin", "x<1%", "--frames", 6, "--repeat", 1,
                   "--folder", cls.path / "out", "--time-steps", "1,2,4", timeout=300)
        assert done.code == 0, done.err
        cls.result = json.loads((cls.path / "out" / "study.json").read_text())
        cls.runs = {r["name"]: r for r in cls.result["runs"]}

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def errors(self, solver: str, measure: str) -> list[float]:
        """Largest errors of a solver's runs against its own grid, in their order."""
        return [r["solver_error"][measure]["max"] for r in self.result["runs"]
                if r["solver"] == solver and r["solver_error"]]

    def test_errors_fall_with_the_tolerance(self) -> None:
        for solver in ("quasi", "newton"):
            for measure in ("step", "free_run"):
                found = self.errors(solver, measure)
                self.assertEqual(len(found), 5)
                self.assertLess(found[0], 0.2)
                self.assertLess(found[-1], 1e-5)
                for before, after in zip(found, found[1:]):
                    self.assertLess(after, before)
        for sweep in self.result["sweeps"]:
            if sweep["variable"] == "tolerance":
                self.assertGreater(sweep["order"], 0.5)

    def test_the_default_tolerance_is_accurate(self) -> None:
        for solver in ("quasi 1e-03", "newton 1e-03"):
            self.assertLess(self.runs[solver]["solver_error"]["step"]["max"], 1e-3)
            self.assertEqual(self.runs[solver]["converged_share"], 1)

    def test_errors_of_the_published_loop_fall_with_its_loops_and_stay_large(self) -> None:
        found = self.errors("paper", "free_run")
        self.assertEqual(len(found), 5)
        for before, after in zip(found, found[1:]):
            self.assertLess(after, before)
        self.assertGreater(found[0], 0.1)

    def test_families_have_their_own_references(self) -> None:
        # how far the reference has come from its own element on the grid of the scene
        change = self.runs["fem hex-bbar"]["discretisation_error"]["free_run"]["max"]
        self.assertGreater(change, 0)
        for r in self.result["runs"]:
            if r["solver_error"]:
                self.assertIn(r["solver_error"]["reference"], ("fem voxel", "fem voxel, variance"))
            if r["discretisation_error"]:
                self.assertEqual(r["discretisation_error"]["reference"], "fem hex-bbar h/2")
                self.assertEqual(r["discretisation_error"]["step"]["steps"], [])
                self.assertEqual(r["discretisation_error"]["reference_change"], change)
            if r["solver_error"]:
                self.assertIsNone(r["solver_error"]["reference_change"])
        linear = self.runs["fem tet4"]["discretisation_error"]["free_run"]["max"]
        quadratic = self.runs["fem tet10"]["discretisation_error"]["free_run"]["max"]
        self.assertLess(quadratic, linear)
        self.assertLess(self.runs["fem voxel"]["discretisation_error"]["free_run"]["max"], 0.03)

    def test_the_scheme_is_of_first_order(self) -> None:
        orders = [s["order"] for s in self.result["sweeps"] if s["variable"] == "dt"]
        self.assertEqual(len(orders), 1)
        # few large steps of a falling beam: the order is 1 in the limit
        self.assertTrue(0.7 < orders[0] < 1.3, orders)

    def test_times_to_errors_are_those_of_runs_that_reached_them(self) -> None:
        for entry in self.result["time_to_error"]:
            key, measure = entry["family"], entry["measure"]
            for level in entry["levels"]:
                if level["ms"] is None:
                    continue
                named = self.runs[level["run"]]
                self.assertLessEqual(named[key][measure]["max"], level["error"])
                self.assertEqual(named["step_ms"]["median"], level["ms"])

    def test_files_agree_and_are_whole(self) -> None:
        out = self.path / "out"
        with (out / "study.csv").open(newline="") as file:
            rows = list(csv.reader(file))
        self.assertEqual([row[0] for row in rows[1:]], list(self.runs))
        page = Balance()
        page.feed((out / "study.html").read_text())
        self.assertEqual(page.open, [])
        self.assertIn("svg", page.tags)
        self.assertNotIn("script", page.tags)
        for name in ("fem.pvd", "network.pvd", "fem_00006.vtu", "network_00006.vtu"):
            self.assertTrue((out / name).exists(), name)
        machine = self.result["header"]["machine"]
        self.assertGreater(machine["copy_bandwidth"], 1e8)
        self.assertTrue(all(math.isfinite(r["step_ms"]["median"]) for r in self.result["runs"]))

    def test_a_signal_ends_it_with_what_there_is(self) -> None:
        words = [BINARY, "study", str(self.source), *map(str, BEAM), "--pin", "x<1%", "--frames",
                 "200", "--folder", str(self.path / "cut")]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as child:
            for line in child.stdout:
                if line.startswith("quasi 1e-02"):
                    child.send_signal(signal.SIGINT)
                    break
            child.stdout.read()
            self.assertEqual(child.wait(timeout=60), 130)
        cut = json.loads((self.path / "cut" / "study.json").read_text())
        self.assertIn("fem voxel", [r["name"] for r in cut["runs"]])
        self.assertLess(len(cut["runs"]), len(self.runs))

    def test_refuses_what_it_cannot_do(self) -> None:
        for words, text in ((("--solvers", "auto"), "--solvers"), (("--tolerances", "2"), "--tol"),
                            (("--repeat", "0"), "--repeat"), (("--reference", "brick"), "brick"),
                            (("--hold", "x<1%: x"), "hold")):
            done = run("study", self.source, *BEAM, *words, "--folder", self.path / "none")
            self.assertEqual(done.code, 2, done.err)
            self.assertIn(text, done.err)


if __name__ == "__main__":
    unittest.main()
