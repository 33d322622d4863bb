#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the shapes that the scenes of ladder.py and stress.py add: `shapes_small.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from runs import HERE
from shapes import Floats, box

Mesh = tuple[Floats, list[tuple[int, ...]]]


def boxes(*placed: tuple[Floats, Floats]) -> Mesh:
    """Separate boxes by their lower corners and edges [m]."""
    vertices, faces = [], []
    for lower, edges in placed:
        corner, faces_of_one = box(*edges)
        faces += [tuple(v + 8 * len(vertices) for v in face) for face in faces_of_one]
        vertices.append(corner + lower)
    return np.concatenate(vertices), faces


VERIFICATION = {"sheet": box(1, 0.05, 0.2), "rod": box(120 / 64, 1 / 64, 1 / 64),
                "wire": box(25 / 64, 1 / 64, 1 / 64), "column": box(2, 80, 2)}


def cubes(*cells: tuple[int, int, int]) -> Mesh:
    """Cubes of 0.1 m at places of a lattice."""
    return boxes(*((np.array(cell) * 0.1, np.full(3, 0.1)) for cell in cells))


STRESS = {
    "beam": box(0.3, 0.1, 0.1), "post": box(0.1, 0.15, 0.1), "hanging": box(0.1, 0.8, 0.1),
    "tower": box(0.3, 0.6, 0.3), "standing": box(0.1, 0.6, 0.1), "cube": box(0.2, 0.2, 0.2),
    "plank": box(0.25, 0.075, 0.075),
    "far": boxes((np.array([0.25e6, 0.25e6, -0.25e6]), np.array([0.25, 0.075, 0.075]))),
    "voxel": cubes((0, 0, 0)), "edge": cubes((0, 0, 0), (1, 1, 0)),
    "corner": cubes((0, 0, 0), (1, 1, 1)),
    "checkerboard": cubes(*((i, j, k) for i in range(4) for j in range(4) for k in range(4)
                            if (i + j + k) % 2 == 0)),
    "flat": box(0.2, 0.2, 0.0)}


def write(path: Path, mesh: Mesh) -> Path:
    """A mesh as OBJ."""
    vertices, faces = mesh
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_all(folder: str, shapes: dict[str, Mesh]) -> None:
    """Each shape as OBJ with all digits of its numbers."""
    for name, mesh in shapes.items():
        write(HERE / folder / f"{name}.obj", mesh)


if __name__ == "__main__":
    write_all("verification", VERIFICATION)
    write_all("stress", STRESS)
