# SPDX-License-Identifier: Apache-2.0
"""Loads that change, from the definitions in docs/formats.md: forces in time that nodes share, and wind.

Of wind a point of the surface with the area A at rest feels, with the velocity W of the air and v of its own,

    f = c rho/2 |w.a| (w.a) a/|a|^2,     a = cof(F) A,     w = W - v,

F that of the middle of its voxel; the corners of the voxel share it by the weights of the point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from equations import SIGNS, Body
from state_file import Floats, State
from state_layout import number, require


@dataclass(frozen=True)
class Wind:
    """The air, and the surface that it blows on."""

    factor: float  # c rho/2 [kg/m^3]
    data: dict[str, NDArray[Any]]  # the datasets of /wind

    def force(self, step: int, body: Body, corners: NDArray[Any], x: Floats, v: Floats) -> Floats:
        """What it does at the end of a step, where nodes are at x and have velocities v, (nodes, 3) [N]."""
        nodes, weights, area = corners[self.data["voxel"]], self.data["weights"], self.data["area"]
        F = x[nodes].transpose(0, 2, 1) @ SIGNS / (4 * body.h)
        columns = F.transpose(2, 0, 1)
        a = sum((area[:, i, None] * np.cross(columns[i - 2], columns[i - 1]) for i in range(3)), np.zeros_like(area))
        w = self.data["velocity"][step] - np.einsum("pc,pcd->pd", weights, v[nodes])
        flow = (w * a).sum(1)
        f = (self.factor * np.abs(flow) * flow / (a * a).sum(1))[:, None] * a
        result = np.zeros_like(x)
        np.add.at(result, nodes, weights[:, :, None] * f[:, None, :])
        return result


class Loading:
    """The loads of the steps of a state file; those that do not change where it has no others."""

    def __init__(self, state: State, body: Body) -> None:
        self.state, self.body = state, body
        self.wind = read_wind(state) if state.wind else None

    @property
    def changes(self) -> bool:
        """Whether loads are not the same all the time."""
        return self.state.load is not None

    def body_at(self, step: int, of_stage: bool = False) -> Body:
        """The body under the loads at the end of a step, or of its first stage."""
        if self.state.load is None:
            return self.body
        of = self.state.load_stage if of_stage else self.state.load
        require(of is not None, "/steps/load_stage is missing")
        load = of[step]
        require(np.isfinite(load).all(), f"/steps: the load of step {step} has values that are not finite")
        return replace(self.body, traction=load)

    def own(self, step: int, x: Floats, v: Floats) -> Floats:
        """The loads at the end of a step, recomputed, (nodes, 3) [N]."""
        load = self.body.traction.copy()
        if self.state.forces is not None:
            load += self.state.forces["share"].T @ self.state.forces["force"][step]
        if self.wind is not None:
            load += self.wind.force(step, self.body, self.state.grid["corners"], x, v)
        return load


def read_wind(state: State) -> Wind:
    """The wind of a state file, its numbers checked."""
    data, group = {name: node[()] for name, node in state.wind.items()}, state.wind
    for name in ("weights", "area", "velocity"):
        require(np.isfinite(data[name]).all(), f"/wind/{name} has values that are not finite")
    voxels = len(state.grid["corners"])
    require(((data["voxel"] >= 0) & (data["voxel"] < voxels)).all(), f"/wind/voxel must lie in 0..{voxels - 1}")
    density, share = (number(_attribute(group, name), f"/wind attribute '{name}'") for name in ("density", "share"))
    require(density > 0 and share > 0, "/wind: density and share must be positive")
    return Wind(share * density / 2, data)


def _attribute(group: h5py.Group, name: str) -> Any:
    require(name in group.attrs, f"/wind lacks the attribute '{name}'")
    return group.attrs[name]
