# SPDX-License-Identifier: Apache-2.0
"""The beam of the scene c84 of `elastogen bench` for other codes: numbers, lattice, tetrahedra, and
what a run is asked for and says."""

from __future__ import annotations

import argparse
import statistics
from pathlib import Path
from typing import Any

import numpy as np

LENGTH, FRAMES, DT = 1.0, 24, 1 / 30
YOUNG, POISSON, DENSITY, GRAVITY = 1e5, 0.4, 1000.0, 9.81
# corners x + 2 y + 4 z of the five tetrahedra of an even cell; an odd one is its mirror image in x
EVEN = np.array([[0, 3, 5, 6], [1, 3, 0, 5], [2, 0, 3, 6], [4, 5, 0, 6], [7, 6, 3, 5]])
ODD = EVEN ^ 1


def counts_of(size: float) -> np.ndarray:
    """Cells along x, y, z, about `size` together."""
    n = max(1, round((size / 4) ** (1 / 3)))
    return np.array([4 * n, n, n])


def lattice(size: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Nodes (nodes, 3), tetrahedra (tets, 4) of positive volume, and the number of cells."""
    counts = counts_of(size)
    shape = counts + 1
    x, y, z = np.meshgrid(*(np.arange(k) for k in shape), indexing="ij")
    nodes = np.stack([x, y, z], axis=-1).reshape(-1, 3) * (LENGTH / counts[0])
    cells = np.stack(np.meshgrid(*(np.arange(k) for k in counts), indexing="ij"), axis=-1)
    cells = cells.reshape(-1, 3)
    parity = cells.sum(axis=1) % 2
    corner = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)])
    index = cells[:, None, :] + corner
    index = (index[..., 0] * shape[1] + index[..., 1]) * shape[2] + index[..., 2]
    cut = np.where(parity[:, None, None] == 0, EVEN, ODD)
    tets = np.take_along_axis(index[:, None, :], cut, axis=2).reshape(-1, 4)
    edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]
    turned = np.linalg.det(edges) < 0
    tets[turned, :2] = tets[turned, 1::-1]
    return nodes, tets.astype(np.int32), len(cells)


def colours(size: float) -> np.ndarray:
    """A colour of four for each node of `lattice(size)`; no tetrahedron has two nodes of one.

    Nodes of one parity in x, y and z share it, and so do those of the opposite parity: a cell is cut
    along diagonals of its faces alone, so that opposite corners never meet in a tetrahedron."""
    odd = np.meshgrid(*(np.arange(k + 1) % 2 for k in counts_of(size)), indexing="ij")
    parity = (odd[0] + 2 * odd[1] + 4 * odd[2]).reshape(-1)
    return np.minimum(parity, 7 - parity)


def tip_of(nodes: np.ndarray) -> np.ndarray:
    """The nodes nearest to the middle of the free end."""
    away = np.linalg.norm(nodes - [LENGTH, LENGTH / 8, LENGTH / 8], axis=1)
    return np.flatnonzero(away < away.min() + 1e-9)


def arguments(text: str | None) -> argparse.ArgumentParser:
    """The options that every peer has."""
    options = argparse.ArgumentParser(description=text,
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--sizes", default="3.2e4,2.56e5,1e6", help="cells, about")
    options.add_argument("--json", type=Path)
    return options


def outcome(name: str, cells: int, setup: float, ms: list[float],
            way: list[float]) -> dict[str, Any]:
    """The row of a run, which it also prints: milliseconds and tip [m] of each frame."""
    median = statistics.median(ms)
    marks = ", ".join(f"{1e3 * way[round(t / DT) - 1]:.1f}" for t in (0.2, 0.4, 0.6, 0.8))
    print(f"{name} {cells} cells: {median:.1f} ms a frame (longest {max(ms):.1f}), "
          f"tip at 0.2, 0.4, 0.6, 0.8 s {marks} mm", flush=True)
    return {"run": name, "cells": cells, "setup_seconds": setup, "ms": median,
            "slowest_ms": max(ms), "tip": way}
