#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The metal frame of PlasticityNet's scenes (Li et al. 2022: a box of 0.1 m x 0.18 m; the rest is ours):
`frame_mesh.py 2d FILE.msh` writes its triangles, `3d` its tetrahedra, six a cell.

Squares of 4 mm, three across a wall. The side walls bow outward by 2 mm, so that they buckle one way;
diagonals are those of a mirror."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from runs import HERE

sys.path.insert(0, str(HERE.parent / "python"))
from tet_mesh import Floats, TetMesh, lattice, write_msh  # noqa: E402

EDGE, CELLS, WALL, DEPTH = 0.004, (25, 45), 3, 10  # [m], cells across, up, in a wall and deep
BOW = 0.002  # [m]


def is_wall(cell: tuple[int, int]) -> bool:
    """Whether a cell of the outer rectangle is one of the frame."""
    return any(k < WALL or k >= n - WALL for k, n in zip(cell, CELLS))


def bowed(x: Floats) -> Floats:
    """Places of the straight frame with its side walls bowed, about x = 0 [m]."""
    width, height = (EDGE * n for n in CELLS)
    x = x - [width / 2, 0, 0]
    x[:, 0] += BOW * x[:, 0] / (width / 2) * np.sin(np.pi * x[:, 1] / height)
    return np.round(x, 9)


def used(x: Floats, elements: np.ndarray) -> TetMesh:
    """Without the nodes that no element has."""
    nodes, places = np.unique(elements, return_inverse=True)
    return TetMesh(bowed(x[nodes]), places.reshape(elements.shape))


def triangles() -> TetMesh:
    """Two triangles a square, their diagonals turned at the middle."""
    shape = (CELLS[0] + 1, CELLS[1] + 1)
    x = np.stack([*np.unravel_index(np.arange(np.prod(shape)), shape),
                  np.zeros(np.prod(shape))], 1) * EDGE
    rows = []
    for i, j in filter(is_wall, np.ndindex(*CELLS)):
        a, b, c, d = (int(np.ravel_multi_index(p, shape))
                      for p in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
        left = i < CELLS[0] / 2
        rows += [[a, b, c], [a, c, d]] if left else [[a, b, d], [b, c, d]]
    return used(x, np.array(rows))


def tets() -> TetMesh:
    """Six tetrahedra a cube."""
    cells = (*CELLS, DEPTH)
    mesh = lattice(cells, lambda share: share * np.array(cells) * EDGE)
    corners = mesh.x[mesh.tets].mean(1) // EDGE
    kept = [is_wall((int(i), int(j))) for i, j, _ in corners]
    return used(mesh.x, mesh.tets[kept])


def write_triangles(path: Path, mesh: TetMesh) -> Path:
    """Gmsh MSH 2.2 in ASCII."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(mesh.x))]
    lines += [f"{n + 1} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(mesh.x.tolist())]
    lines += ["$EndNodes", "$Elements", str(len(mesh.tets))]
    lines += [f"{e + 1} 2 2 1 1 {a + 1} {b + 1} {c + 1}"
              for e, (a, b, c) in enumerate(mesh.tets.tolist())]
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def main() -> None:
    """Writes one of them."""
    kind, path = sys.argv[1:]
    if kind == "2d":
        write_triangles(Path(path), triangles())
    else:
        write_msh(Path(path), tets())


if __name__ == "__main__":
    main()
