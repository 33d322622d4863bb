# SPDX-License-Identifier: Apache-2.0
"""What the examples share: they run the command on a scene and read what it wrote."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
from collections.abc import Callable
from itertools import product
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SCENES = ROOT / "examples" / "scenes"
COMMAND = os.environ.get("ELASTOGEN_BINARY", str(ROOT / "build" / "cpu" / "elastogen"))


def elastogen(verb: str, *words: object) -> None:
    """Runs the command in the present folder; an example ends where it does not succeed."""
    done = subprocess.run([COMMAND, verb, *map(str, words), "--quiet"], check=False)
    if done.returncode:
        sys.exit(f"elastogen {verb} ended with {done.returncode}")


def steps(path: str) -> list[dict]:
    """The log of a run: an object a time step."""
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def vertices(path: str) -> list[tuple[float, float, float]]:
    """Positions of a PLY file as the command writes it."""
    head, body = Path(path).read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    count = next(int(line[2]) for line in lines if line[:2] == ["element", "vertex"])
    first = next(k for k, line in enumerate(lines) if line[:2] == ["element", "vertex"])
    letters = {"float": "f", "double": "d", "uchar": "B", "int": "i", "uint": "I", "ushort": "H"}
    names, form = [], "<"
    for line in lines[first + 1:]:
        if line[0] != "property":
            break
        names.append(line[2])
        form += letters[line[1]]
    at = [names.index(axis) for axis in "xyz"]
    rows = struct.iter_unpack(form, body[:count * struct.calcsize(form)])
    return [tuple(row[k] for k in at) for row in rows]


def blocks(path: str, place: Callable, boxes: list) -> None:
    """Writes an OBJ of the surface of boxes of cells; place gives the place of numbers of cells."""
    cells = {cell for box in boxes for cell in product(*map(range, *box))}
    places, faces = {}, []
    for cell, axis, side in product(sorted(cells), range(3), (0, 1)):
        beside = tuple(c + (2 * side - 1) * (d == axis) for d, c in enumerate(cell))
        if beside in cells:
            continue
        face, u, v = [], (axis + 1) % 3, (axis + 2) % 3
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            at = list(cell)
            at[axis], at[u], at[v] = cell[axis] + side, cell[u] + a, cell[v] + b
            face.append(places.setdefault(tuple(at), len(places) + 1))
        faces.append(face if side else face[::-1])
    rows = ["v {:.9g} {:.9g} {:.9g}\n".format(*place(at)) for at in places]
    Path(path).write_text("".join(rows + ["f {} {} {} {}\n".format(*face) for face in faces]))


def box(path: str, lower: tuple, upper: tuple, parts: tuple) -> None:
    """Writes an OBJ of a box whose edges along x, y, z have so many parts."""
    blocks(path, lambda at: [lo + (up - lo) * k / n for lo, up, k, n in zip(lower, upper, at, parts)],
           [((0, 0, 0), parts)])


def claim(what: str, value: float, least: float, most: float) -> None:
    """Says a number; the example has failed where it is not within the limits."""
    met = least <= value <= most
    print(f"{'ok  ' if met else 'FAIL'} {what}: {value:.4g}, expected {least:.4g} ... {most:.4g}")
    if not met:
        sys.exit(1)
