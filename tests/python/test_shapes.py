# SPDX-License-Identifier: Apache-2.0
"""Bodies without a file, in space and in the plane, and the comparison of integrators of particles."""

from __future__ import annotations

import csv
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np
from command import run
from particle_files import read_ply
from test_pictures import read_png

SCENES = Path(__file__).resolve().parents[2] / "examples" / "scenes"
COLUMN = SCENES / "sand_column_2d.toml"
GRAVITY = 9.81


class Shapes(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def log(self, name: str) -> list[dict]:
        return [json.loads(line) for line in (self.folder / name).read_text().splitlines()]

    def test_columns_spread_alike_at_any_interval_of_blended_transfers(self) -> None:
        # APIC alone smooths with each transfer: 0.419 and 0.506 m
        half_widths = []
        for integrator, dt in (("explicit", 1e-4), ("implicit", 1e-3)):
            log = self.folder / integrator
            done = run("simulate", COLUMN, "--transfer", "apic-blend", "--integrator", integrator,
                       "--dt", dt, "-o", self.folder / "s.pc2", "--log-json", log)
            self.assertEqual(done.code, 0, done.err)
            end = self.log(integrator)[-1]["particles"]
            half_widths.append((end["upper"][0] - end["lower"][0]) / 2)
        self.assertAlmostEqual(half_widths[0] / half_widths[1], 1, delta=0.03)
        self.assertGreater(min(half_widths), 0.4)

    def test_a_column_in_the_plane_collapses(self) -> None:
        done = run("simulate", "--scene", COLUMN, "--frames", 5, "-o", self.folder / "s.ply",
                   "--report", self.folder / "r.json", "--log-json", self.folder / "log")
        self.assertEqual(done.code, 0, done.err)
        self.assertIn("1200 particles in the plane", done.out)
        self.assertEqual(json.loads((self.folder / "r.json").read_text())["converged_share"], 1)
        first = read_ply(self.folder / "s_00000.ply").x
        last = read_ply(self.folder / "s_00005.ply").x
        self.assertEqual(first.shape, (1200, 3))
        self.assertTrue(np.all(first[:, 2] == 0) and np.all(last[:, 2] == 0))
        log = self.log("log")
        self.assertEqual(len(log), 100)  # a transfer a step
        self.assertTrue(all(step["residual"] <= 1e-3 for step in log))
        end = log[-1]["particles"]
        np.testing.assert_allclose(end["lower"], last.min(axis=0), atol=1e-6)
        np.testing.assert_allclose(end["upper"], last.max(axis=0), atol=1e-6)
        # nobody falls faster than freely; the ground does not let go
        self.assertGreater(end["upper"][1], 0.2975 - GRAVITY * 0.1 * 0.101 / 2 - 1e-6)
        self.assertGreater(last[:, 1].min(), -1e-3)

    def test_explicit_steps_of_the_same_scene_fall_alike(self) -> None:
        ends = []
        for options in ([], ["--integrator", "explicit", "--particle-substeps", 40]):
            done = run("simulate", "--scene", COLUMN, "--frames", 5, *options,
                       "-o", self.folder / "s.ply", "--log-json", self.folder / "log")
            self.assertEqual(done.code, 0, done.err)
            ends.append(self.log("log")[-1]["particles"]["upper"])
        np.testing.assert_allclose(ends[0][:2], ends[1][:2], atol=2e-3)

    def test_pictures_show_all_of_the_particles(self) -> None:
        done = run("simulate", "--scene", COLUMN, "--frames", 1, "-o", self.folder / "s_%d.png",
                   "--camera", "front", "--image-size", "96x96")
        self.assertEqual(done.code, 0, done.err)
        pixels = read_png(self.folder / "s_0.png").astype(int)
        ground = pixels[:, 0].mean(axis=1)
        column = np.abs(pixels.mean(axis=2) - ground[:, None]) > 25
        wide, high = np.flatnonzero(column.any(axis=0)), np.flatnonzero(column.any(axis=1))
        self.assertGreater(len(high), 48)
        self.assertLess(len(wide), len(high))
        self.assertGreater(wide[0], 8)
        self.assertLess(wide[-1], 88)
        self.assertGreater(high[0], 2)

    def test_a_step_that_waves_outrun_is_refused(self) -> None:
        done = run("simulate", "--scene", COLUMN, "--integrator", "explicit", "-o",
                   self.folder / "s.ply")
        self.assertEqual(done.code, 2, done.out)
        self.assertIn("--dt", done.err)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_box_and_a_sphere_go_where_files_go(self) -> None:
        for shape, voxels in (("box(0,0,0, 0.2,0.1,0.1)", 8 * 4 * 4), ("sphere(1,2,3, 0.1)", None)):
            done = run("animate", "--shape", shape, "--voxels", 8, "--frames", 3, "--gravity",
                       "0,-9.81,0", "-o", self.folder / "b.glb", "-o", self.folder / "b.ply",
                       "--report", self.folder / "r.json")
            self.assertEqual(done.code, 0, done.err)
            report = json.loads((self.folder / "r.json").read_text())
            if voxels:
                self.assertEqual(report["voxels"], voxels)
            self.assertTrue(report["asset"]["closed"])

    def test_a_study_compares_integrators(self) -> None:
        done = run("study", "--scene", COLUMN, "--frames", 2, "--h", "2 cm", "--dt", "2 ms",
                   "--explicit-dt", "1e-4", "--folder", self.folder / "study")
        self.assertEqual(done.code, 0, done.err)
        study = json.loads((self.folder / "study" / "particles.json").read_text())
        runs = {r["name"]: r for r in study["runs"]}
        self.assertEqual(len(runs), 4)
        reference = runs[study["sub_reference"]]
        self.assertEqual(reference["to_sub"]["iou_w"], {"worst": 1, "mean": 1})
        implicit = next(r for r in study["runs"] if r["integrator"] == "implicit")
        self.assertEqual((implicit["steps"], implicit["not_converged"]), (20, 0))
        self.assertGreaterEqual(implicit["solves_a_step"], 1)
        self.assertGreater(implicit["to_sub"]["iou_w"]["worst"], 0.9)
        self.assertLess(implicit["to_sub"]["iou_w"]["worst"], 1)
        self.assertEqual(implicit["substeps"], 1)
        self.assertLess(implicit["to_explicit"]["iou_w"]["mean"], 1)
        floor = next(r for r in study["runs"] if r["substeps"] == 4 * reference["substeps"])
        self.assertGreater(floor["to_sub"]["iou_w"]["mean"], implicit["to_sub"]["iou_w"]["mean"])
        with (self.folder / "study" / "particles.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 4 * 3)
        self.assertEqual(float(rows[-1]["top [m]"]), study["runs"][-1]["frames"][-1]["top"])


    def test_without_explicit_steps_nothing_is_like_them(self) -> None:
        done = run("study", COLUMN, "--frames", 1, "--h", "2 cm", "--dt", "2 ms", "--explicit-dt",
                   "none", "--no-noise-floor", "--folder", self.folder / "study")
        self.assertEqual(done.code, 0, done.err)
        study = json.loads((self.folder / "study" / "particles.json").read_text())
        self.assertEqual(len(study["runs"]), 2)
        self.assertIsNone(study["explicit_steps_an_implicit_step"])
        for r in study["runs"]:
            self.assertEqual(r["to_explicit"]["iou_w"], {"worst": None, "mean": None})
            self.assertIsNotNone(r["to_sub"]["iou_w"]["worst"])


if __name__ == "__main__":
    unittest.main()
