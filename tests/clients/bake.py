# SPDX-License-Identifier: Apache-2.0
"""An animated GLB without its animation, in the pose that the point cache has in one frame.

Normals are carried from rest to the pose as a covector on each triangle with edges e1, e2 and unit
normal m, and averaged over a vertex's triangles by their area at rest:

    n' = (n.e1) (e2' x m') / |e1' x e2'| + (n.e2) (m' x e1') / |e1' x e2'| + (n.m) m'
"""

from __future__ import annotations

import copy
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
from point_cache import Places, visible  # noqa: E402
from glb_file import Document, local_positions, world_matrices, world_positions  # noqa: E402
from inputs import glb_bytes  # noqa: E402

Values = NDArray[np.float64]


def triangles_of(document: Document, primitive: dict[str, Any], count: int) -> NDArray[np.int64]:
    """(triangles, 3) vertices of a primitive that is a list of triangles; none of others."""
    if primitive.get("mode", 4) != 4:
        return np.empty((0, 3), int)
    corners = (document.raw(primitive["indices"])[:, 0] if "indices" in primitive
               else np.arange(count))
    return corners.astype(int).reshape(-1, 3)


def frames_of(x: Values, triangles: NDArray[np.int64]) -> tuple[Values, Values, Values, Values]:
    """Edges e1, e2 and unit normals (triangles, 3), and twice the areas (triangles, 1)."""
    e1, e2 = (x[triangles[:, k]] - x[triangles[:, 0]] for k in (1, 2))
    m = np.cross(e1, e2)
    area = np.linalg.norm(m, axis=1, keepdims=True)
    return e1, e2, m / np.where(area > 0, area, 1), area


def carried_normals(normal: Values, rest: Values, moved: Values,
                    triangles: NDArray[np.int64]) -> Values:
    """(vertices, 3) normals after the motion, of the length that they had."""
    e1, e2, m, area = frames_of(rest, triangles)
    f1, f2, k, moved_area = frames_of(moved, triangles)
    valid = (area > 0) & (moved_area > 0)
    total = np.zeros_like(normal)
    for corner in range(3):
        n = normal[triangles[:, corner]]
        a, b, c = ((n * d).sum(1, keepdims=True) for d in (e1, e2, m))
        turned = (a * np.cross(f2, k) + b * np.cross(k, f1)) / np.where(valid, moved_area, 1)
        np.add.at(total, triangles[:, corner], np.where(valid, area * (turned + c * k), 0))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    scale = np.linalg.norm(normal, axis=1, keepdims=True) / np.where(length > 0, length, 1)
    return np.where(length > 0, total * scale, normal)


class Baker:
    """The rest frame of an animated GLB, and which point of the cache each vertex is."""

    def __init__(self, document: Document, cache: Values) -> None:
        """@param cache  (frames, points, 3) in the axes and numbers of the document's world."""
        self.document, self.cache = document, cache
        self.world, self.local = world_matrices(document), local_positions(document, 0)
        places = Places(cache[0])
        shown = {key: x for key, x in world_positions(document, 0).items()
                 if visible([x], places.edge)}
        self.points = {key: places.candidates(x)[0][:, 0] for key, x in shown.items()}

    def moved(self, key: tuple[int, int], frame: int) -> Values:
        """Positions of a primitive in its mesh's numbers."""
        matrix = self.world[key[0]]
        shift = self.cache[frame][self.points[key]] - matrix[:3, 3]
        return np.linalg.solve(matrix[:3, :3], shift.T).T

    def attributes(self, key: tuple[int, int], frame: int) -> dict[str, Values]:
        """POSITION, and NORMAL where the primitive has one."""
        primitive = self.primitive(key)
        result = {"POSITION": self.moved(key, frame)}
        if "NORMAL" in primitive["attributes"]:
            normal = self.document.values(primitive["attributes"]["NORMAL"])
            triangles = triangles_of(self.document, primitive, len(normal))
            result["NORMAL"] = carried_normals(normal, self.local[key], result["POSITION"],
                                               triangles)
        return result

    def primitive(self, key: tuple[int, int]) -> dict[str, Any]:
        """Of (node, primitive)."""
        mesh = self.document.items("nodes")[key[0]]["mesh"]
        return self.document.items("meshes")[mesh]["primitives"][key[1]]

    def glb(self, frame: int) -> bytes:
        """A GLB that stands in the pose of a frame."""
        json, binary = copy.deepcopy(self.document.json), bytearray(self.document.buffers[0])
        json.pop("animations", None)
        meshes: list[dict[str, Any]] = []
        for n, node in enumerate(json["nodes"]):
            node.pop("weights", None)
            keys = sorted(key for key in self.points if key[0] == n)
            if node.pop("mesh", None) is None or not keys:
                continue
            node["mesh"] = len(meshes)
            meshes.append({"primitives": [self._primitive(key, frame, json, binary)
                                          for key in keys]})
        json["meshes"] = meshes
        json["buffers"] = [{"byteLength": len(binary)}]
        return glb_bytes(json, bytes(binary))

    def _primitive(self, key: tuple[int, int], frame: int, json: dict[str, Any],
                   binary: bytearray) -> dict[str, Any]:
        result = copy.deepcopy(self.primitive(key))
        result.pop("targets", None)
        for name, values in self.attributes(key, frame).items():
            array = values.astype("<f4")
            binary += bytes(-len(binary) % 4)
            json["bufferViews"].append({"buffer": 0, "byteOffset": len(binary),
                                        "byteLength": array.nbytes})
            binary += array.tobytes()
            json["accessors"].append({
                "bufferView": len(json["bufferViews"]) - 1, "componentType": 5126, "type": "VEC3",
                "count": len(array), "min": array.min(0).tolist(), "max": array.max(0).tolist()})
            result["attributes"][name] = len(json["accessors"]) - 1
        return result
