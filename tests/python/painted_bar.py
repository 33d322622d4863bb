# SPDX-License-Identifier: Apache-2.0
"""A bar whose first fifth is a node, a material, a group and painted vertices of its own, as files."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from command import Floats, glb_bytes

END = 0.2  # [m], of the part; the bar is 1 x 0.2 x 0.2 m
PLACES = (0, END, 0.6, 1)  # of rings of four vertices


def rings() -> tuple[Floats, list[list[int]], list[list[int]]]:
    """Positions (16, 3), quads of the part, quads of the rest."""
    corner = [(y, z) for z in (0, 0.2) for y in (0, 0.2)]
    position = np.array([(x, *yz) for x, yz in itertools.product(PLACES, corner)])
    sides = [[[4 * r + k for k in quad] for quad in ((0, 4, 5, 1), (1, 5, 7, 3), (3, 7, 6, 2), (2, 6, 4, 0))]
             for r in range(3)]
    return position, [[0, 1, 3, 2], *sides[0]], [*sides[1], *sides[2], [12, 14, 15, 13]]


def held() -> NDArray[np.bool_]:
    """Of each vertex, whether it is painted."""
    return rings()[0][:, 0] <= END


def write_obj_bar(path: Path) -> Path:
    """Groups `grip` and `rest` of the object `bar`; painted vertices are red, the others white."""
    position, part, rest = rings()
    lines = [f"v {x} {y} {z} " + ("1 0 0" if painted else "1 1 1")
             for (x, y, z), painted in zip(position.tolist(), held())]
    lines += ["o bar"]
    for name, faces in (("grip", part), ("rest", rest)):
        lines += [f"g {name}", *("f " + " ".join(str(i + 1) for i in face) for face in faces)]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_ply_bar(path: Path) -> Path:
    """Colours as in the OBJ, and a property `weight`, 1 where it is painted."""
    position, part, rest = rings()
    head = ["ply", "format ascii 1.0", f"element vertex {len(position)}",
            *(f"property float {axis}" for axis in "xyz"),
            *(f"property uchar {channel}" for channel in ("red", "green", "blue")),
            "property float weight", f"element face {len(part + rest)}",
            "property list uchar int vertex_indices", "end_header"]
    rows = [f"{x} {y} {z} " + ("255 0 0 1" if painted else "255 255 255 0")
            for (x, y, z), painted in zip(position.tolist(), held())]
    rows += [" ".join(map(str, [4, *face])) for face in part + rest]
    path.write_text("\n".join(head + rows) + "\n")
    return path


def write_glb_bar(path: Path) -> Path:
    """Nodes `grip` below `hand`, and `rest`, with materials `Rubber` and `Wood`, colours, and _MASK,
    whose second component is 1 where it is painted."""
    position, part, rest = rings()
    paint = held()
    binary, views, accessors = b"", [], []

    def add(values: NDArray[Any], kind: str) -> int:
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes})
        binary += values.tobytes()
        component = {"<f4": 5126, "<u4": 5125}[values.dtype.str]
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(values),
                          "type": kind})
        return len(accessors) - 1

    meshes = []
    for material, faces in enumerate((part, rest)):
        used = sorted({i for face in faces for i in face})
        x = position[used].astype("<f4")
        red = np.where(paint[used, None], [1, 0, 0, 1], [1, 1, 1, 1]).astype("<f4")
        mask = np.stack([np.zeros(len(used)), paint[used]], 1).astype("<f4")
        corner = [used.index(f[k]) for f in faces for k in (0, 1, 2, 0, 2, 3)]
        attributes = {"POSITION": add(x, "VEC3"), "COLOR_0": add(red, "VEC4"), "_MASK": add(mask, "VEC2")}
        accessors[attributes["POSITION"]].update(min=x.min(0).tolist(), max=x.max(0).tolist())
        meshes.append({"primitives": [{"attributes": attributes, "material": material,
                                       "indices": add(np.array(corner, "<u4"), "SCALAR")}]})
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
                "nodes": [{"name": "hand", "children": [1]}, {"name": "grip", "mesh": 0},
                          {"name": "rest", "mesh": 1}],
                "materials": [{"name": "Rubber"}, {"name": "Wood"}], "meshes": meshes,
                "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
    path.write_bytes(glb_bytes(document, binary))
    return path
