# SPDX-License-Identifier: Apache-2.0
"""Self-tests of the GLB reader and checker on a small animation whose vertices are known."""

from __future__ import annotations

import copy
import struct
import unittest
from collections.abc import Callable
from typing import Any

import numpy as np

import kept
from command import glb_bytes, glb_parts, turned_box
from glb_check import check_animation
from glb_file import GlbError, local_positions, parse_glb, world_positions
from source_mesh import SourceMesh

POSITION, FACES = turned_box((0.3, 0.2, 0.1), (1, 2, 3), 25)
TARGETS = np.random.default_rng(1).normal(size=(2, 8, 3)).astype("<f4")
WEIGHTS = np.array([[0, 0], [1, 0.5], [0.75, 0.25]], "<f4")
TIMES = np.array([0, 0.5, 1], "<f4")


def animated() -> tuple[dict[str, Any], bytes]:
    """Document and buffer: two targets, three frames at 2 fps, below a node that moves and scales.

    The second target is sparse: only vertices 1 and 6 move.
    """
    document, data = glb_parts(POSITION, FACES)

    def add(values: Any, kind: str | None) -> int:
        nonlocal data
        data += bytes(-len(data) % 4)
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(data),
                                        "byteLength": values.nbytes})
        data += values.tobytes()
        document["buffers"][0]["byteLength"] = len(data)
        if kind:
            document["accessors"].append({
                "bufferView": len(document["bufferViews"]) - 1, "componentType": 5126,
                "count": len(values), "type": kind, "min": np.atleast_1d(values.min(0)).tolist(),
                "max": np.atleast_1d(values.max(0)).tolist()})
        return len(document["accessors"]) - 1

    first, times, weights = add(TARGETS[0], "VEC3"), add(TIMES, "SCALAR"), add(
        WEIGHTS.reshape(-1), "SCALAR")
    for values in (np.array([1, 6], "<u2"), TARGETS[1][[1, 6]]):
        add(values, None)
    views, moved = len(document["bufferViews"]), np.vstack([np.zeros(3), TARGETS[1][[1, 6]]])
    document["accessors"].append({
        "componentType": 5126, "count": 8, "type": "VEC3", "min": moved.min(0).tolist(),
        "max": moved.max(0).tolist(), "sparse": {
            "count": 2, "indices": {"bufferView": views - 2, "componentType": 5123},
            "values": {"bufferView": views - 1}}})
    mesh = document["meshes"][0]
    mesh["primitives"][0]["targets"] = [{"POSITION": first},
                                        {"POSITION": len(document["accessors"]) - 1}]
    mesh["weights"] = [0, 0]
    mesh["extras"] = {"targetNames": ["a", "b"]}
    document["nodes"].append({"children": [0], "translation": [1, 2, 3], "scale": [2, 2, 2]})
    document["scenes"][0]["nodes"] = [1]
    document["animations"] = [{"name": "elastogen", "channels": [{"sampler": 0, "target": {
        "node": 0, "path": "weights"}}], "samplers": [{"input": times, "output": weights}]}]
    frame = {"converged": True, "residual": 1e-4, "min_j": 0.9}
    document["asset"]["extras"] = {"elastogen": {
        "generator": "g", "commit": "c", "command": "e", "fps": 2, "profile": "modal", "targets": 2,
        "pieces": 1, "max_error_m": 0.0, "normal_error_deg": 0.0, "tolerance_m": 1e-3, "frames": [dict(frame) for _ in range(3)]}}
    return document, data


def other_animation(document: dict[str, Any], node: int, output: int = -1) -> dict[str, Any]:
    """An animation of a node; nodes[2] is a new one without a mesh, which may move."""
    document["nodes"].append({})
    document["nodes"][1]["children"].append(2)
    times = document["animations"][0]["samplers"][0]["input"]
    return {"name": "track", "channels": [{"sampler": 0, "target": {
        "node": node, "path": "translation"}}], "samplers": [{
            "input": times, "output": times + (3 if output == -2 else 0)}]}


def weights_start(document: dict[str, Any]) -> int:
    """Where the weights begin in the buffer."""
    accessor = document["accessors"][document["animations"][0]["samplers"][0]["output"]]
    return document["bufferViews"][accessor["bufferView"]]["byteOffset"]


class Reader(unittest.TestCase):
    """Vertices from weights and targets."""

    def test_vertices_are_the_base_plus_the_weighted_targets(self) -> None:
        document = parse_glb(glb_bytes(*animated()))
        check_animation(document)
        moving = TARGETS.astype(float)
        moving[1, [0, 2, 3, 4, 5, 7]] = 0
        for t in range(3):
            wanted = POSITION.astype("<f4") + np.tensordot(WEIGHTS[t].astype(float), moving, 1)
            np.testing.assert_allclose(local_positions(document, t)[0, 0], wanted, rtol=1e-12)
            np.testing.assert_allclose(world_positions(document, t)[0, 0], 2 * wanted + [1, 2, 3],
                                       rtol=1e-12)


    def test_weights_are_kept_in_range_and_a_scale_of_zero_hides(self) -> None:
        document, data = animated()
        document["nodes"][0]["scale"] = [0, 0, 0]
        self.assertEqual(set(local_positions(parse_glb(glb_bytes(document, data)), 1)), {(0, 0)})
        times, scale = np.array([0, 0.5], "<f4"), np.array([1, 1, 1, 0, 0, 0], "<f4")
        for values, kind, count in ((times, "SCALAR", 2), (scale, "VEC3", 2)):
            document["bufferViews"].append({"buffer": 0, "byteOffset": len(data),
                                            "byteLength": values.nbytes})
            data += values.tobytes()
            document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1,
                                          "componentType": 5126, "count": count, "type": kind})
        document["buffers"][0]["byteLength"] = len(data)
        animation, last = document["animations"][0], len(document["accessors"]) - 1
        animation["samplers"].append({"input": last - 1, "output": last, "interpolation": "STEP"})
        animation["channels"].append({"sampler": 1, "target": {"node": 0, "path": "scale"}})
        hidden = parse_glb(glb_bytes(document, data))
        self.assertEqual([len(local_positions(hidden, t)) for t in range(3)], [1, 0, 0])
        over = WEIGHTS.copy()
        over[1] = (-2, 3)  # kept as 0 and 1
        start = weights_start(document)
        data = data[:start] + over.tobytes() + data[start + over.nbytes :]
        document["animations"][0]["channels"].pop()
        second = TARGETS[1].astype(float)
        second[[0, 2, 3, 4, 5, 7]] = 0
        np.testing.assert_allclose(local_positions(parse_glb(glb_bytes(document, data)), 1)[0, 0],
                                   POSITION.astype("<f4") + second, rtol=1e-12)


class Checker(unittest.TestCase):
    """One thing wrong at a time is found."""

    def fails(self, change: Callable[[Any], Any]) -> None:
        document, data = animated()
        change(document)
        with self.assertRaises(GlbError):
            check_animation(parse_glb(glb_bytes(document, data)))

    def test_what_glTF_forbids_is_found(self) -> None:
        for number, change in enumerate((
                lambda d: d["accessors"][0]["max"].__setitem__(1, 9.0),
                lambda d: d["accessors"][2]["min"].__setitem__(0, -9.0),
                lambda d: d["accessors"][0].pop("min"),
                lambda d: d["accessors"][0].update(count=9),
                lambda d: d["accessors"][0].update(byteOffset=2),
                lambda d: d["bufferViews"][0].update(byteLength=4000),
                lambda d: d["meshes"][0].update(weights=[0]),
                lambda d: d["meshes"][0].update(weights=[0, 1]),
                lambda d: d["meshes"][0]["primitives"][0].update(material=2),
                lambda d: d["meshes"][0]["primitives"][0]["targets"].pop(),
                lambda d: d["nodes"][0].update(matrix=np.eye(4).ravel().tolist()),
                lambda d: d["nodes"][0].update(children=[1]),
                lambda d: d["animations"][0]["channels"][0]["target"].update(path="scale"),
                lambda d: d["animations"][0]["samplers"][0].update(interpolation="STEP"),
                lambda d: d["animations"][0]["channels"].append(
                    d["animations"][0]["channels"][0]),
                lambda d: d["accessors"][-1]["sparse"].update(count=1),
                lambda d: d.update(images=[{"uri": "beside.png"}]),
                lambda d: d["asset"]["extras"].pop("elastogen"),
                lambda d: d["asset"]["extras"]["elastogen"].update(fps=3),
                lambda d: d["asset"]["extras"]["elastogen"]["frames"].pop(),
                lambda d: d["asset"]["extras"]["elastogen"]["frames"][1].pop("residual"))):
            with self.subTest(number):
                self.fails(change)

    def test_what_clients_cannot_play_is_found(self) -> None:
        document, data = animated()
        with self.assertRaisesRegex(GlbError, "2 targets, not 1"):
            check_animation(parse_glb(glb_bytes(document, data)), most=1)
        start = weights_start(document)
        document["accessors"][document["animations"][0]["samplers"][0]["output"]]["max"] = [1.5]
        moved = data[: start + 8] + struct.pack("<f", 1.5) + data[start + 12 :]
        with self.assertRaisesRegex(GlbError, "leave 0"):
            check_animation(parse_glb(glb_bytes(document, moved)))
        for change in (
                lambda d: d["meshes"][0]["extras"]["targetNames"].append("c"),
                lambda d: d["meshes"][0].pop("extras"),
                lambda d: d["animations"].append({**d["animations"][0], "name": "the same node"}),
                lambda d: d["animations"].append(other_animation(d, node=1)),
                lambda d: d["animations"].insert(0, other_animation(d, node=2)),
                lambda d: d["animations"].append(other_animation(d, node=9)),
                lambda d: d["animations"].append(other_animation(d, node=2, output=-2)),
                lambda d: (d["nodes"].append({"mesh": 0}), d["nodes"][0].update(children=[2])),
                lambda d: (d["nodes"].append({"mesh": 0}), d["nodes"][1]["children"].append(2),
                           d["animations"][0]["channels"].append(
                               {"sampler": 0, "target": {"node": 2, "path": "weights"}}))):
            self.fails(change)

    def test_animations_of_other_nodes_may_stay(self) -> None:
        document, data = animated()
        document["animations"].append(other_animation(document, node=2))
        check_animation(parse_glb(glb_bytes(document, data)))

    def test_values_and_chunks_are_checked(self) -> None:
        whole = glb_bytes(*animated())
        document, data = animated()
        start = document["bufferViews"][4]["byteOffset"]
        moved = data[:start] + struct.pack("<f", 1.0) + data[start + 4 :]
        nan = struct.pack("<f", float("nan")) + data[4:]
        for broken in (whole[:-4], whole + bytes(4), whole[:4] + b"\1" + whole[5:], whole[:12],
                       glb_bytes(document, moved), glb_bytes(document, nan),
                       glb_bytes(document, data + bytes(8))):
            with self.assertRaises(GlbError):
                check_animation(parse_glb(broken))

    def test_a_change_of_the_source_is_found(self) -> None:
        document = parse_glb(glb_bytes(*animated()))
        mesh = SourceMesh(POSITION, FACES)
        kept.check_vertices(mesh, document)
        swapped = POSITION[[1, 0, *range(2, 8)]]
        for position in (swapped, POSITION * 1.001, POSITION[:7], np.vstack([POSITION, [1, 2, 3]])):
            with self.assertRaises(GlbError):
                kept.check_vertices(SourceMesh(position, FACES), document)
        with self.assertRaises(GlbError):
            kept.check_uvs(SourceMesh(POSITION, FACES, uv=np.zeros((8, 2))), document)
        for change in (lambda d: d["nodes"][0].update(name="other"),
                       lambda d: d.update(materials=[{"name": "new"}]),
                       lambda d: d["meshes"][0]["primitives"][0].pop("indices")):
            other = copy.deepcopy(document)
            change(other.json)
            kept.check_kept_document(document, document)
            with self.assertRaises(GlbError):
                kept.check_kept_document(document, other)


if __name__ == "__main__":
    unittest.main()
