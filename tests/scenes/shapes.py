# SPDX-License-Identifier: Apache-2.0
"""Writes the shapes of the scenes in tests/scenes/verification: `shapes.py FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BOX_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def box(length: float, width: float, height: float) -> tuple[Floats, list[tuple[int, ...]]]:
    """A box from the origin [m]; corner i + 2 j + 4 k."""
    corners = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], float)
    return corners * [length, width, height], list(BOX_FACES)


def tube(centre: Floats, radius: float, sides: int) -> tuple[Floats, list[tuple[int, ...]]]:
    """A closed tube about a closed curve, (points, 3), with frames carried along it."""
    count = len(centre)
    tangent = np.roll(centre, -1, 0) - np.roll(centre, 1, 0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normal = np.zeros_like(centre)
    normal[0] = np.cross(tangent[0], [0, 0, 1.0])
    for k in range(1, count):
        normal[k] = normal[k - 1] - (normal[k - 1] @ tangent[k]) * tangent[k]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    # the twist that the frame has after one round is taken out evenly
    last = normal[-1] - (normal[-1] @ tangent[0]) * tangent[0]
    twist = np.arctan2(np.cross(normal[0], last) @ tangent[0], normal[0] @ last)
    angle = (2 * np.pi * np.arange(sides)[None, :] / sides
             - twist * np.arange(count)[:, None] / count)
    binormal = np.cross(tangent, normal)
    ring = (np.cos(angle)[..., None] * normal[:, None] + np.sin(angle)[..., None]
            * binormal[:, None])
    vertices = (centre[:, None] + radius * ring).reshape(-1, 3)
    faces = [(a * sides + s, a * sides + (s + 1) % sides,
              (a + 1) % count * sides + (s + 1) % sides, (a + 1) % count * sides + s)
             for a in range(count) for s in range(sides)]
    return vertices, faces


def torus() -> tuple[Floats, list[tuple[int, ...]]]:
    """A ring of 0.3 m that stands upright."""
    t = 2 * np.pi * np.arange(40) / 40
    return tube(0.11 * np.stack([np.cos(t), np.sin(t), 0 * t], 1), 0.04, 16)


def knot() -> tuple[Floats, list[tuple[int, ...]]]:
    """A trefoil, 0.4 m wide."""
    t = 2 * np.pi * np.arange(96) / 96
    curve = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t),
                      -1.4 * np.sin(3 * t)], 1)
    return tube(0.055 * curve, 0.035, 12)


SHAPES = {"beam": box(1, 0.1, 0.1), "slender": box(2, 0.1, 0.1), "bar": box(0.4, 0.1, 0.1),
          "cube": box(0.1, 0.1, 0.1), "torus": torus(), "knot": knot()}


def volume(vertices: Floats, faces: list[tuple[int, ...]]) -> float:
    """Of what the faces bound [m^3]; positive where they point out."""
    return sum(float(np.linalg.det(vertices[[f[0], f[k], f[k + 1]]]))
               for f in faces for k in range(1, len(f) - 1)) / 6


def main() -> None:
    """Writes every shape as OBJ."""
    folder = Path(sys.argv[1])
    for name, (vertices, faces) in SHAPES.items():
        assert volume(vertices, faces) > 0, name
        lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in vertices]
        lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
        (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
