# SPDX-License-Identifier: Apache-2.0
"""Files that lie or end early: the documented exit code, a sentence with the file and the place,
bounded time and memory, nothing written, nothing opened outside the file's folder."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import unittest
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import corpus_cloud as cloud
import corpus_foreign as foreign
import corpus_gltf as gltf
import corpus_mesh as mesh
from command import animate
from corpus import Case, Outcome, command_for, complaints
from corpus_scene import scene_cases

OUTCOMES: dict[str, list[Outcome]] = {}  # of each format
ENDINGS = ("obj", "ply", "stl", "off", "glb", "gltf", "xyz", "pts", "pcd", "las", "splat", "spz",
           "fbx", "dae", "3ds", "x", "ac", "vdb", "")


def tearDownModule() -> None:
    """Prints what docs/tests.md quotes."""
    every = [outcome for outcomes in OUTCOMES.values() for outcome in outcomes]
    for title, outcomes in [*OUTCOMES.items(), ("all", every)]:
        refused = sum(outcome.code != 0 for outcome in outcomes)
        print(f"{title}: {refused} of {len(outcomes)} files refused cleanly, the others read, "
              f"worst {max((o.seconds for o in outcomes), default=0):.1f} s of CPU, "
              f"{max((o.mebibytes for o in outcomes), default=0):.0f} MiB")


class BrokenFiles(unittest.TestCase):
    """Each case on its own."""

    def check(self, title: str, cases: Iterator[Case]) -> None:
        outcomes = OUTCOMES.setdefault(title, [])
        with ThreadPoolExecutor(2) as pool:
            for case, (outcome, wrong) in pool.map(lambda c: (c, complaints(c)), cases):
                with self.subTest(f"{title} {case.name}"):
                    self.assertEqual(wrong, [])
                    outcomes.append(outcome)

    def test_obj(self) -> None:
        self.check("OBJ", mesh.obj_cases())

    def test_ply(self) -> None:
        self.check("PLY mesh", mesh.ply_cases())

    def test_stl(self) -> None:
        self.check("STL", mesh.stl_cases())

    def test_off(self) -> None:
        self.check("OFF", mesh.off_cases())

    def test_glb(self) -> None:
        self.check("GLB", gltf.container_cases())
        self.check("GLB", gltf.range_cases())

    def test_gltf(self) -> None:
        self.check("glTF", gltf.gltf_cases())
        self.check("glTF", gltf.bomb_cases())

    def test_paths(self) -> None:
        self.check("paths", gltf.path_cases())

    def test_clouds(self) -> None:
        self.check("PLY points", cloud.ply_cloud_cases())
        self.check("XYZ, PTS", cloud.xyz_cases())
        self.check("PCD", cloud.pcd_cases())
        self.check("LAS", cloud.las_cases())

    def test_splats(self) -> None:
        self.check("PLY 3DGS", cloud.splat_ply_cases())
        self.check("PLY PlayCanvas", cloud.packed_cases())
        self.check("splat", cloud.splat_cases())
        self.check("SPZ", cloud.spz_cases())

    def test_reader_process(self) -> None:
        self.check("FBX", foreign.fbx_cases())
        self.check("DAE", foreign.dae_cases())
        self.check("3DS", foreign.three_ds_cases())
        self.check("VDB", foreign.vdb_cases())

    def test_scenes(self) -> None:
        self.check("scene files", scene_cases())

    def test_empty_files_and_formats_that_are_not_read(self) -> None:
        self.check("any format", (Case(f"empty.{e}", b"", "empty") for e in ENDINGS))
        self.check("any format", (Case(name, b"some text\n", ".obj .ply .stl .glb .gltf")
                                  for name in ("a.usdz", "a.msh", "a")))

    @unittest.skipUnless(shutil.which("strace"), "strace is not installed")
    def test_nothing_outside_is_opened_and_no_socket_made(self) -> None:
        for case in [*gltf.path_cases(), *(c for c in foreign.dae_cases() if c.beside)]:
            with self.subTest(case.name), tempfile.TemporaryDirectory() as folder:
                path, log = case.write(Path(folder)), Path(folder) / "log"
                trace = ["strace", "-f", "-e", "trace=network,openat,open", "-o", log]
                done = subprocess.run([*trace, *map(str, command_for(path))],  # type: ignore[list-item]
                                      capture_output=True, check=False, timeout=60)
                self.assertIn(done.returncode, case.codes)
                calls = log.read_text(errors="replace")
                self.assertIn(case.name, calls)
                for word in ("outside", "/dev/zero", "socket(", "connect("):
                    self.assertNotIn(word, calls)

    def test_animate_writes_nothing_of_a_broken_file(self) -> None:
        for case in list(gltf.range_cases())[:3] + list(mesh.obj_cases())[:3]:
            with self.subTest(case.name), tempfile.TemporaryDirectory() as folder:
                source = case.write(Path(folder))
                outputs = [Path(folder) / n for n in ("out.glb", "s.h5", "l.json", "r.json")]
                done = animate(source, outputs[0], "--voxels", 4, "--frames", 1, "--state",
                               outputs[1], "--log-json", outputs[2], "--report", outputs[3])
                self.assertEqual(done.code, 3, done.err)
                self.assertEqual([p.name for p in Path(folder).rglob("*")], ["in", case.name])

    def test_the_cases_are_well_but_for_one_thing(self) -> None:
        whole = [Case("a.obj", mesh.written(mesh.write_obj, "a.obj", mesh.POSITION, mesh.FACES)),
                 Case("a.off", mesh.off_bytes()),
                 Case("a.glb", gltf.glb_bytes(gltf.DOCUMENT, gltf.DATA))]
        whole += [Case(f"{text}.stl", mesh.written(mesh.write_stl, "a.stl", mesh.POSITION,
                                                   mesh.FACES, text)) for text in (True, False)]
        whole += [Case(f"{e}.ply", mesh.written(mesh.write_ply, "a.ply", mesh.POSITION,
                                                mesh.triangles_of(mesh.FACES), e))
                  for e in ("ascii", "binary_little_endian", "binary_big_endian")]
        for case in whole:
            with self.subTest(case.name), tempfile.TemporaryDirectory() as folder:
                done = animate(case.write(Path(folder)), Path(folder) / "out.glb", "--voxels", 4,
                               "--frames", 1, "--pin", "x<10%")
                self.assertEqual(done.code, 0, done.err)

    def test_missing_files_and_folders(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for source in (Path(folder) / "missing.obj", Path(folder)):
                done = animate(source, Path(folder) / "out.glb")
                self.assertEqual(done.code, 3)
                self.assertIn(str(source), done.err)
            self.assertEqual(list(Path(folder).iterdir()), [])


if __name__ == "__main__":
    unittest.main()
