# SPDX-License-Identifier: Apache-2.0
"""The groups of a state file: names, types and shapes of their datasets, and the check of these.

state_file.py says what the letters of shapes are, and reads and checks the values.
"""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

Shape = tuple[Any, ...]

# name -> (type, shape); a type of one letter is a numpy kind of any width
GRID: dict[str, tuple[str, Shape]] = {
    "rest": ("f8", ("nodes", 3)),
    "corners": ("i4", ("voxels", 8)),
    "fill": ("f8", ("voxels",)),
    "shape_mean": ("f8", ("voxels", 8)),
    "mass": ("f8", ("nodes",)),
    "pinned": ("u1", ("nodes",)),
    "hourglass": ("f8", ("voxels", 4)),
    "material": ("i4", ("voxels",)),
}
BOUNDARY: dict[str, tuple[str, Shape]] = {  # also in /grid, of runs with loads and held components
    "fixed": ("u1", ("nodes", 3)),
    "traction": ("f8", ("nodes", 3)),
}
DEPENDENT: dict[str, tuple[str, Shape]] = {  # also in /grid, where nodes follow others
    "dependent": ("i4", ("parents",)), "parent": ("i4", ("parents",)), "parent_weight": ("f8", ("parents",)),
}
STEPS: dict[str, tuple[str, Shape]] = {
    "time": ("f8", ("records",)),
    "x": ("f8", ("records", "nodes", 3)),
    "v": ("f8", ("records", "nodes", 3)),
    "scheme": ("u1", ("steps",)),
    "length": ("f8", ("steps",)),
    "tolerance": ("f8", ("steps",)),
    "residual": ("f8", ("steps",)),
    "converged": ("u1", ("steps",)),
    "outer": ("iu", ("steps",)),
    "inner": ("iu", ("steps",)),
    "ms": ("f", ("steps",)),
    "min_j": ("f", ("steps",)),
}
STAGES: dict[str, tuple[str, Shape]] = {  # also in /steps
    "x_stage": ("f8", ("steps", "nodes", 3)),
    "guarded": ("u1", ("steps",)),
}
ESTIMATES: dict[str, tuple[str, Shape]] = {  # of STAGES, in files of version 5 and later
    "time_error": ("f8", ("steps",)),
    "time_ratio": ("f8", ("steps",)),
}
MESH_ERRORS: dict[str, tuple[str, Shape]] = {  # also in /steps, where frames get a mesh number
    "mesh_error": ("f8", ("steps",)),
    "mesh_error_largest": ("f8", ("steps",)),
    "mesh_error_trusted": ("u1", ("steps",)),
}
LOADS: dict[str, tuple[str, Shape]] = {  # also in /steps, where loads change; of stages the second too
    "load": ("f8", ("steps", "nodes", 3)), "load_stage": ("f8", ("steps", "nodes", 3)),
}
FORCES: dict[str, tuple[str, Shape]] = {
    "share": ("f8", ("forces", "nodes")), "force": ("f8", ("steps", "forces", 3)),
}
WIND: dict[str, tuple[str, Shape]] = {
    "voxel": ("i4", ("facets",)), "weights": ("f8", ("facets", 8)), "area": ("f8", ("facets", 3)),
    "velocity": ("f8", ("steps", 3)),
}
REACTIONS: dict[str, tuple[str, Shape]] = {  # also in /steps, of the network where something is held
    "reaction_force": ("f8", ("steps", "holders", 3)),
    "reaction_moment": ("f8", ("steps", "holders", 3)),
    "reaction_about": ("f8", ("steps", "holders", 3)),
}
HOLDERS: dict[str, tuple[str, Shape]] = {"name": ("S", ("holders",)), "of_node": ("i4", ("nodes",))}
# also in /holders, where it is needed
MORE_OF_HOLDERS: dict[str, tuple[str, Shape]] = {"offset": ("f8", ("records", "followers", 3)),
                                                 "of_component": ("i4", ("nodes", 3))}
MOTION: dict[str, tuple[str, Shape]] = {  # also in /holders, where one moves
    "turns": ("u1", ("holders",)), "centre": ("f8", ("holders", 3)),
    "rate": ("f8", ("records", "holders", 3)), "change": ("f8", ("records", "holders", 3)),
}
ENERGY: tuple[str, Shape] = ("f", ("steps",))
CONTACT: dict[str, tuple[str, Shape]] = {
    "voxel": ("i4", ("points",)),
    "weights": ("f8", ("points", 8)),
    "area": ("f8", ("points",)),
    "shape": ("u1", ("colliders",)),
    "centre": ("f8", ("colliders", 3)),
    "normal": ("f8", ("colliders", 3)),
    "half": ("f8", ("colliders", 3)),
    "radius": ("f8", ("colliders",)),
    "friction": ("f8", ("colliders",)),
    "name": ("S", ("colliders",)),
    "offset": ("f8", ("records", "colliders", 3)),
}

BONDS: tuple[str, Shape] = ("f8", ("records", "colliders", "points", 3))  # also in /contact


class LayoutError(Exception):
    """The file is not a state file that the referee can judge; the message names the place."""


def require(condition: bool | np.bool_, *message: object) -> None:
    """Raises LayoutError with the joined message unless the condition holds."""
    if not condition:
        raise LayoutError("".join(str(part) for part in message))


def text(value: Any) -> str:
    """A string attribute or field, of variable or fixed length."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace").rstrip("\0")
    require(isinstance(value, str), "expected a text, got ", repr(value))
    return str(value)


def number(value: Any, what: str) -> float:
    """A scalar number; `what` names it in the message."""
    array = np.asarray(value)
    require(array.size == 1 and array.dtype.kind in "iuf", what, " must be one number, got ", value)
    return float(array.reshape(()))


def _check_dataset(node: Any, place: str, kind: str, shape: Shape, sizes: dict[str, int]) -> None:
    """Type and shape of one dataset; a size letter met for the first time is noted in `sizes`."""
    require(isinstance(node, h5py.Dataset), place, " must be a dataset")
    same = node.dtype == np.dtype(kind) if kind[-1].isdigit() else node.dtype.kind in kind
    require(same, f"{place} must be of type {kind}, got {node.dtype}")
    require(node.ndim == len(shape), f"{place} must be {shape}, got {node.shape}")
    for wanted, got in zip(shape, node.shape):
        size = sizes.setdefault(wanted, got) if isinstance(wanted, str) else wanted
        require(size == got, f"{place} must be {shape} with {wanted} = {size}, got {node.shape}")


def _check_names(names: set[str], wanted: set[str], place: str) -> None:
    require(names >= wanted, f"{place} lacks {sorted(wanted - names)}")
    require(names <= wanted, f"{place} has unexpected members {sorted(names - wanted)}")


def _tables(file: h5py.File) -> dict[str, dict[str, tuple[str, Shape]]]:
    """The datasets that each group of this file must have."""
    stages = text(file.attrs["time_scheme"]) in ("sdirk2", "auto")
    energies = {name: ENERGY for name in file["steps"] if name.startswith("energy_")}
    tables = {
        "grid": GRID | {name: BOUNDARY[name] for name in BOUNDARY if name in file["grid"]},
        "steps": STEPS | (STAGES if stages else {}) | energies,
        "contact": CONTACT | ({"bonds": BONDS} if stages else {}),
        "forces": FORCES,
        "wind": WIND,
        "holders": HOLDERS | {name: what for name, what in MORE_OF_HOLDERS.items() if name in file.get("holders", ())},
    }
    if {"forces", "wind"} & set(file):
        tables["steps"] = tables["steps"] | (LOADS if stages else {"load": LOADS["load"]})
    if set(MOTION) & set(file.get("holders", ())):
        tables["holders"] = tables["holders"] | MOTION
    if set(DEPENDENT) & set(file["grid"]):
        tables["grid"] = tables["grid"] | DEPENDENT
    if stages and int(file.attrs["version"]) >= 5:
        tables["steps"] = tables["steps"] | ESTIMATES
    if set(MESH_ERRORS) & set(file["steps"]):
        tables["steps"] = tables["steps"] | MESH_ERRORS
    if set(REACTIONS) & set(file["steps"]):
        require("holders" in file, "/steps has reactions in a file without /holders")
        tables["steps"] = tables["steps"] | REACTIONS
    return {place: table for place, table in tables.items() if place in file}


def check_layout(file: h5py.File) -> None:
    """Names, types and shapes of the groups `grid`, `steps` and of others, if they are there."""
    places = {"grid", "steps"} | {"contact", "holders", "forces", "wind"} & set(file)
    _check_names(set(file), {"materials"} | places | ({"nets"} & set(file)), "/")
    for place in sorted(places):
        require(isinstance(file[place], h5py.Group), f"/{place} must be a group")
    sizes: dict[str, int] = {}
    for place, table in _tables(file).items():
        _check_names(set(file[place]), set(table), f"/{place}")
        for name, (kind, shape) in table.items():
            _check_dataset(file[place][name], f"/{place}/{name}", kind, shape, sizes)
    require(sizes["steps"] >= 1, "the file has no time step")
    require(sizes["records"] == sizes["steps"] + 1,
            f"{sizes['steps']} steps need {sizes['steps'] + 1} records, got {sizes['records']}")
