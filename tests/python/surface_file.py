# SPDX-License-Identifier: Apache-2.0
"""The triangles of a file as a client shows them at rest, and their generalised winding number w.

    w(p) = sum over triangles of (solid angle at p) / 4 pi

is 1 inside of a closed surface, 0 outside, -1 inside of one that is inside out, and the sum over its
pieces. The solid angle is that of van Oosterom and Strackee (1983): with a, b, c from p to the corners,

    tan(angle / 2) = det(a, b, c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|).
"""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from command import triangles_of
from glb_file import Document, GlbError, read_document, world_matrices
from source_mesh import READERS, ply_header

Values = NDArray[np.float64]
Indices = NDArray[np.int64]

UNPACKED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}  # not read here
BLOCK_TRIANGLES, BLOCK_POINTS = 1024, 64  # of one step of the sum: as many as a cache holds


class NotRead(Exception):
    """The file has no triangles that are read here; the message says why."""


def strip_triangles(index: Indices, mode: int) -> Indices:
    """(triangles, 3) of a list (4), strip (5) or fan (6) of glTF."""
    if mode == 4:
        return index[:len(index) // 3 * 3].reshape(-1, 3)
    count = np.arange(len(index) - 2)
    if mode == 6:
        return np.column_stack([index[count + 1], index[count + 2], np.full(len(count), index[0])])
    return np.column_stack([index[count], index[count + 1 + count % 2], index[count + 2 - count % 2]])


def primitive_positions(document: Document, node: dict[str, Any], mesh: dict[str, Any],
                        primitive: dict[str, Any]) -> Values:
    """Vertices in the shape of the morph weights."""
    x = document.values(primitive["attributes"]["POSITION"])
    weights = node.get("weights", mesh.get("weights", []))
    for weight, target in zip(weights, primitive.get("targets", [])):
        if "POSITION" in target:
            x = x + weight * document.values(target["POSITION"])
    return x


def skin_matrices(document: Document, node: dict[str, Any], primitive: dict[str, Any],
                  world: dict[int, Values]) -> Values:
    """(vertices, 4, 4) of a skinned primitive: sum_j w_j W_j B_j, weights scaled to the sum 1."""
    skin = document.items("skins")[node["skin"]]
    bind = [np.eye(4)] * len(skin["joints"])
    if "inverseBindMatrices" in skin:
        rows = document.values(skin["inverseBindMatrices"])
        bind = [row.reshape(4, 4).T for row in rows]
    joint = np.array([world[j] @ b for j, b in zip(skin["joints"], bind)])
    which = document.raw(primitive["attributes"]["JOINTS_0"]).astype(np.int64)
    weight = document.values(primitive["attributes"]["WEIGHTS_0"])
    weight = weight / weight.sum(axis=1, keepdims=True)
    return np.einsum("vj,vjab->vab", weight, joint[which])


def placed(document: Document, n: int, primitive: dict[str, Any], x: Values,
           world: dict[int, Values]) -> tuple[Values, bool]:
    """Vertices at their place, and whether the node mirrors its triangles."""
    node = document.items("nodes")[n]
    if "skin" in node and "JOINTS_0" in primitive["attributes"]:
        m = skin_matrices(document, node, primitive, world)
        return np.einsum("vab,vb->va", m[:, :3, :3], x) + m[:, :3, 3], False
    m = world[n]
    return x @ m[:3, :3].T + m[:3, 3], bool(np.linalg.det(m[:3, :3]) < 0)


def gltf_corners(path: Path) -> Values:
    """(triangles, 3, 3) corners of all triangles below the default scene."""
    try:
        document = read_document(path)
    except GlbError as error:
        raise NotRead(str(error)) from error
    packed = UNPACKED & set(document.json.get("extensionsUsed", []))
    if packed:
        raise NotRead(packed.pop())
    world, parts = world_matrices(document), []
    for n in world:
        node = document.items("nodes")[n]
        mesh = document.items("meshes")[node["mesh"]] if "mesh" in node else {"primitives": []}
        for primitive in mesh["primitives"]:
            mode = primitive.get("mode", 4)
            if mode < 4:
                continue
            x = primitive_positions(document, node, mesh, primitive)
            x, mirrored = placed(document, n, primitive, x, world)
            index = np.arange(len(x))
            if "indices" in primitive:
                index = document.raw(primitive["indices"])[:, 0].astype(np.int64)
            corners = x[strip_triangles(index, mode)]
            parts.append(corners[:, ::-1] if mirrored else corners)
    if not parts:
        raise NotRead("no triangles")
    return np.concatenate(parts)


def read_corners(path: Path) -> Values:
    """(triangles, 3, 3) corners of a file, polygons as fans. @raises NotRead"""
    ending = path.suffix.lower()
    if ending in (".glb", ".gltf"):
        return gltf_corners(path)
    if ending not in READERS:
        raise NotRead(ending or "no ending")
    if ending == ".ply" and "face" not in [name for name, _, _ in ply_header(path.read_bytes())[1]]:
        raise NotRead("no triangles")
    mesh = READERS[ending](path)
    triangles = np.array(triangles_of(mesh.faces), np.int64).reshape(-1, 3)
    if not len(triangles):
        raise NotRead("no triangles")
    return mesh.position[triangles]


def without_repeats(triangles: Indices) -> Indices:
    """Of triangles with the same corners the first, however they are wound."""
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    return triangles[np.sort(first)]


def joined(triangles: Indices) -> tuple[list[list[tuple[int, bool]]], int]:
    """The neighbours of each triangle over edges of two, with whether both are wound alike, and the
    number of edges over which they are not."""
    half = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    face = np.tile(np.arange(len(triangles)), 3)
    _, edge, count = np.unique(np.sort(half, axis=1), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(edge, kind="stable")
    order = order[count[edge[order]] == 2]
    one, two = order[::2], order[1::2]
    alike = half[one, 0] != half[two, 0]
    beside: list[list[tuple[int, bool]]] = [[] for _ in triangles]
    for f, g, same in zip(face[one].tolist(), face[two].tolist(), alike.tolist()):
        beside[f].append((g, same))
        beside[g].append((f, same))
    return beside, int((~alike).sum())


def oriented(place: Values, triangles: Indices) -> Indices:
    """Triangles turned so that neighbours agree, where some do not: each piece as most of its area."""
    beside, conflicts = joined(triangles)
    if not conflicts:
        return triangles
    x = place[triangles]
    area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    turned = np.full(len(triangles), -1)
    for start in range(len(triangles)):
        if turned[start] >= 0:
            continue
        turned[start], piece = 0, [start]
        for f in piece:
            for g, same in beside[f]:
                if turned[g] < 0:
                    turned[g] = turned[f] ^ (not same)
                    piece.append(g)
        if (area[piece] * (1 - 2 * turned[piece])).sum() < 0:
            turned[piece] ^= 1
    return np.where(turned[:, None] == 1, triangles[:, ::-1], triangles)


class Surface:
    """Triangles about the middle of their box, in units of its longest edge, equal places joined."""

    def __init__(self, corners: Values) -> None:
        lower, upper = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self.longest = float((upper - lower).max())  # in the file's unit
        places = ((corners - (lower + upper) / 2) / self.longest).reshape(-1, 3)
        self.place, index = np.unique(places, axis=0, return_inverse=True)
        triangles = index.reshape(-1, 3)
        a, b, c = triangles.T
        self.triangles = triangles[(a != b) & (b != c) & (c != a)]

    def repaired(self) -> Surface:
        """Each triangle once, and turned to agree with its neighbours."""
        result = copy.copy(self)
        result.triangles = oriented(self.place, without_repeats(self.triangles))
        return result

    def signed_volume(self) -> float:
        """By the divergence theorem: that of the inside where w is 1 there, of a closed surface."""
        x = self.place[self.triangles]
        return float((x[:, 0] * np.cross(x[:, 1], x[:, 2])).sum() / 6)

    def winding_numbers(self, points: Values) -> Values:
        """w of each of the points (points, 3)."""
        blocks = [self._block(points[k:k + BLOCK_POINTS]) for k in range(0, len(points), BLOCK_POINTS)]
        return np.concatenate(blocks)

    def _block(self, points: Values) -> Values:
        """Of few points: half the solid angles over 2 pi, summed over blocks of triangles."""
        squared = ((self.place[:, None] - points) ** 2).sum(axis=2)  # (places, points)
        length, sum_ = np.sqrt(squared), np.zeros(len(points))
        for k in range(0, len(self.triangles), BLOCK_TRIANGLES):
            t = self.triangles[k:k + BLOCK_TRIANGLES]
            A, B, C = (self.place[t[:, c]] for c in range(3))
            n = np.cross(A, B) + np.cross(B, C) + np.cross(C, A)
            volume = (A * np.cross(B, C)).sum(axis=1)[:, None] - n @ points.T  # det(a, b, c)
            a, b, c = (length[t[:, k]] for k in range(3))
            aa, bb, cc = (squared[t[:, k]] for k in range(3))
            ab, bc, ca = (((P - Q) ** 2).sum(axis=1)[:, None] for P, Q in ((A, B), (B, C), (C, A)))
            # 2 a.b = |a|^2 + |b|^2 - |a - b|^2
            below = a * b * c + ((aa + bb - ab) * c + (bb + cc - bc) * a + (cc + aa - ca) * b) / 2
            sum_ += np.arctan2(volume, below).sum(axis=0)
        return sum_ / (2 * np.pi)
