# SPDX-License-Identifier: Apache-2.0
"""GLB files packed by Draco and by meshopt, written by hand after the formats' specifications, and
one of a scene."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from command import glb_bytes, glb_parts, turned_box

# a tetrahedron
POSITION = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
TRIANGLES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def draco_mesh() -> bytes:
    """Draco 2.2, sequential: indices as they are, one attribute of floats as they are."""
    head = b"DRACO" + bytes([2, 2, 1, 0]) + struct.pack("<H", 0)
    connectivity = bytes([len(TRIANGLES), len(POSITION), 1]) + bytes(sum(TRIANGLES, []))
    # one decoder of one attribute: position, float32, three components, id 0, plain values
    attribute = bytes([1, 1, 0, 9, 3, 0, 0, 0])
    return head + connectivity + attribute + POSITION.tobytes()


def accessors(packed: bool) -> list[dict[str, object]]:
    """Those of positions and indices, with their views unless Draco has them."""
    views = [{}, {}] if packed else [{"bufferView": 0}, {"bufferView": 1}]
    return [views[0] | {"componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0],
                        "max": [1, 1, 1]},
            views[1] | {"componentType": 5123, "count": 12, "type": "SCALAR"}]


def document(extension: str, packed: bool) -> dict[str, object]:
    """One mesh of the two accessors, shown by one node."""
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    return {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}],
            "accessors": accessors(packed), "extensionsUsed": [extension],
            "extensionsRequired": [extension]}


def scene_glb() -> bytes:
    """The box with a morph target, in three instances, hidden once; a camera has an animation."""
    document, data = glb_parts(*turned_box((0.3, 0.2, 0.1), (1, 2, 3), 25))
    rows = {"VEC3": [np.full((8, 3), 0.01), [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
                     [[0, 0, 0], [0, 1, 0]]],
            "VEC4": [[[0, 0, 0, 1], [0, 0, 0.6, 0.8], [1, 0, 0, 0]]], "SCALAR": [[[0], [1]]]}
    for kind, arrays in rows.items():
        for array in arrays:
            values = np.asarray(array, "<f4")
            document["bufferViews"].append(
                {"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
            document["accessors"].append({
                "bufferView": len(document["bufferViews"]) - 1, "componentType": 5126,
                "count": len(values), "type": kind, "min": values.min(0).tolist(),
                "max": values.max(0).tolist()})
            data += values.tobytes()
    mesh = document["meshes"][0]
    mesh["primitives"][0]["targets"] = [{"POSITION": 2}]
    mesh["primitives"].append(mesh["primitives"][0] | {"mode": 1})  # as lines
    mesh["weights"] = [0.5]
    instances = {"attributes": {"TRANSLATION": 3, "ROTATION": 5}}
    document["nodes"] = [
        {"mesh": 0, "weights": [1], "extensions": {"EXT_mesh_gpu_instancing": instances}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": False}}},
        {"camera": 0}, {"mesh": 0, "scale": [1, 0, 1]}]
    document["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    document["animations"] = [{"samplers": [{"input": 6, "output": 4}], "channels": [
        {"sampler": 0, "target": {"node": node, "path": "translation"}} for node in (0, 2)]}]
    document["extensionsUsed"] = ["EXT_mesh_gpu_instancing", "KHR_node_visibility"]
    document["buffers"][0]["byteLength"] = len(data)
    return glb_bytes(document, data)


def draco_glb() -> bytes:
    """The tetrahedron by KHR_draco_mesh_compression."""
    name, data = "KHR_draco_mesh_compression", draco_mesh()
    result = document(name, True)
    result["meshes"][0]["primitives"][0]["extensions"] = {  # type: ignore[index]
        name: {"bufferView": 0, "attributes": {"POSITION": 0}}}
    result["bufferViews"] = [{"buffer": 0, "byteLength": len(data)}]
    result["buffers"] = [{"byteLength": len(data)}]
    return glb_bytes(result, data)


def zigzag(delta: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    """Signed differences of a width as unsigned numbers, small ones small."""
    signed = (delta + (1 << (bits - 1))) % (1 << bits) - (1 << (bits - 1))
    return np.where(signed < 0, -2 * signed - 1, 2 * signed)


def meshopt_vertices(values: bytes, stride: int) -> bytes:
    """Vertex codec of version 0: one block, each byte of the vertices in groups of 16."""
    rows = np.frombuffer(values, np.uint8).reshape(-1, stride).astype(np.int64)
    out = b"\xa0"
    for k in range(stride):
        column = np.zeros(16, np.int64)
        column[:len(rows)] = zigzag(np.diff(rows[:, k], prepend=rows[0, k]), 8)
        out += b"\x03" + column.astype(np.uint8).tobytes()
    return out + bytes(max(32 - stride, 0)) + rows[0].astype(np.uint8).tobytes()


def meshopt_sequence(indices: list[int]) -> bytes:
    """Index sequence codec of version 1, all indices after the first baseline."""
    out, last = b"\xd1", 0
    for index in indices:
        value = int(zigzag(np.array(index - last), 32)) << 1
        while value > 127:
            out += bytes([value & 127 | 128])
            value >>= 7
        out += bytes([value])
        last = index
    return out + bytes(4)


def meshopt_glb() -> bytes:
    """The tetrahedron by EXT_meshopt_compression."""
    name = "EXT_meshopt_compression"
    vertices = meshopt_vertices(POSITION.tobytes(), 12)
    data = vertices + bytes(-len(vertices) % 4)
    sequence = meshopt_sequence(sum(TRIANGLES, []))
    result = document(name, False)
    packed = [{"buffer": 0, "byteOffset": 0, "byteLength": len(vertices), "byteStride": 12,
               "count": 4, "mode": "ATTRIBUTES"},
              {"buffer": 0, "byteOffset": len(data), "byteLength": len(sequence), "byteStride": 2,
               "count": 12, "mode": "INDICES"}]
    data += sequence
    result["bufferViews"] = [
        {"buffer": 1, "byteOffset": 48 * k, "byteLength": size, "extensions": {name: view}}
        for k, (size, view) in enumerate(zip((48, 24), packed))]
    result["buffers"] = [{"byteLength": len(data)},
                         {"byteLength": 72, "extensions": {name: {"fallback": True}}}]
    return glb_bytes(result, data)
