#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Bodies of classic problems as quadratic tetrahedra whose middles lie on the curved faces, and the
options that select those faces: `classic_meshes.py NAME-N FILE.msh` writes one and prints them.

Blocks of cells in shares of 0..1 are mapped to places; N is the number of cells around."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from runs import HERE, Floats

sys.path.insert(0, str(HERE.parent / "python"))
from tet_mesh import TetMesh, lattice, quadratic, write_msh  # noqa: E402


@dataclass(frozen=True)
class Classic:
    """A body [m] and the words that load or hold its curved faces."""

    mesh: TetMesh
    options: tuple[str, ...] = ()


def mapped(cells: tuple[int, int, int], place: Callable[[Floats], Floats]) -> TetMesh:
    """The block of cells at the places of its nodes, the middles of edges too."""
    mesh = quadratic(lattice(cells))
    return TetMesh(place(mesh.x), mesh.tets)


def turn(share: Floats) -> tuple[Floats, Floats]:
    """Cosine and sine of a share of a right angle."""
    return np.cos(np.pi / 2 * share), np.sin(np.pi / 2 * share)


def tube(n: int) -> Classic:
    """A quarter of a slice of the tube between radii 1 and 2 about z, 0.1 thick."""
    def place(share: Floats) -> Floats:
        r, (c, s) = 1 + share[:, 0], turn(share[:, 1])
        return np.stack([r * c, r * s, 0.1 * share[:, 2]], 1)
    return Classic(mapped((n, n, 1), place))


def holed(n: int) -> Classic:
    """A quarter of a slice of a square plate of edge 100 with a hole of radius 1; cells grow in
    proportion to their distance from its centre."""
    def place(share: Floats) -> Floats:
        (c, s), far = turn(share[:, 1]), 50 / np.maximum(*turn(share[:, 1]))
        r = far ** share[:, 0]
        return np.stack([r * c, r * s, 0.1 * share[:, 2]], 1)
    return Classic(mapped((2 * n, n, 1), place))


INNER, OUTER = (2.0, 1.0), (3.25, 2.75)  # half axes of the NAFEMS ellipses [m]


def between_ellipses(n: int, cells: int, height: float) -> TetMesh:
    """A quarter of the plate between them; the layers of n/2 cells grow outward."""
    def place(share: Floats) -> Floats:
        c, s = turn(share[:, 1])
        out = share[:, 0] * (1 + 2 * share[:, 0]) / 3
        inner, outer = (np.stack([a * c, b * s], 1) for a, b in (INNER, OUTER))
        across = inner + out[:, None] * (outer - inner)
        return np.column_stack([across, height * share[:, 2]])
    return mapped((n // 2, n, cells), place)


def box_text(lower: Floats, upper: Floats, z: tuple[str, str]) -> str:
    """A selection a little larger than a box across z."""
    low, high = lower - 1e-6, upper + 1e-6
    return (f"box({float(low[0])!r},{float(low[1])!r},{z[0]}, "
            f"{float(high[0])!r},{float(high[1])!r},{z[1]})")


def rim(count: int) -> Floats:
    """Points that part the outer ellipse into `count` arcs, (count + 1, 2)."""
    return np.stack(turn(np.linspace(0, 1, count + 1)), 1) * OUTER


def membrane(n: int) -> Classic:
    """NAFEMS LE1: the plate's upper half, 0.05 thick; outside pulled by 10 kPa, arc by arc."""
    ends = rim(n)
    words = []
    for a, b in zip(ends, ends[1:]):
        words += ["--traction", box_text(np.minimum(a, b), np.maximum(a, b), ("0%", "100%"))
                  + ": -10 kPa"]
    return Classic(between_ellipses(n, 1, 0.05), tuple(words))


def plate(n: int) -> Classic:
    """NAFEMS LE10: the plate 0.6 thick; outside held along x and y, halfway up along z."""
    words = ["--hold", "x<0%: x", "--hold", "y<0%: y"]
    for point in rim(2 * n):
        words += ["--hold", box_text(point, point, ("0%", "100%")) + ": xy",
                  "--hold", box_text(point, point, ("50%", "50%")) + ": z"]
    return Classic(between_ellipses(n, 4, 0.6), tuple(words))


def ball(n: int) -> Classic:
    """An eighth of the ball of radius 1; cells grow from the pole on y, a quarter of 1/n there.

    The cube goes to the ball by x sqrt(1 - y^2/2 - z^2/2 + y^2 z^2/3) and so on (Nowell 2005).
    """
    growth = 16 ** (1 / n)  # from cell to cell

    def place(share: Floats) -> Floats:
        x, y, z = ((growth ** (n * s) - 1) / 15 for s in share.T)
        y = 1 - y  # and z before x, which keeps the tetrahedra's volumes positive
        cube = np.stack([z, y, x], 1)
        ahead, behind = np.roll(cube, -1, 1) ** 2, np.roll(cube, 1, 1) ** 2
        return cube * np.sqrt(1 - ahead / 2 - behind / 2 + ahead * behind / 3)
    return Classic(mapped((n, n, n), place))


CLASSICS = {"ball": ball, "tube": tube, "holed": holed, "membrane": membrane, "plate": plate}


def classic(name: str) -> Classic:
    """A body by its name and N, "tube-8"."""
    kind, _, n = name.partition("-")
    return CLASSICS[kind](int(n))


def written(name: str, path: Path) -> tuple[str, ...]:
    """Writes a body as MSH; the words that the command takes for it."""
    made = classic(name)
    return str(write_msh(path, made.mesh)), *made.options


if __name__ == "__main__":
    print(*written(sys.argv[1], Path(sys.argv[2])), sep="\n")
