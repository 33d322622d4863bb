# SPDX-License-Identifier: Apache-2.0
"""`elastogen bench` on tiny sizes, and its PyTorch baseline against `--solver paper`."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np

from command import run

ROOT = Path(__file__).parents[2]


class Bench(unittest.TestCase):
    """A folder of its own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.json = self.folder / "bench.json"

    def measured(self, *words: object, code: int = 0) -> Any:
        """The JSON of a run on the CPU."""
        done = run("bench", *words, "--device", "cpu", "--json", self.json, timeout=300)
        self.assertEqual(done.code, code, done.err)
        return json.loads(self.json.read_text())

    def refused(self, code: int, words: tuple[object, ...], *texts: str) -> None:
        done = run("bench", *words)
        self.assertEqual(done.code, code, done.err)
        for text in texts:
            self.assertIn(text, done.err)
        self.assertFalse(self.json.exists())


class Parts(Bench):
    """Fields and plausibility of each part."""

    def test_says_what_it_ran_on(self) -> None:
        result = self.measured("ceilings", "--threads", 1)
        for key in ("command", "version", "commit", "date"):
            self.assertTrue(result[key], key)
        self.assertIsNone(result["card"])
        self.assertIsNone(result["ceilings"]["card"])
        self.assertEqual(result["machine"]["threads"], 1)
        row, = result["ceilings"]["host"]
        # between a slow laptop and a large server
        for key, low, high in (("copy_bytes_per_second", 1e9, 1e12),
                               ("float_flops_per_second", 1e9, 1e13),
                               ("double_flops_per_second", 5e8, 1e13),
                               ("parallel_loop_us", 1e-3, 1e5)):
            self.assertTrue(low < row[key] < high, f"{key} {row[key]}")
        ratio = row["float_flops_per_second"] / row["double_flops_per_second"]
        self.assertTrue(0.2 < ratio < 20, ratio)  # 2 on a machine with nothing else to do
        ratio = result["copy_bytes_per_second"]["host"] / row["copy_bytes_per_second"]
        self.assertTrue(0.1 < ratio < 10, ratio)

    def test_kernels_have_time_and_bytes(self) -> None:
        result = self.measured("kernels", "--sizes", 2000)
        rows, copy = result["kernels"], result["copy_bytes_per_second"]["host"]
        self.assertEqual(len({row["kernel"] for row in rows}), 8)
        for row in rows:
            self.assertGreater(row["ms"], 0)
            rate = row["bytes_a_voxel"] * row["voxels"] / (1e-3 * row["ms"])
            self.assertAlmostEqual(rate / row["bytes_per_second"], 1, 6)
            self.assertAlmostEqual(rate / copy / row["copy_share"], 1, 6)

    def test_particles_step_explicitly_and_implicitly(self) -> None:
        result = self.measured("particles", "--sizes", 800, "--repeat", 2)
        rows = result["particles"]
        self.assertEqual({row["integrator"] for row in rows}, {"explicit", "implicit"})
        for row in rows:
            self.assertEqual(row["particles"], 800)
            self.assertAlmostEqual(row["updates_per_second"] * row["ms"] / (1e3 * 800), 1, 6)
            if row["integrator"] == "implicit":
                self.assertEqual((row["steps"], row["certified"]), (2, 2))
                self.assertGreaterEqual(row["newton_a_step"], 1)

    def test_steps_over_all_axes(self) -> None:
        rows = self.measured("step", "--sizes", "500,3000", "--courant", "2,10", "--poisson",
                             "0.3,0.45", "--fill", "1,0.3", "--repeat", 3)["step"]
        self.assertEqual(len(rows), 16)
        self.assertEqual({(r["poisson"], r["fill"]) for r in rows},
                         {(nu, fill) for nu in (0.3, 0.45) for fill in (1, 0.3)})
        for row in rows:
            self.assertTrue(row["converged"])
            self.assertLessEqual(row["residual"], 1e-3)
            self.assertEqual(row["residuals_of_drafts_before"], [])
            self.assertTrue(0 < row["ms_lower_quartile"] <= row["ms"] <= row["ms_upper_quartile"])
            self.assertGreater(row["evaluations"], 0)
            self.assertIsNone(row["card_bytes_a_voxel"])
            self.assertTrue(any(math.isclose(row["courant"], c) for c in (2, 10)))
            self.assertEqual(row["device"], "cpu")

    def test_a_step_that_misses_its_tolerance_is_code_4(self) -> None:
        rows = self.measured("step", "--sizes", 500, "--tolerance", 1e-12, "--courant", 1000,
                             "--repeat", 1, code=4)["step"]
        self.assertFalse(rows[0]["converged"])
        self.assertGreater(rows[0]["residual"], 1e-12)

    def test_c84_has_its_own_numbers(self) -> None:
        row, = self.measured("step", "--scenes", "c84", "--sizes", 4000, "--courant", "1,2",
                             "--repeat", 1)["step"]
        # dt/h sqrt(E/rho) with h = 1/40 m
        self.assertAlmostEqual(row["courant"], 40 / 30 * math.sqrt(1e5 / 1000), 6)

    def test_errors_fall_with_the_tolerance(self) -> None:
        rows = self.measured("error-time", "--sizes", 500, "--courant", 3, "--repeat", 1,
                             "--tolerances", "1e-1,1e-4")["error-time"]
        for solver in ("quasi", "newton"):
            coarse, fine = (row for row in rows if row["solver"] == solver)
            self.assertLess(fine["error"], 0.1 * coarse["error"])
            self.assertLessEqual(fine["residual"], 1e-4)
        paper = [row for row in rows if row["solver"] == "paper"]
        self.assertEqual([row["outer"] for row in paper], [1, 3, 10, 30, 100])
        self.assertLess(paper[0]["ms"], paper[-1]["ms"])

    def test_startup_runs_the_command(self) -> None:
        rows = self.measured("startup", "--sizes", "1000,8000")["startup"]
        for row, voxels in zip(rows, (1000, 8000), strict=True):
            self.assertTrue(0.7 < row["voxels"] / voxels < 1.4, row["voxels"])
            self.assertGreater(row["seconds"], row["stage_seconds"]["steps"])
            # of the program itself, not of the tool that measures it
            self.assertTrue(1e3 < row["bytes_a_voxel"] * row["voxels"] / 1e4 < 3e4)

    def test_a_card_that_is_asked_for_must_be_there(self) -> None:
        done = run("bench", "kernels", "--sizes", 1000, "--device", "cuda", "--json", self.json)
        if done.code == 0:  # there is one
            result = json.loads(self.json.read_text())
            self.assertTrue(result["card"])
            self.assertGreater(result["copy_bytes_per_second"]["card"], 1e10)
            self.assertEqual({row["device"] for row in result["kernels"]}, {"cuda"})
        else:
            self.assertEqual(done.code, 7, done.err)
            self.assertIn("CUDA", done.err)

    def test_refuses_what_it_does_not_know(self) -> None:
        self.refused(2, ("speed",), "speed", "error-time")
        self.refused(2, (), "PART")
        self.refused(2, ("step", "--scenes", "spoon"), "spoon", "c84")
        self.refused(2, ("step", "--fill", 0), "--fill")
        self.refused(2, ("step", "--poisson", "0.3,0.5"), "--poisson")
        self.refused(2, ("baseline", "--runs", "fast"), "fast", "eager-library")
        self.refused(2, ("baseline", "--script", self.folder / "none.py"), "none.py", "--script")
        self.refused(2, ("baseline", "--sizes", 500, "--python", self.folder / "none"), "--python")

    def test_figures_are_well_formed(self) -> None:
        self.measured("error-time", "step", "baseline", "--sizes", "500,1000", "--repeat", 1,
                      "--python", sys.executable, "--runs", "numpy-library")
        subprocess.run([sys.executable, ROOT / "bench" / "plot.py", self.json, "--out",
                        self.folder], check=True, capture_output=True)
        figures = sorted(path.name for path in self.folder.glob("*.svg"))
        self.assertEqual(figures, ["error_time_beam_500_c10_nu0.4.svg",
                                   "error_time_beam_864_c10_nu0.4.svg", "step.svg"])
        for name in figures:
            root = ElementTree.parse(self.folder / name).getroot()
            points = [e for e in root.iter() if e.tag.endswith("circle")]
            self.assertGreater(len(points), 3)
            for point in points:
                self.assertTrue(0 < float(point.get("cx", "nan")) < float(root.get("width", "0")))
                self.assertTrue(0 < float(point.get("cy", "nan")) < float(root.get("height", "0")))


class Baseline(Bench):
    """bench/baselines/elastogen_paper.py."""

    def rows(self, *words: object) -> dict[str, Any]:
        case, = self.measured("baseline", "--sizes", 500, "--courant", 2, "--repeat", 1,
                              "--poisson", 0.3, *words)["baseline"]
        self.assertLess(case["reference_residual"], 1e-8)
        return {row["run"]: row for row in case["rows"]}

    def test_is_the_paper_solver_without_torch(self) -> None:
        rows = self.rows("--python", sys.executable, "--runs", "numpy-library,numpy-jacobi",
                         "--outer", 3, "--inner", 10, "--modes", 27)
        paper = rows["elastogen paper"]
        self.assertGreater(paper["error"], 10 * rows["elastogen quasi"]["error"])
        for run_name in ("numpy-library", "numpy-jacobi"):
            row = rows[f"paper in PyTorch, {run_name}"]
            self.assertEqual(row["dtype"], "float32")
            # one iterate: the rounding of float32 is far below its error
            self.assertAlmostEqual(row["error"] / paper["error"], 1, 3)
            self.assertAlmostEqual(row["residual"] / paper["residual"], 1, 2)

    def test_is_the_paper_solver_in_torch(self) -> None:
        try:
            import torch  # noqa: F401
        except ImportError:
            self.skipTest("there is no torch here")
        rows = self.rows("--python", sys.executable, "--runs", "eager-library,eager-jacobi")
        for run_name in ("eager-library", "eager-jacobi"):
            row = rows[f"paper in PyTorch, {run_name}"]
            self.assertAlmostEqual(row["error"] / rows["elastogen paper"]["error"], 1, 3)

    def test_says_that_torch_is_missing(self) -> None:
        try:
            import torch  # noqa: F401
        except ImportError:
            self.refused(2, ("baseline", "--sizes", 500, "--device", "cpu", "--python",
                             sys.executable, "--runs", "eager-library"), "PyTorch", "--python")

    def test_a_run_that_fails_is_code_4(self) -> None:
        script = self.folder / "broken.py"
        script.write_text("raise SystemExit(9)")
        case, = self.measured("baseline", "--sizes", 500, "--python", sys.executable, "--script",
                              script, "--runs", "numpy-library", "--repeat", 1, code=4)["baseline"]
        self.assertEqual(case["rows"][-1]["exit_code"], 9)

    def test_its_states_are_those_of_double_precision(self) -> None:
        folder = self.folder / "scene"
        folder.mkdir()
        dims = (5, 3, 2)
        nodes = tuple(n + 1 for n in reversed(dims))
        pinned = np.zeros(nodes, np.uint8)
        pinned[:, :, 0] = 1
        start = np.random.default_rng(1).normal(size=(*nodes, 3)) * 2e-3
        start[:, :, 0] = 0
        (folder / "scene.json").write_text(json.dumps({
            "dims": dims, "h": 0.1, "dt": 0.02, "young": 2e5, "poisson": 0.3, "density": 1000,
            "gravity": [0, -9.81, 0], "outer": 5, "inner": 20, "modes": 27}))
        np.ones(tuple(reversed(dims)), np.uint8).tofile(folder / "solid.u8")
        pinned.tofile(folder / "pinned.u8")
        start.tofile(folder / "u.f64")
        (0 * start).tofile(folder / "v.f64")
        found = []
        for dtype, svd in (("float64", "library"), ("float64", "jacobi"), ("float32", "jacobi")):
            out = self.folder / f"{dtype}-{svd}"
            subprocess.run([sys.executable, ROOT / "bench" / "baselines" / "elastogen_paper.py",
                            folder, "--out", out, "--mode", "numpy", "--svd", svd, "--dtype", dtype,
                            "--repeat", "1", "--steps", "2"], check=True)
            found.append(np.fromfile(out / "u.f64"))
        motion = np.abs(found[0] - start.ravel()).max()
        self.assertGreater(motion, 1e-3)
        self.assertLess(np.abs(found[1] - found[0]).max(), 1e-11 * motion)
        self.assertLess(np.abs(found[2] - found[0]).max(), 1e-4 * motion)
        self.assertTrue((found[0].reshape(*nodes, 3)[:, :, 0] == 0).all())


if __name__ == "__main__":
    unittest.main()
