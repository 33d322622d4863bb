#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the shape of network_porous.toml: `shapes_porous.py`."""

from __future__ import annotations

import numpy as np

from runs import HERE
from shapes import Floats, volume

Faces = list[tuple[int, ...]]


def globe(centre: Floats, radius: float, sides: int, first: int) -> tuple[Floats, Faces]:
    """A sphere of `sides` slices and half as many stacks, faces outwards, vertices from `first`."""
    stacks = sides // 2
    turn = 2 * np.pi * np.arange(sides) / sides
    fall = np.pi * np.arange(1, stacks) / stacks
    rings = np.stack([np.outer(np.sin(fall), np.cos(turn)), np.outer(np.sin(fall), np.sin(turn)),
                      np.outer(np.cos(fall), np.ones(sides))], -1).reshape(-1, 3)
    top, bottom, last = len(rings), len(rings) + 1, sides * (stacks - 2)
    faces: Faces = []
    for k in range(sides):
        j = (k + 1) % sides
        faces.append((top, k, j))
        faces += [(sides * s + k, sides * (s + 1) + k, sides * (s + 1) + j, sides * s + j)
                  for s in range(stacks - 2)]
        faces.append((last + k, bottom, last + j))
    return (centre + radius * np.concatenate([rings, [[0, 0, 1], [0, 0, -1]]]),
            [tuple(first + v for v in face) for face in faces])


def porous() -> tuple[Floats, Faces]:
    """A ball of 0.3 m with nineteen round cavities on a lattice of 80 mm."""
    vertices, faces = globe(np.zeros(3), 0.15, 32, 0)
    places = 0.08 * (np.stack(np.unravel_index(np.arange(27), (3, 3, 3)), 1) - 1)
    for place in places[np.linalg.norm(places, axis=1) < 0.115]:
        more, inwards = globe(place, 0.028, 12, len(vertices))
        vertices = np.concatenate([vertices, more])
        faces += [face[::-1] for face in inwards]
    return vertices, faces


def main() -> None:
    """Writes it as OBJ."""
    vertices, faces = porous()
    assert 0 < volume(vertices, faces) < 4 / 3 * np.pi * 0.15**3
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    (HERE / "verification" / "porous.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
