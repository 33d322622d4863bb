# SPDX-License-Identifier: Apache-2.0
"""`simulate` on meshes of tetrahedra: closed forms, outputs, state file, refusals."""

from __future__ import annotations

import json
import re
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from command import Floats, Run, run, turned_box, write_obj
from test_simulate import EDGES, YOUNG, uniaxial
from tet_mesh import TetMesh, lattice, quadratic, write_msh, write_vtk

MATERIAL = {"young": YOUNG, "poisson": 0.3, "law": "neo-hookean", "density": 1000}
WEIGHTLESS = ("--gravity", "0,0,0")
SYMMETRY = ("--hold", "x<0%: x", "--hold", "y<0%: y", "--hold", "z<0%: z")


def bar(cells: tuple[int, int, int] = (4, 2, 2)) -> TetMesh:
    """The bar of test_simulate about the origin."""
    return lattice(cells, lambda share: (share - 0.5) * EDGES)


def cook(share: Floats) -> Floats:
    """Cook's membrane, 48 long, 44 and 16 high, 1 thick; shares to places."""
    s, t = share[:, 0], share[:, 1]
    low, high = 44 * s, 44 + 16 * s
    return np.stack([48 * s, low + t * (high - low), share[:, 2]], 1)


class Tets(unittest.TestCase):
    """A folder of its own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.state = self.folder / "run.h5"

    def simulate(self, source: Path, *options: object, output: str = "out.glb",
                 **material: object) -> Run:
        words = [word for key, value in (MATERIAL | material).items()
                 for word in (f"--{key}", value)]
        return run("simulate", source, *words, "--state", self.state, "-o",
                   self.folder / output, "--quiet", *options)

    def solved(self, source: Path, *options: object,
               **material: object) -> tuple[Floats, Floats]:
        """Rest positions and those of the last entry of a run that converged."""
        done = self.simulate(source, *options, **material)
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(self.state) as file:
            return file["grid/rest"][()], file["steps/x"][-1]

    def refused(self, done: Run, code: int, *words: str) -> None:
        self.assertEqual(done.code, code, done.err)
        for word in words:
            self.assertIn(word, done.err)


class ClosedForms(Tets):
    def test_a_bar_between_planes_of_symmetry_stretches_as_its_law_says(self) -> None:
        stress, lateral = uniaxial(1.5)
        force = f"x>100%: {stress * EDGES[1] * EDGES[2]!r},0,0"
        for mesh in (bar(), quadratic(bar())):
            for write, name in ((write_msh, "bar.msh"), (write_vtk, "bar.vtk")):
                source = write(self.folder / name, mesh)
                rest, x = self.solved(source, *WEIGHTLESS, *SYMMETRY, "--traction", force,
                                      "--static")
                np.testing.assert_array_equal(rest, mesh.x)
                lower = np.array(EDGES) / -2
                expected = lower + (rest - lower) * [1.5, lateral, lateral]
                np.testing.assert_allclose(x, expected, rtol=0, atol=1e-6 * EDGES[0])

    def test_cooks_membrane_is_that_of_the_literature(self) -> None:
        # plane stress, E = 1, nu = 1/3, load 1: the middle of the free end rises by 23.967 (mean of
        # published values on fine grids); linear at a ten-thousandth of the load
        mesh = quadratic(lattice((12, 12, 1), cook))
        source = write_msh(self.folder / "cook.msh", mesh)
        load = 1e-4 * YOUNG
        rest, x = self.solved(source, *WEIGHTLESS, "--pin", "x<0%", "--traction",
                              f"x>100%: 0,{load!r},0", "--static", poisson=1 / 3, law="stvk")
        middle = np.flatnonzero(np.all(np.abs(rest[:, :2] - [48, 52]) < 1e-9, axis=1))
        self.assertEqual(len(middle), 3)
        rise = (x - rest)[middle, 1].mean() * 1e4
        print(f"Cook's membrane, 12 x 12 x 1 cells, tet10: {rise:.3f}, published 23.967")
        self.assertAlmostEqual(rise, 23.967, delta=0.01 * 23.967)

    def test_a_hanging_bar_grows_by_half_its_weight(self) -> None:
        # nu = 0 and quadratic elements: u = rho g x (L - x/2) / E exactly, but for the large strain
        source = write_msh(self.folder / "bar.msh", quadratic(bar((4, 1, 1))))
        density, gravity = 1.0, 10.0
        rest, x = self.solved(source, "--gravity", f"{gravity},0,0", "--pin", "x<0%", "--static",
                              "--mass", "consistent", density=density, poisson=0, law="stvk")
        along = rest[:, 0] + EDGES[0] / 2
        expected = density * gravity * along * (EDGES[0] - along / 2) / YOUNG
        np.testing.assert_allclose(x[:, 0] - rest[:, 0], expected, rtol=2e-4, atol=1e-12)

    def test_regions_of_the_file_have_their_materials(self) -> None:
        # two halves in series under one force: strains are as one over the moduli
        mesh = bar((4, 1, 1))
        centre = mesh.x[mesh.tets].mean(1)[:, 0]
        groups = np.where(centre > 0, 7, 3).tolist()
        source = write_msh(self.folder / "bar.msh", mesh, groups)
        pulled = ("--traction", "x>100%: 1e-3,0,0", "--static")
        for region in ("material:7", "x>50%"):
            rest, x = self.solved(source, *WEIGHTLESS, *SYMMETRY, *pulled, "--region",
                                  f"{region}: rubber,young={YOUNG / 4},poisson=0,law=stvk",
                                  poisson=0, law="stvk")
            at = {place: (x - rest)[np.abs(rest[:, 0] - place) < 1e-9, 0].mean()
                  for place in (0, 0.2)}
            self.assertAlmostEqual((at[0.2] - at[0]) / at[0], 4, delta=1e-3)
        self.refused(self.simulate(source, "--static", "--pin", "x<0%", "--region",
                                   "material:5: foam"), 2, "'5'", "'3', '7'")
        self.refused(self.simulate(source, "--static", "--pin", "x<0%", "--region",
                                   "node:a: foam"), 2, "no nodes with names")


def last_frame(path: Path) -> tuple[Floats, Floats]:
    """Points of a PC2 file at rest and in its last frame."""
    raw = path.read_bytes()
    count, frames = (np.frombuffer(raw[at:at + 4], np.int32)[0] for at in (16, 28))
    points = np.frombuffer(raw[32:], np.float32).reshape(frames, count, 3)
    return points[0].astype(float), points[-1].astype(float)


class Borders(Tets):
    """A bar 1 x 0.2 x 0.2 m of 21 x 4 x 4 cells, whose nodes lie on none of the borders."""

    LINEAR = lattice((21, 4, 4), lambda share: share * [1, 0.2, 0.2])
    PINS = ("--pin", "x<1%", "--pin", "x>99%")

    def frames(self, mesh: TetMesh, *options: object, **material: object) -> tuple[Floats, Floats]:
        """Points of the surface at rest and in the last frame."""
        source = write_msh(self.folder / "bar.msh", mesh)
        done = self.simulate(source, *options, output="out.pc2", **material)
        self.assertEqual(done.code, 0, done.err)
        self.assertNotIn("--pin", done.err)
        return last_frame(self.folder / "out.pc2")

    def test_reactions_carry_the_weight_of_what_is_free(self) -> None:
        report = self.folder / "a.json"
        weight = 0.98 * 0.2 * 0.2 * 1000 * 9.81
        for mesh in (self.LINEAR, quadratic(self.LINEAR)):
            for options in (("--static",), ("--time-scheme", "euler", "--substeps", 1, "--frames", 40)):
                rest, x = self.frames(mesh, *self.PINS, "--report", report, *options, young="10MPa")
                held = (rest[:, 0] < 0.01) | (rest[:, 0] > 0.99)
                np.testing.assert_array_equal(x[held], rest[held])
                self.assertLess((x - rest)[:, 1].min(), -1e-4)
                left, right = (np.array(r["force"])
                               for r in json.loads(report.read_text())["reactions"])
                self.assertLess(abs((left + right)[1] / weight - 1), 1e-3)
                self.assertLess(abs(left[1] / right[1] - 1), 0.02)

    def test_an_end_arrives_where_its_move_ends(self) -> None:
        for mesh in (self.LINEAR, quadratic(self.LINEAR)):
            for path, expected in (
                    ("shift 0:0,0,0; 1:1m,0,0", lambda p: p + [1, 0, 0]),
                    ("turn(50%,50%,50%,1,0,0) 0:0; 1:90deg",
                     lambda p: np.stack([p[:, 0], 0.2 - p[:, 2], p[:, 1]], 1))):
                rest, x = self.frames(mesh, *WEIGHTLESS, "--static", "--pin", "x<1%", "--move",
                                      f"x>99%: {path}", young="1MPa")
                right, left = rest[:, 0] > 0.99, rest[:, 0] < 0.01
                np.testing.assert_allclose(x[right], expected(rest[right]), rtol=0, atol=2e-7)
                np.testing.assert_array_equal(x[left], rest[left])

    def test_a_pin_beside_the_body_changes_nothing(self) -> None:
        source = write_msh(self.folder / "bar.msh", self.LINEAR)
        options = ("--time-scheme", "euler", "--frames", 2)
        _, free = self.solved(source, *options)
        done = self.simulate(source, "--pin", "x<-5%", *options)
        self.assertEqual(done.code, 0, done.err)
        self.assertIn("holds nothing", done.err)
        with h5py.File(self.state) as file:
            np.testing.assert_array_equal(file["steps/x"][-1], free)

    def test_balls_and_boxes_hold_as_those_of_hexahedra_do(self) -> None:
        voxels = write_obj(self.folder / "bar.obj", *turned_box((1, 0.2, 0.2), (0, 0, 1), 0))
        for pin in ("sphere(50%,50%,50%,0.09m)", "box(40%,-1%,-1%,61%,55%,101%)"):
            hang = []
            for source in (voxels, write_msh(self.folder / "bar.msh", quadratic(self.LINEAR))):
                named = ("--element", "hex-bbar", "--h", 0.025) if source == voxels else ()
                done = self.simulate(source, *named, "--pin", pin, "--static", output="out.pc2",
                                     young="10MPa")
                self.assertEqual(done.code, 0, done.err)
                rest, x = last_frame(self.folder / "out.pc2")
                hang.append([(x - rest)[np.abs(rest[:, 0] - end) < 1e-6, 1].mean()
                             for end in (rest[:, 0].min(), rest[:, 0].max())])
            self.assertLess(max(hang[0]), -1e-3)
            np.testing.assert_allclose(hang[1], hang[0], rtol=0.02 if "sphere" in pin else 0.07)


class Outputs(Tets):
    MOVE = ("--pin", "x<0%", "--move", "x>100%: shift 0:0,0,0; 0.1:0,3cm,0", "--frames", 4,
            "--fps", 40, "--substeps", 1)

    def test_the_state_file_has_the_tetrahedra_as_they_are(self) -> None:
        for mesh, element in ((bar(), "tet4"), (quadratic(bar()), "tet10")):
            source = write_msh(self.folder / "bar.msh", mesh)
            done = self.simulate(source, *self.MOVE, "--report", self.folder / "report.json")
            self.assertEqual(done.code, 0, done.err)
            with h5py.File(self.state) as file:
                self.assertEqual(file.attrs["element"], element.encode())
                self.assertAlmostEqual(file.attrs["h"], 0.1, places=12)  # of the cells
                grid = file["grid"]
                self.assertEqual(set(grid), {"rest", "corners", "mass", "pinned", "material",
                                             "fixed"})
                np.testing.assert_array_equal(grid["corners"][()], mesh.tets)
                np.testing.assert_array_equal(grid["rest"][()], mesh.x)
                mass = 1000 * np.prod(EDGES)
                self.assertAlmostEqual(grid["mass"][()].sum(), mass, delta=1e-12 * mass)
                near, far = mesh.x[:, 0] < -0.2 + 1e-9, mesh.x[:, 0] > 0.2 - 1e-9
                np.testing.assert_array_equal(grid["pinned"][()].ravel(), near | far)
                x = file["steps/x"][()]
                np.testing.assert_allclose(x[-1, far] - mesh.x[far],
                                           np.tile([0, 0.03, 0], (far.sum(), 1)), atol=1e-15)
            report = json.loads((self.folder / "report.json").read_text())
            self.assertEqual(report["nodes"], len(mesh.x))

    def test_the_animated_mesh_is_the_surface(self) -> None:
        mesh = quadratic(bar())
        source = write_vtk(self.folder / "bar.vtk", mesh)
        done = self.simulate(source, *self.MOVE, output="out.ply")
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(self.state) as file:
            x = file["steps/x"][-1]
        data = (self.folder / "out_00004.ply").read_bytes()
        head, body = data.split(b"end_header\n", 1)
        found = re.search(rb"element vertex (\d+)\n((?:property .*\n)+?)element face (\d+)", head)
        assert found is not None
        vertices, faces = int(found[1]), int(found[3])
        outer = np.any(np.abs(np.abs(mesh.x) - np.array(EDGES) / 2) < 1e-9, axis=1)
        self.assertEqual((vertices, faces), (outer.sum(), 4 * 4 * (4 * 2 + 2 * 2 + 2 * 4)))
        floats = found[2].count(b"property float")
        self.assertEqual(found[2].count(b"property"), floats)
        own = np.frombuffer(body, "<f4", vertices * floats).reshape(vertices, floats)[:, :3]
        np.testing.assert_allclose(own, x[outer], atol=1e-7)

    def test_other_outputs_are_written(self) -> None:
        source = write_msh(self.folder / "bar.msh", bar())
        for name in ("out.glb", "out.pc2", "out.pvd"):
            done = self.simulate(source, *self.MOVE, output=name)
            self.assertEqual(done.code, 0, done.err)
            self.assertGreater((self.folder / name).stat().st_size, 100)
        frame = (self.folder / "out_00004.vtu").read_bytes()
        self.assertIn(b'NumberOfPoints="45" NumberOfCells="96"', frame)
        # the written file is read again, as tetrahedra
        done = self.simulate(self.folder / "out_00004.vtu", "--static", "--pin", "x<0%",
                             output="again.glb")
        self.assertEqual(done.code, 0, done.err)

    def test_a_body_comes_to_rest_on_a_floor(self) -> None:
        for mesh in (bar(), quadratic(bar((2, 1, 1)))):
            source = write_msh(self.folder / "bar.msh", mesh)
            done = self.simulate(source, "--up", "z", "--floor", "--frames", 30, young=1e6)
            self.assertEqual(done.code, 0, done.err)
            with h5py.File(self.state) as file:
                x, v, layer = file["steps/x"][-1], file["steps/v"][-1], file["contact"].attrs["layer"]
                contact = file["contact"]
                self.assertEqual(contact["nodes"].shape, contact["area"].shape)
                surface = 2 * (EDGES[0] * EDGES[1] + EDGES[1] * EDGES[2] + EDGES[2] * EDGES[0])
                self.assertAlmostEqual(contact["area"][()].sum(), surface, delta=1e-12)
            self.assertGreater(x[:, 2].min(), -EDGES[2] / 2 - layer)
            self.assertLess(x[:, 2].min(), -EDGES[2] / 2)
            self.assertLess(np.abs(v).max(), 0.02)

    def test_sizes_scale_the_whole_mesh(self) -> None:
        source = write_msh(self.folder / "bar.msh", bar())
        rest, _ = self.solved(source, "--size", "80cm", "--pin", "x<0%", "--static")
        np.testing.assert_allclose(rest, 2 * bar().x, rtol=1e-14)


class Refusals(Tets):
    def test_damaged_files_are_named_with_their_place(self) -> None:
        text = write_msh(self.folder / "bar.msh", bar()).read_text()
        broken = self.folder / "broken.msh"
        hexahedron = "1 5 2 1 1 1 2 3 4 5 6 7 8"
        for change, words in (
                (lambda t: t.replace("$EndElements", ""), ("broken.msh:",)),
                (lambda t: t.replace("\n3 -0.2", "\n3 nan", 1), ("broken.msh:8:", "coordinate")),
                (lambda t: re.sub(r"\n1 4 2 1 1 .*", "\n" + hexahedron, t), ("broken.msh:54:",)),
                (lambda t: t[:200], ("broken.msh:",)), (lambda t: "", ("broken.msh",))):
            broken.write_text(change(text))
            self.assertNotEqual(broken.read_text(), text)
            self.refused(self.simulate(broken, "--static", "--pin", "x<0%"), 3, *words)
        self.refused(self.simulate(self.folder / "none.vtu", "--static", "--pin", "x<0%"), 3, "none.vtu")

    def test_a_middle_that_turns_its_element_over_is_refused(self) -> None:
        mesh = quadratic(bar((1, 1, 1)))
        mesh.x[mesh.tets[2, 4]] += 2 * EDGES[0]  # far beyond the ends of its edge
        source = write_msh(self.folder / "bent.msh", mesh)
        self.refused(self.simulate(source, "--static", "--pin", "x<0%"), 3, "bent.msh: ",
                     "element ")

    def test_a_resolution_means_nothing_and_a_warning_says_so(self) -> None:
        source, held = write_msh(self.folder / "bar.msh", bar()), ("--static", "--pin", "x<0%")
        self.assertNotIn("mean nothing", self.simulate(source, *held).err)
        for option in (("--h", 0.1), ("--voxels", 48)):
            done = self.simulate(source, *held, *option)
            self.assertEqual(done.code, 0, done.err)
            self.assertIn(f"warning: --voxels and --h mean nothing: {source} has", done.err)
            self.refused(self.simulate(source, *held, *option, "--strict"), 2, "mean nothing")
        resolved = run("simulate", source, *held, "-o", self.folder / "a.glb", "--print-resolved")
        scene = self.folder / "again.json"
        scene.write_text(resolved.out)
        again = run("simulate", "--scene", scene, "--static", "--quiet")
        self.assertEqual(again.code, 0, again.err)
        self.assertNotIn("mean nothing", again.err)

    def test_an_element_that_the_file_does_not_have_is_refused(self) -> None:
        linear = write_msh(self.folder / "linear.msh", bar())
        curved = write_msh(self.folder / "curved.msh", quadratic(bar((2, 1, 1))))
        held = ("--static", "--pin", "x<0%")
        for element in ("voxel", "hex", "tet10", "tet10-bbar"):
            self.refused(self.simulate(linear, "--element", element, *held), 2,
                         f"--element {element}", "linear.msh", "tet4")
        self.refused(self.simulate(curved, "--element", "tet4", *held), 2, "tet10 or tet10-bbar")
        for source, element in ((linear, "tet4"), (curved, "tet10"), (curved, "tet10-bbar")):
            done = self.simulate(source, "--element", element, *held)
            self.assertEqual(done.code, 0, done.err)
            with h5py.File(self.state) as file:
                self.assertEqual(file.attrs["element"], element.encode())

    def test_the_network_says_who_takes_them(self) -> None:
        source = write_msh(self.folder / "bar.msh", bar())
        self.refused(run("animate", source, "-o", self.folder / "a.glb"), 3, "simulate")

    def test_a_selection_without_nodes_is_a_warning(self) -> None:
        source = write_msh(self.folder / "bar.msh", bar())
        done = self.simulate(source, "--static", "--pin", "x<0%", "--pin", "y>9")
        self.assertEqual(done.code, 0, done.err)
        self.assertIn("--pin 'y>9' holds nothing", done.err)


if __name__ == "__main__":
    unittest.main()
