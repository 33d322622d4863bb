# SPDX-License-Identifier: Apache-2.0
"""What runs of particles write: points, surfaces, volumes, state, and what is refused."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from command import Run, run
from particle_files import enclosed_volume, is_closed, read_obj, read_ply, read_state, read_vtu
from test_particles import EDGE, write_cube
from test_pictures import read_png, write_png

G = 9.81
COUNT = 8 ** 3 * 8  # particles of the cube at 8 voxels
SAND = ("--material", "sand", "--voxels", 8, "--quiet")


class Files(unittest.TestCase):
    """Of a cube of sand, red where x < 0 and blue elsewhere, that falls on a floor below it."""

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.cube = write_cube(cls.folder / "cube.obj")
        cls.done = cls.animate("s", *(f"s.{e}" for e in ("ply", "mesh.ply", "obj", "vdb", "pvd", "pc2")))
        cls.last = cls.folder / "s_00006.ply"

    @classmethod
    def animate(cls, name: str, *outputs: str, options: tuple[object, ...] = ()) -> Run:
        """10 cm above the floor, which is reached after 0.14 s, in frames of 1/30 s."""
        words = [word for output in outputs for word in ("-o", cls.folder / output)]
        return run("animate", cls.cube, *SAND, "--floor", "y=-0.1m", "--frames", 6, *words, "--state",
                   cls.folder / f"{name}.h5", "--report", cls.folder / f"{name}.json", *options)

    def test_every_output_is_there_once_a_frame(self) -> None:
        self.assertEqual(self.done.code, 0, self.done.err)
        for pattern in ("s_*.ply", "s.mesh_*.ply", "s_*.obj", "s_*.vdb", "s_*.vtu"):
            self.assertEqual(len(list(self.folder.glob(pattern))), 7, pattern)
        for name in ("s.pvd", "s.pc2", "s.h5", "s.json"):
            self.assertTrue((self.folder / name).is_file(), name)

    def test_state_keeps_mass_and_momentum(self) -> None:
        state = read_state(self.folder / "s.h5")
        mass, volume = state["particles/mass"], state["particles/volume"]
        density = state["materials"]["density"][0]
        self.assertEqual(len(mass), COUNT)
        self.assertAlmostEqual(volume.sum() / EDGE ** 3, 1, 12)
        self.assertTrue(np.allclose(mass, density * volume, rtol=1e-13))
        np.testing.assert_array_equal(state["gravity"], [0, -G, 0])
        self.assertAlmostEqual(state["h"], EDGE / 8, 12)
        # free fall until the floor is near, in exact arithmetic
        time, x, v = state["steps/time"], state["particles/x"], state["particles/v"]
        lowest = x[:, :, 1].min(axis=1)
        free = lowest > -0.1 + 2 * state["h"]
        self.assertGreater(free.sum(), 20)
        whole = mass.sum()
        momentum = np.einsum("p,tpk->tk", mass, v)
        for t in np.flatnonzero(free):
            np.testing.assert_allclose(momentum[t], [0, -whole * G * time[t], 0], atol=1e-9 * whole * G)
        # about the middle nothing turns, also not with the affine part
        h, C = state["h"], state["particles/C"].reshape(*v.shape[:2], 3, 3)
        middle = np.einsum("p,tpk->tk", mass, x)[:, None] / whole
        spin = np.cross(x - middle, v) + h ** 2 / 4 * np.stack(
            [C[..., 2, 1] - C[..., 1, 2], C[..., 0, 2] - C[..., 2, 0], C[..., 1, 0] - C[..., 0, 1]], -1)
        angular = np.einsum("p,tpk->tk", mass, spin)
        self.assertLess(np.abs(angular[free]).max(), 1e-9 * whole * G * EDGE)
        # energies of the steps are those of the particles
        kinetic = ((v ** 2).sum(-1) + h ** 2 / 4 * (C ** 2).sum((-1, -2))) @ mass / 2
        np.testing.assert_allclose(state["steps/energy_kinetic"], kinetic[1:], rtol=1e-10)
        np.testing.assert_allclose(state["steps/energy_gravity"], (x[1:, :, 1] @ mass) * G, rtol=1e-10)
        self.assertTrue((np.diff((kinetic + (x[:, :, 1] @ mass) * G)) < 1e-9 * whole * G * EDGE).all())

    def test_points_say_what_the_state_says(self) -> None:
        state, points = read_state(self.folder / "s.h5"), read_ply(self.last)
        F = state["particles/F"][-1].reshape(-1, 3, 3)
        J = np.linalg.det(F)
        self.assertGreater(np.ptp(J), 1e-5)  # the floor has been felt
        np.testing.assert_allclose(points.column["J"], J, rtol=1e-6)
        np.testing.assert_allclose(points.v, state["particles/v"][-1], atol=1e-6)
        np.testing.assert_allclose(points.x, state["particles/x"][-1], atol=1e-6)
        np.testing.assert_allclose(points.column["memory"], state["particles/memory"][-1], atol=1e-7)
        self.assertTrue((points.column["material"] == 0).all())
        self.assertAlmostEqual(J.min(), state["steps/min_j"][-1], 12)

    def test_vtu_has_the_stress_of_the_law(self) -> None:
        state, points = read_state(self.folder / "s.h5"), read_ply(self.last)
        vtu = read_vtu(self.folder / "s_00006.vtu")
        np.testing.assert_array_equal(vtu["Points"], points.x.astype(np.float32))
        np.testing.assert_array_equal(vtu["velocity"], points.v.astype(np.float32))
        np.testing.assert_array_equal(vtu["J"], points.column["J"])
        self.assertTrue((vtu["types"] == 1).all() and len(vtu["types"]) == COUNT)
        # Hencky's law of the elastic strain that is left: tau = 2 mu ln(b)/2 + lambda tr
        young, nu = (state["materials"][c][0] for c in ("young", "poisson"))
        mu, lam = young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))
        F = state["particles/F"][-1].reshape(-1, 3, 3)
        value, axes = np.linalg.eigh(F @ F.transpose(0, 2, 1))
        e = np.log(value) / 2
        tau = axes * (2 * mu * e + lam * e.sum(1, keepdims=True))[:, None] @ axes.transpose(0, 2, 1)
        wanted = np.stack([tau[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))], 1)
        self.assertGreater(np.abs(wanted).max(), 100)
        np.testing.assert_allclose(vtu["kirchhoff_stress"], wanted, atol=1e-5 * np.abs(wanted).max())
        times = [float(line.split('"')[1]) for line in (self.folder / "s.pvd").read_text().splitlines()
                 if line.startswith("<DataSet")]
        np.testing.assert_allclose(times, np.arange(7) / 30, atol=1e-12)

    def test_surfaces_are_closed_and_enclose_the_sand(self) -> None:
        for frame in (0, 3, 6):
            x, colour, triangles = read_obj(self.folder / f"s_{frame:05}.obj")
            self.assertTrue(is_closed(triangles))
            share = enclosed_volume(x, triangles) / EDGE ** 3
            self.assertLess(abs(share - 1), 0.02, f"frame {frame}: {share}")
            points = read_ply(self.folder / f"s_{frame:05}.ply").x
            reach = EDGE / 8
            self.assertTrue((x.min(0) > points.min(0) - reach).all())
            self.assertTrue((x.max(0) < points.max(0) + reach).all())
            mesh = read_ply(self.folder / f"s.mesh_{frame:05}.ply")
            np.testing.assert_array_equal(mesh.triangles, triangles)
            np.testing.assert_allclose(mesh.x, x, atol=1e-7)
            np.testing.assert_allclose(mesh.colour, 255 * colour, atol=0.6)
        # the colours of the two halves
        at_start, colour, _ = read_obj(self.folder / "s_00000.obj")
        away = np.abs(at_start[:, 0]) > EDGE / 8
        np.testing.assert_array_equal(colour[away, 0] > 0.9, at_start[away, 0] < 0)
        np.testing.assert_array_equal(colour[away, 2] > 0.9, at_start[away, 0] > 0)

    def test_volumes_are_read_as_bodies_of_that_volume(self) -> None:
        for grid in ("surface", "density"):
            again = self.folder / f"{grid}.json"
            done = run("animate", self.folder / "s_00000.vdb", "--grid", grid, "--voxels", 24, "--frames",
                       1, "--gravity", "0,0,0", "--density", 1, "--quiet", "--state",
                       self.folder / f"{grid}.h5", "-o", self.folder / f"{grid}.pc2", "--report", again)
            self.assertEqual(done.code, 0, done.err)
            self.assertTrue(json.loads(again.read_text())["asset"]["closed"])
            with h5py.File(self.folder / f"{grid}.h5") as file:
                mass = file["grid/mass"][()].sum()
            self.assertLess(abs(mass / EDGE ** 3 - 1), 0.02, grid)

    def test_files_are_the_same_on_one_thread(self) -> None:
        done = self.animate("t", *(f"t.{e}" for e in ("ply", "obj", "vdb", "pvd")), options=("--threads", 1))
        self.assertEqual(done.code, 0, done.err)
        for ending in ("ply", "obj", "vtu"):
            first, second = (self.folder / f"{n}_00006.{ending}" for n in "st")
            self.assertEqual(first.read_bytes(), second.read_bytes(), ending)

    def test_sizes_and_axes_are_those_of_the_asset(self) -> None:
        done = run("animate", self.cube, *SAND, "--size", "0.5m", "--up", "z", "--frames", 2, "-o",
                   self.folder / "z.ply", "-o", self.folder / "z.obj", "--floor")
        self.assertEqual(done.code, 0, done.err)
        points = read_ply(self.folder / "z_00002.ply")
        self.assertLess(abs(np.ptp(read_ply(self.folder / "z_00000.ply").x[:, 0]) - EDGE), 0.1 * EDGE)
        self.assertLess(points.v[:, 2].mean(), 0)
        # as fast as without --size, in an asset two and a half times as large
        self.assertLess(points.v[:, 2].min(), -0.3 * G / 15 * EDGE / 0.5)
        self.assertGreater(points.v[:, 2].min(), -1.1 * G / 15 * EDGE / 0.5)
        x, _, triangles = read_obj(self.folder / "z_00000.obj")
        self.assertLess(abs(enclosed_volume(x, triangles) / EDGE ** 3 - 1), 0.02)


class Colours(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def first_frame(self, asset: Path, *options: object) -> tuple[np.ndarray, np.ndarray]:
        """Places and colours of the particles at the start."""
        done = run("animate", asset, *SAND, "--frames", 1, "-o", self.folder / "c.ply", *options)
        self.assertEqual(done.code, 0, done.err)
        points = read_ply(self.folder / "c_00000.ply")
        return points.x, points.colour

    def write_textured(self, texture: str) -> Path:
        """A cube whose sides show an image, red to the left and green to the right."""
        lines = ["mtllib t.mtl"]
        for y in (0, 0.2):
            lines += [f"v {x} {y} {z}" for x, z in ((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1))]
        lines += ["vt 0.1 0", "vt 0.9 0", "usemtl skin"]
        u = {0: 1, 1: 2, 2: 2, 3: 1}
        for face in ((0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)):
            lines.append("f " + " ".join(f"{k + 1}/{u[k % 4]}" for k in face))
        asset = self.folder / "t.obj"
        asset.write_text("\n".join(lines) + "\n")
        asset.with_suffix(".mtl").write_text(f"newmtl skin\nKd 1 1 1\nmap_Kd {texture}\n")
        return asset

    def test_of_a_texture_are_those_of_its_places(self) -> None:
        pixels = np.zeros((16, 16, 3), np.uint8)
        pixels[:, :8, 0] = pixels[:, 8:, 1] = 255
        write_png(self.folder / "t.png", pixels)
        x, colour = self.first_frame(self.write_textured("t.png"))
        away = np.abs(x[:, 0]) > 0.03  # but for the seam, which is blurred
        np.testing.assert_array_equal(colour[away, 0] > 200, x[away, 0] < 0)
        np.testing.assert_array_equal(colour[away, 1] > 200, x[away, 0] > 0)

    def test_a_texture_that_cannot_be_shown_is_a_note(self) -> None:
        (self.folder / "t.png").write_bytes(b"\x89PNG\r\n\x1a\nbroken")
        report = self.folder / "r.json"
        _, colour = self.first_frame(self.write_textured("t.png"), "--report", report)
        self.assertTrue((colour == 255).all())
        self.assertTrue(any("t.png" in note for note in json.loads(report.read_text())["notes"]))

    def test_of_a_cloud_and_of_splats_are_those_of_the_nearest(self) -> None:
        n = 4000
        k = np.arange(n) + 0.5
        z, turn = 1 - 2 * k / n, 2.39996323 * k
        r = np.sqrt(1 - z * z)
        ball = 0.1 * np.column_stack([r * np.cos(turn), z, r * np.sin(turn)])
        left = ball[:, 0] < 0
        cloud = self.folder / "cloud.xyz"
        cloud.write_text("\n".join(
            f"{a:.6f} {b:.6f} {c:.6f} {255 * s} 0 {255 * (1 - s)}" for (a, b, c), s in zip(ball, left.astype(int))))
        splats = self.folder / "splats.ply"
        names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                 "rot_0", "rot_1", "rot_2", "rot_3"]
        bright = 0.5 / 0.28209479177387814
        rows = np.column_stack([ball, np.where(left, bright, -bright), np.full(n, -bright),
                                np.where(left, -bright, bright), np.full(n, 3.0),
                                np.full((n, 3), np.log(0.004)), np.tile([1, 0, 0, 0], (n, 1))])
        splats.write_bytes(("ply\nformat binary_little_endian 1.0\nelement vertex " + f"{n}\n" + "".join(
            f"property float {name}\n" for name in names) + "end_header\n").encode()
            + rows.astype("<f4").tobytes())
        for asset in (cloud, splats):
            x, colour = self.first_frame(asset)
            away = np.abs(x[:, 0]) > 0.02
            np.testing.assert_array_equal(colour[away, 0] > 200, x[away, 0] < 0, asset.name)
            np.testing.assert_array_equal(colour[away, 2] > 200, x[away, 0] > 0, asset.name)


    def test_a_picture_shows_all_of_the_sand(self) -> None:
        cube = write_cube(self.folder / "cube.obj")
        done = run("animate", cube, "--material", "sand", "--voxels", 6, "--frames", 1, "--quiet", "-o",
                   self.folder / "p_%d.png")
        self.assertEqual(done.code, 0, done.err)
        picture = read_png(self.folder / "p_0.png").astype(int)
        red = (picture[..., 0] > 200) & (picture[..., 2] < 50)
        blue = (picture[..., 2] > 200) & (picture[..., 0] < 50)
        for colour in (red, blue):
            self.assertGreater(colour.mean(), 0.05)
            rim = np.concatenate([colour[0], colour[-1], colour[:, 0], colour[:, -1]])
            self.assertFalse(rim.any())


class Limits(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.cube = write_cube(self.folder / "cube.obj")
        self.before = set(self.folder.iterdir())

    def animate(self, output: str, *options: object, frames: int = 1) -> Run:
        return run("animate", self.cube, "--material", "sand", "--voxels", 8, "--frames", frames, "-o",
                   self.folder / output, "--state", self.folder / "s.h5", *options)

    def expect_nothing_written(self) -> None:
        self.assertEqual(set(self.folder.iterdir()), self.before)

    def test_what_cannot_show_particles_is_said_before_the_first_step(self) -> None:
        done = self.animate("p.glb", "--floor")
        self.assertEqual(done.code, 2, done.out)
        for ending in (".ply", ".mesh.ply", ".obj", ".vdb", ".pvd", ".pc2"):
            self.assertIn("p" + ending, done.err)
        self.expect_nothing_written()

    def test_a_surface_of_what_is_no_sand_is_refused(self) -> None:
        for ending in ("obj", "vdb"):
            done = run("animate", self.cube, "--voxels", 8, "--frames", 1, "--floor", "-o",
                       self.folder / f"r.{ending}")
            self.assertEqual(done.code, 2, done.out)
            self.assertIn("particles", done.err)
        self.expect_nothing_written()

    def test_a_surface_of_particles_in_the_plane_is_refused(self) -> None:
        for ending in ("obj", "vdb", "mesh.ply"):
            done = run("animate", "--shape", "rectangle(0,0,0, 0.1,0.1,0)", "--h", "1cm", "--material",
                       "sand", "--frames", 1, "--floor", "-o", self.folder / f"r.{ending}")
            self.assertEqual(done.code, 2, done.out)
            self.assertIn("in the plane have no surface", done.err)
        self.expect_nothing_written()

    def test_memory_that_is_not_there_is_refused_before_it_is_taken(self) -> None:
        done = self.animate("p.ply", "--floor", "--max-memory", "2 MB")
        self.assertEqual(done.code, 6, done.out)
        self.assertIn("would fit", done.err)
        self.expect_nothing_written()

    def test_strict_stops_at_a_warning(self) -> None:
        done = self.animate("p.ply", "--strict")  # nothing holds it
        self.assertEqual(done.code, 2, done.out)
        self.assertIn("--strict", done.err)
        self.expect_nothing_written()
        self.assertEqual(self.animate("p.ply", "--floor", "--strict").code, 0)

    def test_time_that_is_over_leaves_whole_frames(self) -> None:
        report = self.folder / "r.json"
        done = self.animate("p.ply", "--floor", "-o", self.folder / "p.obj", "--max-time", "1s",
                            "--report", report, frames=500)
        self.assertEqual(done.code, 4, done.out)
        self.assertIn("--max-time reached", done.err)
        frames = json.loads(report.read_text())["frames"]
        self.assertLess(frames, 500)
        for ending in ("ply", "obj"):
            files = sorted(self.folder.glob(f"p_*.{ending}"))
            self.assertEqual([f.name for f in files],
                             [f"p_{k:05}.{ending}" for k in range(frames + 1)])
        self.assertEqual(len(read_ply(self.folder / f"p_{frames:05}.ply").x), COUNT)
        self.assertTrue(is_closed(read_obj(self.folder / f"p_{frames:05}.obj")[2]))
        state = read_state(self.folder / "s.h5")
        self.assertEqual(len(state["steps/time"]) - 1, json.loads(report.read_text())["steps"])

    def test_nothing_is_said_of_the_mesh_that_is_not_shown(self) -> None:
        # corners with several normals have no place in a PLY of the mesh
        text = self.cube.read_text().splitlines()
        normals = ["vn 1 0 0", "vn 0 1 0", "vn 0 0 1"]
        faces = [line if not line.startswith("f ") else
                 "f " + " ".join(f"{w}//{1 + k % 3}" for w in line.split()[1:])
                 for k, line in enumerate(text)]
        self.cube.write_text("\n".join(normals + faces) + "\n")
        self.assertIn("corner-normals", run("animate", self.cube, "--voxels", 8, "--frames", 1, "--floor",
                                            "-o", self.folder / "m.ply").err)
        done = self.animate("p.ply", "--floor")
        self.assertEqual(done.code, 0, done.err)
        self.assertNotIn("corner-normals", done.out + done.err)

    def test_the_damping_that_is_said_is_that_of_its_parts(self) -> None:
        # 1/30 s in 8 steps of 1/240 s, each of three parts; Euler keeps (1 + (w dt)^2)^(-1/2) a step
        done = self.animate("p.ply", "--floor")
        part = 1 / 240 / 3
        self.assertIn(f"in parts of {part:.4g} s", done.out)
        kept = []
        for f in (1, 5, 20):
            turn = 2 * np.pi * f * part
            kept.append(f"{100 * (1 + turn ** 2) ** (-np.pi / np.arctan(turn)):.0f} %")
        self.assertIn(" / ".join(kept), done.out)


if __name__ == "__main__":
    unittest.main()
