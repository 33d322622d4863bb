# SPDX-License-Identifier: Apache-2.0
"""Small readers of OBJ, PLY and STL, written from the formats, and what must survive in the GLB.

Only well-formed files are read; the readers of the program are tested elsewhere. A drawn corner is
(position, uv) as the GLB would have it: uv with v counted from the top.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
             "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2",
             "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"}


@dataclass
class SourceMesh:
    """Positions in the file's order, one list of position and uv indices a face, materials."""

    position: Values  # (vertices, 3)
    faces: list[list[int]]  # three corners or more
    uv: Values | None = None  # (uvs, 2)
    face_uv: list[list[int]] = field(default_factory=list)  # as faces, -1 for none; or empty
    material: list[str] = field(default_factory=list)  # of each face, "" for none; or empty

    def triangles(self) -> Counter[str]:
        """Triangles of each material's polygons."""
        names = self.material or [""] * len(self.faces)
        count: Counter[str] = Counter()
        for name, face in zip(names, self.faces):
            count[name] += len(face) - 2
        return count

    def uvs(self) -> Values:
        """(pairs, 3) distinct pairs of position index and uv that faces use."""
        assert self.uv is not None
        index = np.concatenate([np.array(face) for face in self.faces])
        if not self.face_uv:
            pair = np.column_stack([index, self.uv[index]])
        else:
            which = np.concatenate([np.array(face) for face in self.face_uv])
            pair = np.column_stack([index, np.where(which[:, None] < 0, 0, self.uv[which])])
        return np.unique(pair.astype(np.float64), axis=0)


def statements(text: str) -> list[list[str]]:
    """Words of each line, comments cut, continued lines joined."""
    lines = text.replace("\r", "").replace("\\\n", " ").split("\n")
    words = [line.split("#", 1)[0].split(None, 1) for line in lines]
    return [word for word in words if word]


def read_obj(path: Path) -> SourceMesh:
    """Positions, texture coordinates, faces of three corners and more, names of `usemtl`."""
    position, uv, mesh, name = [], [], SourceMesh(np.empty((0, 3)), []), ""
    counts = {"v": position, "t": uv}
    for keyword, *rest in statements(path.read_text(errors="replace")):
        words = rest[0].split() if rest else []
        if keyword == "v":
            position.append([float(w) for w in words[:3]])
        elif keyword == "vt":
            uv.append([float(w) for w in (words + ["0"])[:2]])
        elif keyword == "usemtl":
            name = rest[0].strip() if rest else ""
        elif keyword == "f" and len(words) >= 3:
            parts = [(word + "/").split("/")[:2] for word in words]

            def index(word: str, kind: str) -> int:
                return -1 if not word else int(word) + (len(counts[kind]) if word[0] == "-" else -1)

            mesh.faces.append([index(v, "v") for v, _ in parts])
            mesh.face_uv.append([index(t, "t") for _, t in parts])
            mesh.material.append(name)
    mesh.position = np.array(position, float)
    if any(t >= 0 for face in mesh.face_uv for t in face):
        mesh.uv = flipped(np.array(uv, np.float32))
    else:
        mesh.face_uv = []
    return mesh


def flipped(uv: NDArray[np.float32]) -> Values:
    """v counted from the top, in single precision as glTF has it."""
    uv[:, 1] = np.float32(1) - uv[:, 1]
    return uv.astype(np.float64)


def ply_header(data: bytes) -> tuple[str, list[tuple[str, int, list[list[str]]]], int]:
    """Encoding, elements (name, count, properties as words), bytes of the header."""
    end = data.index(b"end_header")
    end = data.index(b"\n", end) + 1
    elements: list[tuple[str, int, list[list[str]]]] = []
    encoding = ""
    for line in data[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            encoding = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    return encoding, elements, end


class PlyBody:
    """Values of a PLY file, text or binary, one after the other."""

    def __init__(self, data: bytes, encoding: str) -> None:
        self.words = iter(data.split()) if encoding == "ascii" else None
        self.data, self.at = data, 0
        self.order = ">" if encoding == "binary_big_endian" else "<"

    def next(self, kind: str, count: int) -> list[float]:
        if self.words is not None:
            return [float(next(self.words)) for _ in range(count)]
        dtype = np.dtype(self.order + PLY_TYPES[kind])
        values = np.frombuffer(self.data, dtype, count, self.at)
        self.at += dtype.itemsize * count
        return values.tolist()

    def row(self, properties: list[list[str]]) -> dict[str, list[float]]:
        """One element's values by the names of its properties."""
        result = {}
        for words in properties:
            count = int(self.next(words[1], 1)[0]) if words[0] == "list" else 1
            result[words[-1]] = self.next(words[-2], count)
        return result


def read_ply(path: Path) -> SourceMesh:
    """Vertices with x, y, z and uv where there are some, and faces."""
    data = path.read_bytes()
    encoding, elements, start = ply_header(data)
    body, mesh, rows = PlyBody(data[start:], encoding), SourceMesh(np.empty((0, 3)), []), []
    for name, count, properties in elements:
        for _ in range(count):
            row = body.row(properties)
            if name == "vertex":
                rows.append(row)
            elif name == "face":
                corners = row.get("vertex_indices", row.get("vertex_index", []))
                mesh.faces += [[int(c) for c in corners]] if len(corners) >= 3 else []
    mesh.position = np.array([[row[k][0] for k in "xyz"] for row in rows])
    for u, v in (("s", "t"), ("u", "v"), ("texture_u", "texture_v")):
        if rows and u in rows[0]:
            mesh.uv = flipped(np.array([[r[u][0], r[v][0]] for r in rows], np.float32))
            break
    return mesh


def read_stl(path: Path) -> SourceMesh:
    """Three positions a facet, text or binary."""
    data = path.read_bytes()
    facets = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * facets:
        kind = np.dtype([("n", "<f4", 3), ("x", "<f4", (3, 3)), ("a", "<u2")])
        position = np.frombuffer(data, kind, facets, 84)["x"].reshape(-1, 3).astype(float)
    else:
        lines = (line.split() for line in data.decode("utf-8", "replace").splitlines())
        position = np.array([[float(x) for x in words[1:4]] for words in lines
                             if words and words[0].lower() == "vertex"])
    return SourceMesh(position, np.arange(len(position)).reshape(-1, 3).tolist())


def read_off(path: Path) -> SourceMesh:
    """Positions and faces in the file's order."""
    lines = [line.split("#")[0].split() for line in path.read_text().splitlines()]
    rows = [words for words in lines if words][1:]
    vertices, faces = int(rows[0][0]), int(rows[0][1])
    position = np.array([[float(x) for x in row[:3]] for row in rows[1:vertices + 1]])
    return SourceMesh(position, [[int(k) for k in row[1:int(row[0]) + 1]]
                                 for row in rows[vertices + 1:vertices + faces + 1]])


READERS = {".obj": read_obj, ".ply": read_ply, ".stl": read_stl, ".off": read_off}
