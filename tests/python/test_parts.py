# SPDX-License-Identifier: Apache-2.0
"""Pins, moves and loads of parts that the asset names or paints, by the command."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import numpy as np

from command import Floats, Run, run
from painted_bar import END, write_glb_bar, write_obj_bar, write_ply_bar
from point_cache import read_pc2
from tet_mesh import lattice, write_msh

GRID = ("--h", 0.055, "--young", "200kPa", "--frames", 5, "--fps", 30, "--mesh-error", "off", "--quiet")
SOURCES = {"a.obj": (write_obj_bar, ("node:grip", "node:gr*", "colour:#ff0000", "color:#F80808")),
           "a.ply": (write_ply_bar, ("colour:#ff0000", "attr:weight>=1", "attr:_Weight>0.99")),
           "a.glb": (write_glb_bar, ("node:hand", "node:grip", "material:Rubber", "material:*ubb*",
                                     "colour:#ff0000", "attr:_MASK.y>0.99", "attr:mask.y>=1"))}


class Parts(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def play(self, name: str, *options: object, verb: str = "animate") -> Run:
        source = SOURCES[name][0](self.folder / name)
        return run(verb, source, *GRID, "-o", self.folder / "a.pc2", *options)

    def points(self, name: str, *options: object, verb: str = "animate") -> Floats:
        """(frames, points, 3)"""
        done = self.play(name, *options, verb=verb)
        self.assertEqual(done.code, 0, done.err)
        return read_pc2(self.folder / "a.pc2")

    def check_rests(self, points: Floats) -> None:
        """The vertices of the part rest to the bit, those behind it fall."""
        part = points[0, :, 0] <= END + 1e-6
        self.assertGreaterEqual(int(part.sum()), 8)
        self.assertTrue((points[:, part] == points[:1, part]).all())
        self.assertLess((points[-1, ~part] - points[0, ~part])[:, 1].max(), -1e-4)

    def test_pins_hold_what_each_format_names_and_paints(self) -> None:
        for name, (_, pins) in SOURCES.items():
            for pin in pins:
                with self.subTest(name=name, pin=pin):
                    self.check_rests(self.points(name, "--pin", pin))

    def test_finite_elements_hold_it_too(self) -> None:
        for options in ((), ("--element", "tet4"), ("--static",)):
            with self.subTest(options=options):
                points = self.points("a.glb", "--pin", "attr:mask.y>=1", *options, verb="simulate")
                self.check_rests(points)

    def test_a_part_holds_beside_a_plane_that_cuts_voxels(self) -> None:
        points = self.points("a.glb", "--pin", "material:Rubber", "--pin", "x>97%")
        held = (points[0, :, 0] <= END + 1e-6) | (points[0, :, 0] > 0.97)
        self.assertTrue((points[:, held] == points[:1, held]).all())
        self.assertLess((points[-1] - points[0])[~held, 1].max(), -1e-5)

    def test_a_part_moves_along_exactly(self) -> None:
        for verb in ("animate", "simulate"):
            points = self.points("a.obj", "--pin", "x>100%", "--move",
                                 "node:grip: shift 0:0,0,0; 0.1: 0,3cm,0", verb=verb)
            part = points[0, :, 0] <= END + 1e-6
            expected = points[0, part] + [0, 0.03, 0]
            self.assertLess(np.abs(points[-1, part] - expected).max(), 1e-8)

    def test_scene_files_name_parts(self) -> None:
        write_glb_bar(self.folder / "a.glb")
        scene = self.folder / "a.toml"
        for table in ('[[pin]]\nselect = "attr:mask.y>0.99"\n', '[[pin]]\nnode = "hand"\n',
                      '[[pin]]\ngltf_material = "Rub*"\n',
                      '[[move]]\nnode = "grip"\npath = [[0, 0, 0, 0], [1, 0, 0, 0]]\n'):
            scene.write_text('[asset]\nfile = "a.glb"\n' + table)
            done = run("animate", "--scene", scene, *GRID, "-o", self.folder / "a.pc2")
            self.assertEqual(done.code, 0, done.err)
            self.check_rests(read_pc2(self.folder / "a.pc2"))

    def test_regions_take_paint(self) -> None:
        # of a bar whose moment of weight falls as (1 - x)^2, a rigid fifth takes 1 - 0.8^4 of the sag
        options = ("--static", "--density", 10, "--pin", "x<0%")
        stiff = self.points("a.ply", *options, "--region", "attr:weight>=1: rubber,young=1GPa,density=10",
                            verb="simulate")
        soft = self.points("a.ply", *options, verb="simulate")
        end = stiff[0, :, 0] > 0.99
        sag = [float((x[0] - x[-1])[end, 1].mean()) for x in (stiff, soft)]
        self.assertLess(abs(sag[0] / sag[1] - 0.8**4), 0.05)

    def test_tetrahedra_have_the_regions_of_the_file(self) -> None:
        mesh = lattice((5, 1, 1), lambda share: share * [1, 0.2, 0.2])
        left = mesh.x[mesh.tets].mean(1)[:, 0] < END
        source = write_msh(self.folder / "a.msh", mesh, np.where(left, 7, 3).tolist())
        for pin in ("material:7", f"x<{END}"):
            done = run("simulate", source, *GRID[2:], "-o", self.folder / "a.pc2", "--pin", pin)
            self.assertEqual(done.code, 0, done.err)
            points = read_pc2(self.folder / "a.pc2")
            self.check_rests(points)
            if pin.startswith("material"):
                by_region = points
        self.assertTrue((by_region == points).all())
        for pin, says in (("material:5", "it has '3', '7'"),
                          ("node:a", "select by place or material:NUMBER")):
            done = run("simulate", source, *GRID[2:], "-o", self.folder / "a.pc2", "--pin", pin)
            self.assertEqual(done.code, 2)
            self.assertIn(says, done.err)

    def test_what_the_asset_lacks_is_refused_with_what_it_has(self) -> None:
        for name, option, says in (
                ("a.glb", ("--pin", "node:Hat"), "no node 'Hat'; it has 'grip', 'hand', 'rest'"),
                ("a.glb", ("--pin", "material:x*"), "no material 'x*'; it has 'Rubber', 'Wood'"),
                ("a.glb", ("--move", "attr:w>0: shift 0:0,0,0"), "it has '_MASK.x', '_MASK.y'"),
                ("a.obj", ("--pin", "node:hand"), "it has 'bar', 'grip', 'rest'"),
                ("a.ply", ("--pin", "attr:mask>0"), "no attribute 'mask'; it has 'weight'"),
                ("a.obj", ("--pin", "attr:mask>0"), "no attribute 'mask'; it has none"),
                ("a.ply", ("--pin", "colour:#12"), "'#12' is no #RRGGBB"),
                ("a.ply", ("--pin", "attr:weight"), "no comparison")):
            done = self.play(name, *option)
            self.assertEqual(done.code, 2, option)
            self.assertIn(says, done.err)

    def test_what_nothing_has_is_a_warning(self) -> None:
        done = self.play("a.ply", "--pin", "colour:#00ff00", "--pin", "x<0%", "--strict")
        self.assertNotEqual(done.code, 0)
        self.assertIn("--pin 'colour:#00ff00' holds nothing", done.err)


if __name__ == "__main__":
    unittest.main()
