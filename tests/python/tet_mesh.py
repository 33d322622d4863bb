# SPDX-License-Identifier: Apache-2.0
"""Meshes of tetrahedra on lattices, written as Gmsh MSH 2.2 and as legacy VTK."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # of the middles, in the order of VTK
GMSH = (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)  # Gmsh has the middles of 23 and 13 the other way round


@dataclass(frozen=True)
class TetMesh:
    """Nodes, (nodes, 3), and tetrahedra of positive volume, (tets, 4 or 10)."""

    x: Floats
    tets: NDArray[np.int64]


def lattice(cells: tuple[int, int, int],
            place: Callable[[Floats], Floats] = lambda share: share) -> TetMesh:
    """Six tetrahedra around a diagonal of each cell; nodes at place(shares in 0..1), (n, 3)."""
    shape = np.array(cells) + 1
    index = np.stack(np.unravel_index(np.arange(shape.prod()), shape), 1)
    tets = []
    for cell in np.ndindex(*cells):
        for order in permutations(range(3)):
            path = [np.array(cell)]
            for axis in order:
                path.append(path[-1] + np.eye(3, dtype=int)[axis])
            nodes = [int(np.ravel_multi_index(tuple(p), shape)) for p in path]
            even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            tets.append(nodes if even else [nodes[0], nodes[2], nodes[1], nodes[3]])
    return TetMesh(place(index / np.array(cells)), np.array(tets))


def quadratic(mesh: TetMesh) -> TetMesh:
    """The same with straight edges and a node in the middle of each."""
    middles: dict[tuple[int, int], int] = {}
    rows = [[*tet, *(middles.setdefault((min(tet[a], tet[b]), max(tet[a], tet[b])),
                                        len(mesh.x) + len(middles)) for a, b in EDGES)]
            for tet in mesh.tets.tolist()]
    ends = np.array(list(middles))
    return TetMesh(np.concatenate([mesh.x, mesh.x[ends].mean(1)]), np.array(rows))


def write_msh(path: Path, mesh: TetMesh, groups: list[int] | None = None) -> Path:
    """Gmsh MSH 2.2 in ASCII; groups are the physical groups of the tetrahedra, else 1."""
    kind, order = (4, (0, 1, 2, 3)) if mesh.tets.shape[1] == 4 else (11, GMSH)
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(mesh.x))]
    lines += [f"{n + 1} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(mesh.x.tolist())]
    lines += ["$EndNodes", "$Elements", str(len(mesh.tets))]
    for e, tet in enumerate(mesh.tets.tolist()):
        group = groups[e] if groups else 1
        lines.append(f"{e + 1} {kind} 2 {group} {group} " + " ".join(str(tet[k] + 1)
                                                                     for k in order))
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def write_vtk(path: Path, mesh: TetMesh) -> Path:
    """Legacy VTK in ASCII."""
    count, nodes = mesh.tets.shape
    lines = ["# vtk DataFile Version 3.0", "tetrahedra", "ASCII", "DATASET UNSTRUCTURED_GRID",
             f"POINTS {len(mesh.x)} double"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.x.tolist()]
    lines += [f"CELLS {count} {count * (nodes + 1)}"]
    lines += [f"{nodes} " + " ".join(map(str, tet)) for tet in mesh.tets.tolist()]
    lines += [f"CELL_TYPES {count}", *["10" if nodes == 4 else "24"] * count, ""]
    path.write_text("\n".join(lines))
    return path
