# SPDX-License-Identifier: Apache-2.0
"""A row of the ladder: runs of one scene file, numbers read from what they wrote, references."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from runs import HERE, Finished, Floats

POISSON = (0, 0.3, 0.45, 0.49, 0.499)
Options = tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """A quantity with its references; one number a run unless `measure` says otherwise.

    `sweep` holds the options that differ from run to run ("mesh:NAME" stands for a body of
    classic_meshes.py and the options that select its faces), `reference` numbers as `measure` gives
    them, which must agree within `tolerance`, an absolute difference, or a relative one where
    `relative`. `bound`: the reference may not be exceeded by more than the tolerance, that is all.
    """

    key: str  # of the ladder: D1, E3
    name: str
    scene: str
    verb: str
    sweep: Sequence[Options]
    measure: Callable[[Sequence[Finished]], Sequence[float]]
    quantity: str
    reference: Sequence[float]
    source: str
    tolerance: float
    relative: bool = False
    bound: bool = False
    options: Options = ()  # of all runs
    short: bool = False  # runs in the test

    def errors(self, measured: Sequence[float]) -> list[float]:
        """What is compared with the tolerance; infinite where a number is missing or not finite."""
        if len(measured) != len(self.reference):
            return [float("inf")]
        found = []
        for value, wanted in zip(measured, self.reference):
            error = value - wanted if self.bound else abs(value - wanted)
            if self.relative:
                error /= abs(wanted)
            found.append(float(error) if np.isfinite(error) else float("inf"))
        return found


def poissons(values: Sequence[float] = POISSON) -> list[Options]:
    """A sweep over Poisson's ratio."""
    return [("--poisson", f"{value:g}") for value in values]


def each(measure: Callable[[Finished], float]) -> Callable[[Sequence[Finished]], list[float]]:
    """One number a run."""
    return lambda runs: [measure(run) for run in runs]


def on_plane(rest: Floats, axis: int, place: float) -> Floats:
    """Weights of the nodes of a rectangular section, sum 1: the mean over it by trapezoids."""
    weight = np.isclose(rest[:, axis], place, rtol=0, atol=1e-9).astype(float)
    for other in (d for d in range(3) if d != axis):
        low, high = rest[:, other].min(), rest[:, other].max()
        rim = np.isclose(rest[:, other], low) | np.isclose(rest[:, other], high)
        weight *= np.where(rim, 0.5, 1)
    return weight / weight.sum()


def plane_mean(run: Finished, axis: int, place: float, entry: int = -1) -> Floats:
    """Mean displacement [m] of a section, (3,)."""
    return on_plane(run.rest, axis, place) @ run.u[entry]


def scene_path(stem: str) -> Path:
    """The scene file of a row."""
    return HERE / "verification" / f"{stem}.toml"
