# SPDX-License-Identifier: Apache-2.0
"""Scene files and the verbs that end before a simulation: exit codes, shapes of their JSON."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np

from command import (Run, animate, glb_bytes, glb_parts, run, turned_box, write_obj, write_stl)
from glb_file import local_positions, read_document, world_positions

BOX = turned_box((0.3, 0.12, 0.1), (0, 0, 1), 0)
DOCS = Path(__file__).parents[2] / "docs"

SCENE = """
pins = ["x<10%"]
[asset]
file = "box.obj"
voxels = 8
[material]
young = "100 kPa"
[time]
frames = 3
substeps = 1
[output]
quiet = true
"""


class Verbs(unittest.TestCase):
    """A folder of its own, with a box in it."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.source = write_obj(self.folder / "box.obj", *BOX)

    def scene(self, text: str = SCENE, name: str = "scene.toml") -> Path:
        path = self.folder / name
        path.write_text(text)
        return path

    def printed(self, *words: object, code: int = 0) -> Any:
        """The JSON that a run prints."""
        done = run(*words)
        self.assertEqual(done.code, code, done.err)
        return json.loads(done.out)

    def refused(self, done: Run, code: int, *words: str) -> None:
        self.assertEqual(done.code, code, done.err)
        for word in words:
            self.assertIn(word, done.err)


class Scenes(Verbs):
    """animate --scene."""

    def test_a_scene_is_the_options_that_it_stands_for(self) -> None:
        by_scene, by_options = self.folder / "a.glb", self.folder / "b.glb"
        done = run("animate", "--scene", self.scene(), "-o", by_scene)
        self.assertEqual(done.code, 0, done.err)
        done = animate(self.source, by_options, "--voxels", 8, "--frames", 3, "--substeps", 1,
                       "--young", "1e5", "--pin", "x<10%")
        self.assertEqual(done.code, 0, done.err)
        documents = [read_document(path) for path in (by_scene, by_options)]
        for document in documents:
            del document.json["asset"]["extras"]["elastogen"]["command"]
        self.assertEqual(documents[0], documents[1])

    def test_the_resolved_scene_is_a_fixed_point(self) -> None:
        words = ("--frames", 7, "--velocity", "1,0,0 km/h", "--max-memory", "2GB", "--floor",
                 "y=-1m", "--print-resolved")
        first = self.printed("animate", "--scene", self.scene(), *words)
        self.assertEqual(first["asset"]["file"], str(self.source))
        self.assertEqual(first["time"]["frames"], 7)
        self.assertEqual(first["motion"]["velocity"], [1 / 3.6, 0, 0])
        self.assertEqual(first["limits"]["max_memory"], 2e9)
        self.assertEqual(first["floor"]["place"], -1)
        again = self.scene(json.dumps(first), "again.json")
        self.assertEqual(self.printed("animate", "--scene", again, "--print-resolved"), first)
        self.assertEqual(self.printed("inspect", again, "--print-resolved"), first)
        self.assertEqual({path.name for path in self.folder.iterdir()},
                         {"box.obj", "scene.toml", "again.json"})

    def test_what_a_scene_gets_wrong_is_named(self) -> None:
        for text, words in (("[asset]\nfil = 'a'\n", ("scene.toml:2", "asset.fil", "asset.file")),
                            ("[time]\nfps = 3\nfps = 4\n", ("scene.toml", "fps")),
                            ("[time]\nfps = nan\n", ("scene.toml:2", "finite")),
                            ("[material]\nyoung = '3 kg'\n", ("scene.toml:2", "kg", "Pa"))):
            done = run("animate", self.source, "--scene", self.scene(text), "-o", "never.glb")
            self.refused(done, 2, *words)
        self.refused(run("animate", "--scene", self.folder / "no.toml", "-o", "n.glb"), 2, "no.toml")
        self.refused(run("animate", "--scene", self.scene("")), 2, "INPUT")

    def test_schema_describes_the_resolved_scene(self) -> None:
        schema = self.printed("inspect", "--schema")
        self.assertEqual(schema, json.loads((DOCS / "scene.schema.json").read_text()))
        resolved = self.printed("animate", "--scene", self.scene(), "--print-resolved")
        of_yield = {"yield", "hardening", "friction_angle", "cohesion", "keeps_volume"}  # if it yields
        for key, value in resolved.items():
            known = schema["properties"][key]
            if known.get("type") == "object":
                left_out = of_yield if key == "material" else set()
                self.assertEqual(set(value), set(known["properties"]) - left_out, key)
        damped = self.printed("animate", "--scene", self.scene(), "--damping", "0.1", "--print-resolved")
        self.assertEqual(damped["material"]["damping"], 0.1)
        sand = self.printed("animate", "--scene", self.scene(), "--material", "sand", "--print-resolved")
        self.assertEqual(set(sand["material"]) & of_yield,
                         {"friction_angle", "cohesion", "keeps_volume"})


class Up(Verbs):
    """--up and --size that are guessed."""

    def fallen(self, source: Path, *options: object) -> tuple[np.ndarray, np.ndarray, dict]:
        """How a free body has moved, in the file's axes and as it is shown; the report's asset."""
        output, report = self.folder / "out.glb", self.folder / "report.json"
        done = animate(source, output, "--voxels", 6, "--frames", 2, "--fps", 10, "--report",
                       report, *options)
        self.assertEqual(done.code, 0, done.err)
        document = read_document(output)
        moved = [np.mean([frames(document, 2)[key] - frames(document, 0)[key]
                          for key in frames(document, 0)], axis=(0, 1))
                 for frames in (local_positions, world_positions)]
        return moved[0], moved[1], json.loads(report.read_text())["asset"]

    def test_each_direction_falls_against_itself_and_is_shown_along_y(self) -> None:
        for name in ("x", "y", "z", "-x", "-y", "-z"):
            local, shown, asset = self.fallen(self.source, "--up", name)
            direction = np.eye(3)["xyz".index(name[-1])] * (-1 if name[0] == "-" else 1)
            depth = -local @ direction
            self.assertGreater(depth, 0.1)
            np.testing.assert_allclose(local, -depth * direction, atol=2e-3)
            np.testing.assert_allclose(shown, [0, -depth, 0], atol=2e-3)
            self.assertEqual(asset["up"]["axis"], name)
            self.assertFalse(asset["up"]["guessed"])

    def test_a_floor_lies_where_the_asset_begins_along_up(self) -> None:
        for name in ("x", "-x", "-y", "z"):
            local, _, _ = self.fallen(self.source, "--up", name, "--floor", "--young", "1e7")
            self.assertLess(np.abs(local).max(), 5e-3)

    def test_the_guess_follows_the_format_and_is_reported(self) -> None:
        glb = self.folder / "box.glb"
        glb.write_bytes(glb_bytes(*glb_parts(*BOX)))
        stl = write_stl(self.folder / "box.stl", *BOX, False)
        for source, axis, guessed in ((self.source, "y", True), (stl, "z", True),
                                      (glb, "y", False)):
            _, shown, asset = self.fallen(source)
            self.assertEqual(asset["up"]["axis"], axis)
            self.assertEqual((asset["up"]["guessed"], asset["size"]["guessed"]), (guessed, guessed))
            self.assertTrue(asset["up"]["reason"] and asset["size"]["reason"])
            self.assertLess(shown[1], -0.1)

    def test_a_size_that_looks_wrong_is_a_warning(self) -> None:
        large = write_obj(self.folder / "large.obj", 1000 * BOX[0], BOX[1])
        done = animate(large, self.folder / "out.glb", "--voxels", 6, "--frames", 1)
        self.assertEqual(done.code, 0, done.err)
        self.assertIn("longest edge 300 m", done.err)
        done = animate(large, self.folder / "out.glb", "--voxels", 6, "--frames", 1, "--size", "30cm")
        self.assertNotIn("longest edge", done.err)


class Inspect(Verbs):
    def test_an_asset_is_described(self) -> None:
        d = self.printed("inspect", self.source, "--json", "--h", "2cm")
        self.assertEqual(d["format"], "obj")
        self.assertEqual(d["counts"], {"meshes": 1, "vertices": 8, "triangles": 12, "points": 0,
                                       "splats": 0})
        np.testing.assert_allclose(d["box"]["upper"], [0.15, 0.06, 0.05], atol=1e-12)
        self.assertEqual(d["size"]["guessed"], True)
        self.assertEqual(d["h"], 0.02)
        self.assertGreaterEqual(d["voxels"], 15 * 6 * 5)  # the lattice may be cut by the box
        self.assertGreaterEqual(d["voxels_at_most"], d["voxels"])
        self.assertEqual(d["memory_bytes"] % d["voxels"], 0)
        done = run("inspect", self.source)
        self.assertIn("longest edge 0.3 m", done.out)

    def test_a_scene_is_described_with_its_asset(self) -> None:
        d = self.printed("inspect", self.scene(), "--json")
        self.assertEqual(d["path"], str(self.source))
        self.assertAlmostEqual(d["h"], 0.3 / 8, 12)
        self.assertEqual(d["scene"]["material"]["young"], 1e5)

    def test_what_cannot_be_read_is_refused(self) -> None:
        self.refused(run("inspect", self.folder / "none.obj"), 3, "none.obj")
        self.refused(run("inspect"), 2, "FILE")
        self.refused(run("inspect", self.scene("[asset]\nsize = 1\n")), 2, "asset.file")


class Doctor(Verbs):
    def test_a_sound_asset_is_usable(self) -> None:
        d = self.printed("doctor", self.source, "--json", "--voxels", 8)
        self.assertTrue(d["usable"] and d["closed"])
        self.assertEqual(d["findings"], [])
        self.assertIn("nothing is odd", run("doctor", self.source, "--voxels", 8).out)

    def test_findings_come_with_their_remedy(self) -> None:
        odd = write_obj(self.folder / "odd.obj", BOX[0], [*BOX[1][1:], [0, 0, 1], BOX[1][2]])
        d = self.printed("doctor", odd, "--json", "--voxels", 8)
        self.assertTrue(d["usable"])
        found = {f["what"]: f for f in d["findings"]}
        self.assertLessEqual({"open", "zero-area", "duplicate-faces"}, set(found))
        self.assertEqual(found["zero-area"]["count"], 1)
        for finding in found.values():
            self.assertEqual(set(finding), {"what", "severity", "count", "text", "done", "change"})
            self.assertIn(finding["severity"], ("note", "warning"))
            self.assertTrue(finding["done"])
        text = run("doctor", odd, "--voxels", 8)
        self.assertEqual(text.code, 0)
        for what in found:
            self.assertIn(what, text.out)

    def test_what_cannot_be_used_ends_with_three(self) -> None:
        empty = self.folder / "empty.obj"
        empty.write_text("v 0 0 0\n")
        for broken in (empty, self.folder / "none.obj"):
            d = self.printed("doctor", broken, "--json", code=3)
            self.assertFalse(d["usable"])
            self.assertIn(broken.name, d["error"])
        self.refused(run("doctor", empty), 3, "empty.obj")
        self.refused(run("doctor", self.source, "--voxels", 4000, "--max-voxels", 10), 6, "10")


class Voxelize(Verbs):
    def test_a_voxel_file_and_its_report_are_written(self) -> None:
        output, report = self.folder / "box.vdb", self.folder / "r.json"
        done = run("voxelize", self.source, "-o", output, "--h", "2cm", "--report", report)
        self.assertEqual(done.code, 0, done.err)
        self.assertEqual(output.read_bytes()[:4], b" BDV")
        r = json.loads(report.read_text())
        self.assertIn(f"{r['voxels']} voxels", done.out)
        self.assertIn("volume 0.0036", done.out)
        self.assertEqual((r["h"], r["steps"], r["asset"]["closed"]), (0.02, 0, True))

    def test_wrong_names_are_refused(self) -> None:
        self.refused(run("voxelize", self.source, "-o", self.folder / "a.txt"), 2, ".vdb")
        self.refused(run("voxelize", self.source), 2, "--output")
        same = self.folder / "a.vdb"
        self.refused(run("voxelize", self.source, "-o", same, "--report", same), 2, "a.vdb")
        self.refused(run("voxelize", self.source, "-o", self.folder / "no" / "a.vdb"), 6, "a.vdb")
        self.assertEqual({path.name for path in self.folder.iterdir()}, {"box.obj"})


class Materials(Verbs):
    def test_presets_come_with_source_and_moduli(self) -> None:
        presets = self.printed("materials", "--json")
        self.assertEqual(self.printed("materials", "list", "--json"), presets)
        for m in presets:
            self.assertIn(m["kind"], ("measured", "literature", "look"))
            self.assertTrue(m["source"])
            mu = m["young"] / (2 * (1 + m["poisson"]))
            bulk = m["young"] / (3 * (1 - 2 * m["poisson"]))
            self.assertAlmostEqual(m["mu"] / mu, 1, 12)
            self.assertAlmostEqual(m["bulk"] / bulk, 1, 12)
            self.assertAlmostEqual(m["lambda"] / (bulk - 2 * mu / 3), 1, 9)
            self.assertAlmostEqual(m["shear_wave"] ** 2 * m["density"] / mu, 1, 12)
            self.assertAlmostEqual(m["pressure_wave"] ** 2 * m["density"] / (bulk + 4 * mu / 3), 1,
                                   12)
            self.assertEqual(self.printed("materials", "show", m["name"], "--json"), m)
            self.assertIn(m["source"], run("materials", "show", m["name"]).out)
            self.assertIn(m["name"], run("materials").out)

    def test_an_unknown_preset_is_refused(self) -> None:
        self.refused(run("materials", "show", "unobtainium"), 2, "unobtainium", "rubber")
        self.refused(run("materials", "show"), 2)


if __name__ == "__main__":
    unittest.main()
