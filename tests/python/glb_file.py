# SPDX-License-Identifier: Apache-2.0
"""Reader and strict checker of glTF 2.0, written from its specification, and the vertices that an
animation of morph target weights gives in each frame.

    x_frame = x_base + sum_k weight_k(frame) target_k

with weights kept within 0 ... 1, as some programs keep them.

A document is what a GLB or a glTF file with its buffers holds. `check_animation` accepts only what
`elastogen animate` promises in docs/formats.md; the first place that differs is named.
"""

from __future__ import annotations

import base64
import json
import struct
import urllib.parse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

COMPONENT = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
TRIANGLES = (4, 5, 6)  # modes: list, strip, fan
ANIMATION = "elastogen"  # the name of ours; those of cameras and lamps stay beside it
CERTIFICATE = ("converged", "residual", "min_j")
# of frames whose errors of time and mesh are estimated
ESTIMATES = ("time_error", "time_ratio", "mesh_error", "mesh_error_trusted")

Values = NDArray[Any]
Played = dict[int, dict[str, Values]]  # by node and path


class GlbError(Exception):
    """The file is not what it should be; the message names the place."""


def require(condition: bool | np.bool_, *message: object) -> None:
    """Raises GlbError with the joined message unless the condition holds."""
    if not condition:
        raise GlbError("".join(str(part) for part in message))


@dataclass(frozen=True)
class Document:
    """The JSON of a file and the bytes of its buffers."""

    json: dict[str, Any]
    buffers: list[bytes]

    def items(self, name: str) -> list[Any]:
        """The array `name` of the document, empty where it has none."""
        return self.json.get(name, [])

    def view(self, index: int) -> bytes:
        """The bytes of a buffer view."""
        views = self.items("bufferViews")
        require(0 <= index < len(views), "there is no buffer view ", index)
        view = views[index]
        start, size = view.get("byteOffset", 0), view["byteLength"]
        require(0 <= view["buffer"] < len(self.buffers), "there is no buffer ", view["buffer"])
        buffer = self.buffers[view["buffer"]]
        require(start >= 0 and size > 0 and start + size <= len(buffer),
                f"bufferViews[{index}] reaches past its buffer")
        return buffer[start : start + size]

    def _elements(self, view: int, offset: int, kind: str, count: int, width: int) -> Values:
        data, size = self.view(view), np.dtype(kind).itemsize
        start = self.items("bufferViews")[view].get("byteOffset", 0)
        stride = self.items("bufferViews")[view].get("byteStride", size * width)
        require((start + offset) % size == 0 and stride % size == 0 and stride >= size * width,
                f"bufferViews[{view}] is not aligned to its components")
        end = offset + stride * (count - 1) + size * width
        require(count >= 1 and offset >= 0 and end <= len(data),
                f"an accessor reaches past bufferViews[{view}]")
        return np.ndarray((count, width), kind, data, offset, (stride, size)).copy()

    def raw(self, index: int) -> Values:
        """An accessor's components as they are stored, (count, width), sparse ones filled in."""
        accessors = self.items("accessors")
        require(0 <= index < len(accessors), "there is no accessor ", index)
        a = accessors[index]
        require(a["componentType"] in COMPONENT and a["type"] in WIDTH,
                f"accessors[{index}] has an unknown type")
        kind, width = COMPONENT[a["componentType"]], WIDTH[a["type"]]
        values = np.zeros((a["count"], width), kind)
        if "bufferView" in a:
            values = self._elements(a["bufferView"], a.get("byteOffset", 0), kind, a["count"],
                                    width)
        if "sparse" in a:
            s = a["sparse"]
            where = self._elements(s["indices"]["bufferView"], s["indices"].get("byteOffset", 0),
                                   COMPONENT[s["indices"]["componentType"]], s["count"], 1)[:, 0]
            require((np.diff(where.astype(np.int64)) > 0).all() and where[-1] < a["count"],
                    f"accessors[{index}]: sparse indices are out of order or range")
            values[where] = self._elements(s["values"]["bufferView"],
                                           s["values"].get("byteOffset", 0), kind, s["count"],
                                           width)
        return values

    def values(self, index: int) -> Values:
        """An accessor as float64, normalised integers mapped to [0, 1] or [-1, 1]."""
        raw = self.raw(index)
        if not self.items("accessors")[index].get("normalized", False):
            return raw.astype(np.float64)
        return np.maximum(raw / float(np.iinfo(raw.dtype).max), -1)


def _parse_json(data: bytes) -> dict[str, Any]:
    def refuse(word: str) -> None:
        raise GlbError(f"the JSON has the number {word}")

    try:
        return json.loads(data.decode("utf-8"), parse_constant=refuse)
    except ValueError as error:
        raise GlbError(f"the JSON cannot be read: {error}") from error


def parse_glb(data: bytes) -> Document:
    """The document of a GLB file: header, a JSON chunk, at most one BIN chunk, nothing else."""
    require(len(data) >= 20, "a GLB file has 20 bytes at least")
    magic, version, size = struct.unpack_from("<4sII", data)
    require(magic == b"glTF" and version == 2, "no GLB header of version 2")
    require(size == len(data), f"the header says {size} bytes, the file has {len(data)}")
    chunks, at = [], 12
    while at < len(data):
        require(at + 8 <= len(data), "the file ends within a chunk's header")
        length, kind = struct.unpack_from("<I4s", data, at)
        require(length % 4 == 0 and at + 8 + length <= len(data), "a chunk has a wrong length")
        chunks.append((kind, data[at + 8 : at + 8 + length]))
        at += 8 + length
    kinds = [kind for kind, _ in chunks]
    require(kinds in ([b"JSON"], [b"JSON", b"BIN\0"]), f"the chunks are {kinds}")
    text = chunks[0][1]
    require(text[:1] == b"{" and text.rstrip()[-1:] == b"}", "the JSON is not padded by blanks")
    document = _parse_json(text)
    buffers = document.get("buffers", [])
    require(len(buffers) <= 1 and len(buffers) >= len(chunks) - 1, "a GLB file has one buffer")
    if not buffers:
        return Document(document, [])
    binary, length = chunks[1][1] if len(chunks) == 2 else b"", buffers[0]["byteLength"]
    require("uri" not in buffers[0] and length <= len(binary) <= length + 3,
            f"buffers[0] has {length} bytes, its chunk {len(binary)}")
    return Document(document, [binary[:length]])


def read_document(path: Path) -> Document:
    """A GLB file, or a glTF file with the buffers that lie beside it."""
    data = path.read_bytes()
    if data[:4] == b"glTF":
        return parse_glb(data)
    document, buffers = _parse_json(data), []
    for buffer in document.get("buffers", []):
        uri = buffer["uri"]
        if uri.startswith("data:"):
            buffers.append(base64.b64decode(uri.split(",", 1)[1]))
        else:
            buffers.append((path.parent / urllib.parse.unquote(uri)).read_bytes())
    return Document(document, buffers)


def local_matrix(node: dict[str, Any]) -> Values:
    """(4, 4) matrix of a node to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def world_matrices(document: Document, played: Played | None = None) -> dict[int, Values]:
    """(4, 4) matrix to the root of each node below the default scene; a tree is required."""
    scenes, nodes = document.items("scenes"), document.items("nodes")
    require(bool(scenes), "the document has no scene")
    world: dict[int, Values] = {}
    stack = [(n, np.eye(4)) for n in scenes[document.json.get("scene", 0)].get("nodes", [])]
    while stack:
        n, parent = stack.pop()
        require(0 <= n < len(nodes), "there is no node ", n)
        require(n not in world, f"nodes[{n}] has two parents")
        world[n] = parent @ local_matrix({**nodes[n], **(played or {}).get(n, {})})
        stack += [(child, world[n]) for child in nodes[n].get("children", [])]
    return world


def record(document: Document) -> dict[str, Any]:
    """What `elastogen animate` says of the clip; empty in other files."""
    return document.json["asset"].get("extras", {}).get("elastogen", {})


def frame_count(document: Document) -> int:
    """Frames that the certificates of the document name, the rest frame included."""
    return len(record(document)["frames"])


def channels(document: Document) -> list[tuple[int, str, dict[str, Any]]]:
    """Node, path and sampler of each channel: of the animation that we wrote, in files of others of
    all."""
    ours = record(document)
    return [(channel["target"]["node"], channel["target"]["path"],
             animation["samplers"][channel["sampler"]])
            for animation in document.items("animations")
            if not ours or animation.get("name") == ANIMATION for channel in animation["channels"]]


def sample(document: Document, sampler: dict[str, Any], time: float) -> Values:
    """The value at a time: by steps or linear between keys, held before the first and behind the
    last."""
    keys = document.values(sampler["input"])[:, 0]
    rows = document.values(sampler["output"]).reshape(len(keys), -1)
    after = int(np.searchsorted(keys, np.float32(time), side="right"))
    if after in (0, len(keys)) or sampler.get("interpolation", "LINEAR") == "STEP":
        return rows[max(after - 1, 0)]
    share = (time - keys[after - 1]) / (keys[after] - keys[after - 1])
    return (1 - share) * rows[after - 1] + share * rows[after]


def frame_time(document: Document, frame: int) -> float:
    """Of a frame, in float32 as keys are [s]."""
    fps = record(document).get("fps")
    if fps:
        return float(np.float32(frame / fps))
    keys = [document.values(sampler["input"])[:, 0] for _, _, sampler in channels(document)]
    return float(np.unique(np.concatenate(keys))[frame]) if keys else 0.0


def play(document: Document, frame: int) -> Played:
    """What the channels give each animated node in one frame, weights kept within 0 ... 1 as
    Blender keeps them."""
    played: Played = {}
    for node, path, sampler in channels(document):
        value = sample(document, sampler, frame_time(document, frame))
        played.setdefault(node, {})[path] = np.clip(value, 0, 1) if path == "weights" else value
    return played


def local_positions(document: Document, frame: int) -> dict[tuple[int, int], Values]:
    """(vertices, 3) positions in the mesh's numbers by (node, primitive) in one frame, of nodes
    that no animated scale of 0 hides."""
    played, result = play(document, frame), {}
    for n in world_matrices(document):
        node, now = document.items("nodes")[n], played.get(n, {})
        if "mesh" not in node or not np.any(now.get("scale", 1)):
            continue
        for p, primitive in enumerate(document.items("meshes")[node["mesh"]]["primitives"]):
            x = document.values(primitive["attributes"]["POSITION"])
            for weight, target in zip(now.get("weights", []), primitive.get("targets", [])):
                if weight != 0:
                    x = x + weight * document.values(target["POSITION"])
            result[n, p] = x
    return result


def world_positions(document: Document, frame: int) -> dict[tuple[int, int], Values]:
    """The same after the nodes' matrices: what a viewer shows."""
    world = world_matrices(document, play(document, frame))
    return {(n, p): x @ world[n][:3, :3].T + world[n][:3, 3]
            for (n, p), x in local_positions(document, frame).items()}
