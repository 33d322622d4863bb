# SPDX-License-Identifier: Apache-2.0
"""GLBs of glTF scenes with instances, shared meshes, hidden nodes and animations of their own."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np

from command import animate, glb_bytes, glb_parts, round_trip, turned_box
from glb_check import check_animation
from glb_file import Document, GlbError, frame_count, parse_glb, read_document, world_positions

CUBE = turned_box((0.5, 0.5, 0.5), (0, 0, 1), 0)
OPTIONS = ("--voxels", 14, "--frames", 24, "--young", "3e4", "--pin", "x<5%")


def add_values(document: dict[str, Any], data: bytes, values: Any, kind: str) -> bytes:
    """Appends an accessor of floats; returns the longer buffer."""
    rows = np.atleast_2d(np.asarray(values, "<f4").T).T
    data += bytes(-len(data) % 4)
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(data),
                                    "byteLength": rows.nbytes})
    document["accessors"].append({
        "bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "count": len(rows),
        "type": kind, "min": rows.min(0).tolist(), "max": rows.max(0).tolist()})
    data += rows.tobytes()
    document["buffers"][0]["byteLength"] = len(data)
    return data


def row_of_cubes() -> tuple[dict[str, Any], bytes]:
    """Three cubes in a row that touch: two nodes share a mesh, one is mirrored and scaled."""
    document, data = glb_parts(*CUBE)
    document["nodes"] = [{"mesh": 0, "name": "first"},
                         {"mesh": 0, "name": "second", "translation": [0.5, 0, 0]},
                         {"mesh": 0, "name": "third", "translation": [1, 0.25, 0],
                          "scale": [-1, 2, 1]}]
    document["scenes"][0]["nodes"] = [0, 1, 2]
    return document, data


class Outputs(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def animated(self, document: dict[str, Any], data: bytes, *options: object) -> Document:
        source, output = self.folder / "in.glb", self.folder / "out.glb"
        source.write_bytes(glb_bytes(document, data))
        done = animate(source, output, *OPTIONS, *options)
        self.assertEqual(done.code, 0, done.err)
        self.assertEqual(round_trip(output), "")
        result = read_document(output)
        check_animation(result)
        return result

    def test_vertices_of_different_meshes_that_coincide_stay_together(self) -> None:
        for options in ((), ("--glb-profile", "keyframe"), ("--glb-targets", 4)):
            with self.subTest(options):
                document = self.animated(*row_of_cubes(), *options)
                rest = np.concatenate(list(world_positions(document, 0).values()))
                edge = np.ptp(rest, axis=0).max()
                pairs = [(i, j) for i in range(len(rest)) for j in range(i)
                         if np.linalg.norm(rest[i] - rest[j]) < 1e-6 * edge]
                self.assertEqual(len(pairs), 6)
                largest = 0.0
                for frame in range(frame_count(document)):
                    x = np.concatenate(list(world_positions(document, frame).values()))
                    largest = max(largest, float(np.abs(x - rest).max()))
                    for i, j in pairs:
                        self.assertLess(np.linalg.norm(x[i] - x[j]), 1e-5 * edge, frame)
                self.assertGreater(largest, 0.05 * edge)

    def test_instances_become_nodes_that_move_by_themselves(self) -> None:
        document, data = glb_parts(*CUBE)
        for values, kind in (([[0, 0, 0], [1, 0, 0], [2, 0, 0]], "VEC3"),
                             ([[0, 0, 0, 1], [0, 0, 0.6, 0.8], [0, 0, 0, 1]], "VEC4"),
                             ([[1, 1, 1], [1, 1, 1], [1, 0.5, 1]], "VEC3")):
            data = add_values(document, data, values, kind)
        first = len(document["accessors"]) - 3
        document["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": first, "ROTATION": first + 1, "SCALE": first + 2}}}
        document["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
        for required in ([], ["EXT_mesh_gpu_instancing"]):
            document["extensionsRequired"] = required
            result = self.animated(document, data, "--floor", "--no-strict-time")
            self.assertNotIn("EXT_mesh_gpu_instancing", str(result.json.get("nodes")))
            start, end = (world_positions(result, t) for t in (0, 24))
            self.assertEqual(len(start), 3)
            for key, centre in zip(sorted(start), ([0, 0, 0], [1, 0, 0], [2, 0, 0])):
                np.testing.assert_allclose((start[key].min(0) + start[key].max(0)) / 2, centre,
                                           atol=1e-6)
            moved = [float(np.abs(end[key] - start[key]).max()) for key in sorted(start)]
            self.assertEqual(len({round(m, 4) for m in moved}), 3, moved)

    def test_hidden_nodes_and_other_animations_stay_as_they_were(self) -> None:
        document, data = glb_parts(*CUBE)
        data = add_values(document, data, [0, 0.4, 1], "SCALAR")
        data = add_values(document, data, [[0, 0, 0], [0, 1, 0], [3, 1, 0]], "VEC3")
        times = len(document["accessors"]) - 2
        document["nodes"] += [
            {"mesh": 0, "name": "ghost", "translation": [0, 5, 0],
             "extensions": {"KHR_node_visibility": {"visible": False}}},
            {"mesh": 0, "name": "flat", "scale": [1, 0, 1]},
            {"camera": 0, "name": "eye"}]
        document["extensionsUsed"] = ["KHR_node_visibility"]
        document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
        document["scenes"][0]["nodes"] = [0, 1, 2, 3]
        sampler = {"input": times, "output": times + 1}
        document["animations"] = [
            {"name": "both", "samplers": [sampler], "channels": [
                {"sampler": 0, "target": {"node": node, "path": "translation"}}
                for node in (0, 3)]},
            {"name": "body", "samplers": [sampler], "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "scale"}}]}]
        result = self.animated(document, data)
        self.assertEqual([a["name"] for a in result.items("animations")], ["elastogen", "both"])
        channels = result.items("animations")[1]["channels"]
        self.assertEqual([c["target"]["node"] for c in channels], [3])
        kept = result.items("animations")[1]["samplers"][channels[0]["sampler"]]
        np.testing.assert_array_equal(result.raw(kept["output"]), [[0, 0, 0], [0, 1, 0], [3, 1, 0]])
        self.assertEqual(result.items("nodes")[1], document["nodes"][1])
        self.assertEqual(result.items("nodes")[2], document["nodes"][2])
        shown = world_positions(result, 0)
        self.assertEqual(np.ptp(shown[0, 0], axis=0).round(6).tolist(), [0.5, 0.5, 0.5])

    def test_the_checker_finds_what_the_rules_forbid(self) -> None:
        good = self.animated(*row_of_cubes())
        data = good.buffers[0]
        for number, change in enumerate((
                lambda d: d["materials"].append({"normalTexture": {"index": 0}}) or d["meshes"][0][
                    "primitives"][0].update(material=len(d["materials"]) - 1),
                lambda d: d["nodes"][0].update(rotation=[0, 0, 0, 2]),
                lambda d: d["scenes"][0]["nodes"].append(0),
                lambda d: d["nodes"][0].update(extensions={"KHR_node_visibility": {}}),
                lambda d: d["meshes"][0]["extras"]["targetNames"].pop(),
                lambda d: d["meshes"][0]["primitives"][0]["attributes"].update(TANGENT=0),
                lambda d: d["meshes"][0]["primitives"][0]["attributes"].update(TEXCOORD_1=0))):
            with self.subTest(number):
                document = parse_glb(glb_bytes(good.json, data)).json
                document.setdefault("materials", [])
                change(document)
                with self.assertRaises(GlbError):
                    check_animation(parse_glb(glb_bytes(document, data)))


if __name__ == "__main__":
    unittest.main()
