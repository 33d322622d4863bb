# SPDX-License-Identifier: Apache-2.0
"""Reads what the command writes of particles: PLY, OBJ, VTU and state files, by the documentation
alone."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
PLY_TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4"}
VTU_TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1"}

# dataset -> (type, shape); P particles, T steps, R = T + 1 entries, M materials, C colliders
STATE: dict[str, tuple[str, tuple[Any, ...]]] = {
    "particles/mass": ("f8", ("P",)), "particles/volume": ("f8", ("P",)),
    "particles/material": ("i4", ("P",)), "particles/x": ("f8", ("R", "P", 3)),
    "particles/v": ("f8", ("R", "P", 3)), "particles/F": ("f8", ("R", "P", 9)),
    "particles/C": ("f8", ("R", "P", 9)), "particles/memory": ("f8", ("R", "P")),
    "plastic/yields": ("f8", ("M", 5)), "steps/time": ("f8", ("R",)),
    "steps/residual": ("f8", ("T",)), "steps/converged": ("u1", ("T",)),
    "steps/scheme": ("u1", ("T",)), "steps/outer": ("i4", ("T",)), "steps/inner": ("i4", ("T",)),
    "steps/ms": ("f8", ("T",)), "steps/min_j": ("f8", ("T",)),
    **{f"steps/energy_{part}": ("f8", ("T",))
       for part in ("kinetic", "elastic", "hourglass", "gravity", "contact")}}
CONTACT: dict[str, tuple[str, tuple[Any, ...]]] = {
    "contact/shape": ("u1", ("C",)), "contact/centre": ("f8", ("C", 3)),
    "contact/normal": ("f8", ("C", 3)), "contact/radius": ("f8", ("C",)),
    "contact/half": ("f8", ("C", 3)), "contact/friction": ("f8", ("C",)),
    "contact/name": ("S", ("C",)), "contact/offset": ("f8", ("R", "C", 3))}
WORDS = {"format": "elastogen-state", "element": "particle", "solver": "mpm", "time_scheme": "euler",
         "energy": "analytic"}


@dataclass(frozen=True)
class Points:
    """Columns of the vertices of a PLY, and its triangles where it has faces."""

    column: dict[str, NDArray[Any]]
    triangles: Ints | None

    @property
    def x(self) -> Floats:
        """Positions, (vertices, 3)."""
        return np.column_stack([self.column[a] for a in "xyz"]).astype(float)

    @property
    def v(self) -> Floats:
        """Velocities, (vertices, 3)."""
        return np.column_stack([self.column["v" + a] for a in "xyz"]).astype(float)

    @property
    def colour(self) -> Ints:
        """Red, green, blue, (vertices, 3)."""
        return np.column_stack([self.column[c] for c in ("red", "green", "blue")]).astype(int)


def read_ply(path: Path) -> Points:
    """A binary PLY of points, or of triangles."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    counts = {words[1]: int(words[2]) for words in lines if words[0] == "element"}
    kinds = [(w[2], PLY_TYPES[w[1]]) for w in lines if w[0] == "property" and w[1] != "list"]
    rows = np.frombuffer(body, kinds, counts["vertex"])
    faces = np.frombuffer(body[rows.nbytes:], [("corners", "u1"), ("corner", "<i4", 3)])
    assert len(faces) == counts.get("face", 0) and (faces["corners"] == 3).all()
    column = {name: rows[name] for name, _ in kinds}
    return Points(column, faces["corner"].astype(int) if "face" in counts else None)


def read_obj(path: Path) -> tuple[Floats, Floats, Ints]:
    """Positions, colours behind them, triangles."""
    words = [line.split() for line in path.read_text().splitlines()]
    vertex = np.array([[float(x) for x in w[1:]] for w in words if w[0] == "v"])
    triangles = np.array([[int(k) - 1 for k in w[1:]] for w in words if w[0] == "f"])
    return vertex[:, :3], vertex[:, 3:], triangles


def read_vtu(path: Path) -> dict[str, NDArray[Any]]:
    """The appended arrays of a VTU file."""
    data = path.read_bytes()
    start = data.index(b'<AppendedData encoding="raw">\n_') + len(b'<AppendedData encoding="raw">\n_')
    found = {}
    for kind, name, columns, offset in re.findall(
            rb'<DataArray type="(\w+)" Name="(\w+)" NumberOfComponents="(\d+)" format="appended" '
            rb'offset="(\d+)"/>', data[:start]):
        at = start + int(offset)
        size = int.from_bytes(data[at:at + 8], "little")
        values = np.frombuffer(data[at + 8:at + 8 + size], VTU_TYPES[kind.decode()])
        found[name.decode()] = values.reshape(-1, int(columns)) if int(columns) > 1 else values
    return found


def read_state(path: Path) -> dict[str, Any]:
    """Every dataset by its place, and the attributes of the root, after checking that each is there
    with its type and shape and nothing else is."""
    found: dict[str, Any] = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, node: found.update({name: node[()]})
                        if isinstance(node, h5py.Dataset) else None)
        attributes = dict(file.attrs)
    layout = STATE | (CONTACT if "contact/shape" in found else {})
    assert set(found) == set(layout) | {"materials"}, set(found) ^ set(layout)
    sizes: dict[Any, int] = {}
    for name, (kind, shape) in layout.items():
        values = found[name]
        assert values.dtype.kind == kind[0] and len(values.shape) == len(shape), name
        for letter, size in zip(shape, values.shape):
            assert size == (letter if isinstance(letter, int) else sizes.setdefault(letter, size)), name
    assert sizes["R"] == sizes["T"] + 1 and sizes["M"] == len(found["materials"])
    for name, word in WORDS.items():
        text = attributes[name]
        assert (text.decode().rstrip("\0") if isinstance(text, bytes) else text) == word, name
    return found | attributes


def enclosed_volume(x: Floats, triangles: Ints) -> float:
    """Volume within triangles that face outwards."""
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def is_closed(triangles: Ints) -> bool:
    """Whether every edge is there as often in one direction as in the other."""
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    sign = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    _, which = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    return not np.bincount(which.reshape(-1), weights=sign).any()
