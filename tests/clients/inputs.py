# SPDX-License-Identifier: Apache-2.0
"""What is animated for the clients, and how."""

from __future__ import annotations

import json
import os
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

PROFILES = ("modal", "keyframe")
MOTION = ("--floor", "--spin", "1,3,2", "--material", "jelly", "--size", "1m")


@dataclass(frozen=True)
class Input:
    """One asset and its run; `path` is below the folder of assets, "" for one that is made."""

    name: str
    path: str
    frames: int = 24
    voxels: int = 12
    fps: int = 24
    up: str = "y"
    velocity: str = "0.5,-1,0.3"

    def source(self, folder: Path) -> Path | None:
        """The file, made if need be; None where there is none."""
        if not self.path:
            return write_shared_mesh(folder / "shared_mesh.glb")
        assets = os.environ.get("ELASTOGEN_ASSETS")
        file = Path(assets) / self.path if assets else None
        return file if file and file.is_file() else None


INPUTS = (
    Input("spot", "closed/spot.obj"),
    Input("trellis", "generators/trellis_sample.glb"),
    Input("truck", "gltf/CesiumMilkTruck.glb"),
    Input("instances", "gltf/spot_nodes.glb", fps=30),
    Input("shared_mesh", ""),
    Input("fox", "gltf/Fox.glb", fps=30),
    Input("zup", "broken/spot_zup.stl", up="z", velocity="0.5,0.3,-1"),
    Input("fox_long", "gltf/Fox.glb", frames=300, voxels=8, fps=30),
    Input("nested", "gltf/nested.glb"),
)


def box(steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions and normals (vertices, 3) and triangles (count, 3) of a box of edges 1, 0.4, 0.4
    at the origin, each side cut into steps x steps quads."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, steps + 1), np.linspace(-0.5, 0.5, steps + 1))
    positions, normals, triangles = [], [], []
    a, b = np.divmod(np.arange(steps * steps), steps)
    quad = np.stack([a, a + 1, a + 1, a]) * (steps + 1) + np.stack([b, b, b + 1, b + 1])
    for axis in range(3):
        for sign in (-1.0, 1.0):
            side = np.zeros((u.size, 3))
            side[:, axis], side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = (
                0.5 * sign, u.ravel(), v.ravel())
            corner = quad if sign < 0 else quad[::-1]
            first = sum(len(x) for x in positions)
            triangles += [first + corner[[0, 1, 2]].T, first + corner[[0, 2, 3]].T]
            positions.append(side * [1, 0.4, 0.4])
            normals.append(np.tile(np.eye(3)[axis] * sign, (u.size, 1)))
    return np.concatenate(positions), np.concatenate(normals), np.concatenate(triangles)


def write_shared_mesh(path: Path) -> Path:
    """Two nodes of one name that show one mesh side by side, the second turned."""
    positions, normals, triangles = box(4)
    data = [positions.astype("<f4"), normals.astype("<f4"), triangles.astype("<u2").ravel()]
    views, at = [], 0
    for array in data:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": array.nbytes})
        at += array.nbytes
    count = len(positions)
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "Arm"},
                  {"mesh": 0, "name": "Arm", "translation": [1.5, 0, 0],
                   "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]}],
        "meshes": [{"name": "Arm", "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
             "min": data[0].min(0).tolist(), "max": data[0].max(0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": triangles.size, "type": "SCALAR"}],
        "bufferViews": views, "buffers": [{"byteLength": at}]}
    path.write_bytes(glb_bytes(document, b"".join(array.tobytes() for array in data)))
    return path


def glb_bytes(document: dict, binary: bytes) -> bytes:
    """A GLB file of a document and the bytes of its buffer."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    size = 12 + 8 + len(text) + 8 + len(binary)
    return (struct.pack("<4sII", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def animate(binary: Path, item: Input, source: Path, profile: str, stem: Path) -> str:
    """Writes STEM.glb and STEM.pc2. @return what went wrong, or an empty text."""
    words = [str(binary), "animate", str(source), *MOTION, "--quiet",
             "--velocity", item.velocity,
             "--voxels", str(item.voxels), "--frames", str(item.frames), "--fps", str(item.fps),
             "--glb-profile", profile, "-o", f"{stem}.glb", "-o", f"{stem}.pc2"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode in (0, 4):  # 4: steps that did not converge, written all the same
        return ""
    return f"exit code {done.returncode}: {done.stderr.strip()[-200:]}"
