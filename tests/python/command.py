# SPDX-License-Identifier: Apache-2.0
"""Runs the command `elastogen` (path in ELASTOGEN_BINARY) and writes small meshes for it."""

from __future__ import annotations

import json
import os
import struct
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

BINARY = os.environ["ELASTOGEN_BINARY"]
ROUND_TRIP = os.environ.get("ELASTOGEN_ROUND_TRIP", str(Path(BINARY).parent / "round_trip"))
CODES = {0, 2, 3, 4, 5, 6, 7, 130, 143}  # docs/user_guide.md

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """Exit code and what was printed; the code is -1 where the time was over."""

    code: int
    out: str
    err: str


def run(*arguments: object, timeout: float = 120) -> Run:
    """The command with these words; it is killed after `timeout` seconds."""
    words = [BINARY, *(str(word) for word in arguments)]
    try:
        done = subprocess.run(words, capture_output=True, timeout=timeout, check=False,
                              text=True, errors="replace")
    except subprocess.TimeoutExpired:
        return Run(-1, "", f"killed after {timeout} s")
    return Run(done.returncode, done.stdout, done.stderr)


def animate(source: Path, output: Path, *options: object, timeout: float = 120) -> Run:
    """`elastogen animate SOURCE OPTIONS -o OUTPUT --quiet`."""
    return run("animate", source, *options, "-o", output, "--quiet", timeout=timeout)


def round_trip(path: Path) -> str:
    """What two libraries of others see differently in a GLB, or ""."""
    done = subprocess.run([ROUND_TRIP, path], capture_output=True, timeout=60, check=False,
                          text=True, errors="replace")
    return done.stderr if done.returncode else ""


def turned_box(edges: Sequence[float], axis: Sequence[float], degrees: float) -> tuple[
        Floats, list[list[int]]]:
    """Positions (8, 3) of a box about the origin turned about an axis, and its six quads."""
    corner = (((np.arange(8)[:, None] >> np.arange(3)) & 1) - 0.5) * np.array(edges)
    n, angle = np.array(axis) / np.linalg.norm(axis), np.radians(degrees)
    turned = (corner * np.cos(angle) + np.cross(n, corner) * np.sin(angle)
              + np.outer(corner @ n, n) * (1 - np.cos(angle)))
    return turned, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2],
                    [1, 3, 7, 5]]


def write_obj(path: Path, position: Floats, faces: list[list[int]]) -> Path:
    """A text OBJ with all digits."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in position.tolist()]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def triangles_of(faces: list[list[int]]) -> list[list[int]]:
    """Fans of convex faces."""
    return [[face[0], face[k], face[k + 1]] for face in faces for k in range(1, len(face) - 1)]


def write_ply(path: Path, position: Floats, faces: list[list[int]], encoding: str) -> Path:
    """ascii, binary_little_endian or binary_big_endian."""
    head = (f"ply\nformat {encoding} 1.0\nelement vertex {len(position)}\nproperty float x\n"
            f"property float y\nproperty float z\nelement face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n").encode()
    if encoding == "ascii":
        lines = [f"{x} {y} {z}" for x, y, z in position.astype(np.float32).tolist()]
        lines += [" ".join(map(str, [len(face), *face])) for face in faces]
        path.write_bytes(head + "\n".join(lines).encode() + b"\n")
        return path
    order = ">" if encoding == "binary_big_endian" else "<"
    body = position.astype(order + "f4").tobytes()
    body += b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in faces)
    path.write_bytes(head + body)
    return path


def write_stl(path: Path, position: Floats, faces: list[list[int]], text: bool) -> Path:
    """Three vertices a facet; normals are zero."""
    facets = position[triangles_of(faces)].astype("<f4")
    if text:
        lines = ["solid test"]
        for facet in facets.tolist():
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in facet]
            lines += ["endloop", "endfacet"]
        path.write_text("\n".join([*lines, "endsolid test"]) + "\n")
        return path
    rows = b"".join(bytes(12) + facet.tobytes() + bytes(2) for facet in facets)
    path.write_bytes(bytes(80) + struct.pack("<I", len(facets)) + rows)
    return path


def glb_bytes(document: dict[str, Any], binary: bytes) -> bytes:
    """A GLB file of a document and the bytes of its buffer."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    size = 12 + 8 + len(text) + 8 + len(binary)
    return (struct.pack("<4sII", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def glb_parts(position: Floats, faces: list[list[int]]) -> tuple[dict[str, Any], bytes]:
    """Document and buffer of one mesh at one node, to be changed or written by glb_bytes()."""
    x = position.astype("<f4")
    index = np.array(triangles_of(faces), "<u2").ravel()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "box"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(x), "type": "VEC3",
             "min": x.min(0).tolist(), "max": x.max(0).tolist()},
            {"bufferView": 1, "componentType": 5123, "count": len(index), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": x.nbytes},
                        {"buffer": 0, "byteOffset": x.nbytes, "byteLength": index.nbytes}],
        "buffers": [{"byteLength": x.nbytes + index.nbytes}]}
    return document, x.tobytes() + index.tobytes()
