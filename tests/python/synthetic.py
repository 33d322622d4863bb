# SPDX-License-Identifier: Apache-2.0
"""Small ragged bodies and state files for the self-tests of the referee."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import equations
from equations import BITS, Body, Motion, Potential
from holding import Holding
from references import Start, find_pieces, turned
from stages import SHARE, StageStep
from state_file import BDF2, EULER, FIELDS, LAWS, LENGTHS, SDIRK2, Floats, Holders, Material, State

H, DT = 0.05, 1 / 60
GRAVITY = np.array([0.3, -9.7, 0.2])
SCHEMES = np.array([SDIRK2, BDF2, SDIRK2, EULER], np.uint8)  # of runs by stages
LENGTHS_OF_STEPS = np.array([1, 0.5, 0.25, 0.25]) * DT
TIMES = np.concatenate([[0], np.cumsum(LENGTHS_OF_STEPS)])
HELD_CENTRE, HELD_AXIS = np.array([0.4, -0.1, 0.2]), np.array([0.6, 0.0, 0.8])  # of held_state()
CELLS = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 1), (2, 0, 1)]


def shape_means(points: Floats) -> Floats:
    """(8,) means of the trilinear shape functions over points of the unit cube, (n, 3)."""
    factors = np.where(BITS, points[:, None, :], 1 - points[:, None, :])
    return factors.prod(2).mean(0)


def ragged_grid(seed: int, cells: list[tuple[int, int, int]], materials: list[Material],
                full: int = 2) -> dict[str, Any]:
    """The datasets of /grid: the first `full` voxels are full, the others random border voxels."""
    random = np.random.default_rng(seed)
    lattice = np.array(cells)[:, None, :] + BITS
    nodes, corners = np.unique(lattice.reshape(-1, 3), axis=0, return_inverse=True)
    corners = corners.reshape(-1, 8)
    fill = np.where(np.arange(len(cells)) < full, 1.0, random.uniform(0.1, 1, len(cells)))
    mean = np.array([shape_means(random.uniform(0, 1, (12, 3))) for _ in cells])
    mean[:full] = 1 / 8
    material = np.arange(len(cells)) % len(materials)
    density = np.array([m.density for m in materials])[material]
    mass = np.bincount(corners.ravel(), ((density * fill * H**3)[:, None] * mean).ravel())
    young = np.array([m.young for m in materials])[material]
    return {
        "rest": H * nodes + np.array([0.3, -0.2, 0.1]),
        "corners": corners.astype(np.int32),
        "fill": fill,
        "shape_mean": mean,
        "mass": mass,
        "pinned": (nodes[:, 0] == 0).astype(np.uint8),
        "hourglass": young[:, None] * random.uniform(0.3, 0.6, (len(cells), 4)),
        "material": material.astype(np.int32),
    }


def make_state(seed: int = 1, laws: tuple[str, ...] = LAWS, hourglass: str = "full",
               cells: list[tuple[int, int, int]] = CELLS, full: int = 2) -> State:
    """A state without steps: one material a law, in turn over the voxels."""
    materials = [Material(f"solid {i}", law, 2e4 * (1 + i), 0.1 + 0.04 * i, 900.0 + 100 * i)
                 for i, law in enumerate(laws)]
    words = {"format": "elastogen-state", "time_scheme": "bdf2", "hourglass": hourglass,
             "element": "voxel", "solver": "newton", "energy": "analytic", "commit": "none"}
    return State(words, H, DT, GRAVITY, 9.81, 1e-3, materials,
                 ragged_grid(seed, cells, materials, full), {}, None, None)


def add_contact(state: State, x: Floats, offsets: Floats) -> None:
    """Puts the corners of each voxel on its lower face into contact with a plane, a sphere, a box.

    @param x        positions [m] that the colliders are placed by, (nodes, 3)
    @param offsets  of the colliders at each record, (records, 3, 3)
    """
    layer, count = H / 4, len(state.grid["corners"])
    weights = np.zeros((3 * count, 8))
    weights[np.arange(3 * count), np.tile([0, 3, 7], count)] = 1
    corner = x[state.grid["corners"][:, [0, 3, 7]]].reshape(-1, 3)
    low, middle, high = corner.min(0), corner.mean(0), corner.max(0)
    normal = np.array([0.6, 0.0, 0.8])
    state.contact = {
        "voxel": np.repeat(np.arange(count), 3).astype(np.int32), "weights": weights,
        "area": np.full(3 * count, H * H / 3), "shape": np.array([0, 1, 2], np.uint8),
        "centre": np.array([normal * ((corner @ normal).min() + layer / 2),
                            [middle[0], low[1] - 1 + layer / 2, middle[2]],
                            [high[0] + 0.1 - layer / 3, middle[1], middle[2]]]),
        "normal": np.array([normal, [0, 1, 0], [0, 1, 0]]), "radius": np.array([0.0, 1.0, 0.0]),
        "half": np.array([[0.0] * 3, [0.0] * 3, [0.1, 1.0, 1.0]]),
        "friction": np.array([0.3, 0.0, 0.6]), "name": np.array([b"plane", b"ball", b"box"]),
        "offset": offsets, "layer": np.array(layer), "slip_range": np.array(1e-4 * H),
        "impact_speed": np.array(0.5)}


def central_differences(function: Callable[[Floats], Any], x: Floats, width: float) -> Floats:
    """Derivatives of a scalar or array function by each entry of x; first axis: entries of x."""
    rows = []
    for index in range(x.size):
        shift = np.zeros(x.size)
        shift[index] = width
        shift = shift.reshape(x.shape)
        rows.append((np.asarray(function(x + shift)) - function(x - shift)) / (2 * width))
    return np.array(rows)


def solve_step(body: Body, motion: Motion) -> Floats:
    """x^{n+1} of one step by dense Newton iterations with a differenced Hessian."""
    R = equations.rotations(body, motion.x)
    free = np.repeat(body.free, 3)
    x = motion.x.copy()

    def gradient(y: Floats) -> Floats:
        return equations.potential(body, motion, GRAVITY, DT, y, R).gradient.ravel()[free]

    for _ in range(12):
        hessian = central_differences(gradient, x, 1e-6 * H)[free]
        change = np.zeros(x.size)
        change[free] = np.linalg.solve(hessian.T, -gradient(x))
        x = x + change.reshape(x.shape)
    return x


def roll_out(state: State, schemes: list[int], seed: int = 3) -> tuple[Floats, Floats]:
    """Records x and v of exactly solved steps that start from a random velocity."""
    body, random = equations.make_body(state), np.random.default_rng(seed)
    v = [np.where(body.free[:, None], random.normal(0, 0.2, body.rest.shape), 0.0)]
    x = [body.rest.copy()]
    for scheme in schemes:
        motion = Motion(x[-1], v[-1], x[-2], v[-2]) if scheme else Motion(x[-1], v[-1])
        x.append(solve_step(body, motion))
        v.append(equations.velocity(motion, x[-1], DT))
    return np.array(x), np.array(v)


def step_arrays(state: State, x: Floats, v: Floats, schemes: list[int],
                residual: float) -> dict[str, Any]:
    """The datasets of /steps for given records, all with the same reported residual."""
    steps = len(schemes)
    mass = state.grid["mass"]
    return {
        "time": DT * np.arange(steps + 1), "x": x, "v": v,
        "scheme": np.array(schemes, np.uint8), "length": np.full(steps, DT),
        "tolerance": np.full(steps, state.tolerance), "residual": np.full(steps, residual),
        "converged": np.full(steps, residual <= state.tolerance, np.uint8),
        "outer": np.ones(steps, np.int32), "inner": np.ones(steps, np.int32),
        "ms": np.ones(steps), "min_j": np.ones(steps),
        "energy_kinetic": 0.5 * np.einsum("n,tni,tni->t", mass * (state.grid["pinned"] != 1), v[1:], v[1:]),
    }


def stage_records(seed: int = 5) -> tuple[State, dict[str, Any]]:
    """A damped run by stages, in contact, of a pinned and of a free piece, and its /steps: moved at
    random and not solved, with the residuals, velocities and bonds that the referee finds itself."""
    random = np.random.default_rng(seed)
    state = make_state(cells=[(0, 0, 0), (1, 0, 0), (4, 0, 0), (5, 0, 0), (5, 1, 0)])
    state.words["time_scheme"] = "auto"
    state.materials = [replace(m, loss_factor=0.1 + 0.1 * i, loss_frequency=5.0 + i)
                       for i, m in enumerate(state.materials)]
    rest, steps = state.grid["rest"], len(SCHEMES)
    loose = state.grid["pinned"][:, None] == 0
    x = [rest + np.where(loose, random.normal(0, 0.02 * H, rest.shape), 0) for _ in range(steps + 1)]
    x_stage = np.full((steps, *rest.shape), np.nan)
    for step in np.flatnonzero(SCHEMES == SDIRK2):
        x_stage[step] = x[step] + np.where(loose, random.normal(0, 0.01 * H, rest.shape), 0)
    offsets = np.cumsum(random.normal(0, 1e-3 * H, (steps + 1, 3, 3)), axis=0)
    add_contact(state, rest, offsets)
    bonds = np.zeros((steps + 1, 3, len(state.contact["area"]), 3))
    bonds[0] = random.normal(0, 1e-4 * H, bonds[0].shape)
    state.contact["bonds"] = bonds
    v = np.where(loose, random.normal(0, 0.3, rest.shape), 0)
    return state, found_steps(state, np.array(x), x_stage, [v] + [np.zeros_like(v)] * steps)[0]


def found_steps(state: State, x: Floats, x_stage: Floats,
                v: list[Floats]) -> tuple[dict[str, Any], list[Potential]]:
    """/steps of a run of SCHEMES, with what the referee finds itself, and the potentials at their ends.

    @param v  at the start; of pinned nodes also after each step
    """
    steps, body, residual, rough, found = len(SCHEMES), equations.make_body(state), [], [], []
    state.steps, state.x_stage = {"scheme": SCHEMES, "length": LENGTHS_OF_STEPS}, x_stage
    start, v = Start(x[0], v[0]), list(v)
    for step in range(steps):
        own = StageStep(state, body, find_pieces(state, body), step, start).recompute(x[step + 1])
        residual.append(own.residual)
        rough.append(own.rough)
        found.append(own.found)
        v[step + 1] = v[step + 1] + own.velocity
        if own.bonds is not None:
            state.contact["bonds"][step + 1] = own.bonds
        start = Start(x[step + 1], v[step + 1], start.x, start.v, LENGTHS_OF_STEPS[step])
    arrays = step_arrays(state, x, np.array(v), SCHEMES.tolist(), 1.0)
    return arrays | state.steps | {
        "time": TIMES, "residual": np.array(residual), "converged": np.zeros(steps, np.uint8),
        "x_stage": x_stage, "guarded": np.zeros(steps, np.uint8), "time_error": np.array(rough),
        "time_ratio": np.full(steps, 0.05)}, found


def held_state() -> State:
    """A piece between a pin and a move of pinned and dependent nodes, and a free one under a load."""
    state = make_state(cells=[(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (5, 0, 0), (6, 0, 0)])
    grid = state.grid
    cell = np.rint((grid["rest"] - grid["rest"].min(0)) / H).astype(int)
    number = {tuple(place): n for n, place in enumerate(cell.tolist())}
    grid["pinned"][(cell[:, 0] == 3)] = 2
    grid["pinned"][(cell[:, 0] == 3) & (cell[:, 1] == 2)] = 1
    rows = [(n, number[x - step, y, z], weight) for (x, y, z), n in number.items() if grid["pinned"][n] == 2
            for step, weight in ((1, -0.6), (2, 0.2))]
    for name, values in zip(("dependent", "parent", "parent_weight"), zip(*sorted(rows))):
        grid[name] = np.array(values, np.float64 if name == "parent_weight" else np.int32)
    grid["traction"] = np.where(cell[:, :1] > 4, [0.3, -0.2, 0.5], [0.1, 0.0, -0.1])
    state.words["time_scheme"], state.moved = "auto", True
    of_node = np.where(grid["pinned"] > 0, (cell[:, 0] == 3).astype(np.int32), np.int32(-1))
    state.holders = Holders(("--pin 'x<1%'", "--move 'x>99%: turn'", "--pin 'y<-9'"), of_node)
    return state


def held_motion(time: float) -> tuple[Floats, Floats]:
    """Rotation and shift of the move of held_state(), a turn about HELD_CENTRE."""
    A = turned(HELD_AXIS, 9.0 * time + 40 * time**2)
    return A, HELD_CENTRE - A @ HELD_CENTRE


def held_records(seed: int = 6) -> tuple[State, dict[str, Any]]:
    """A run by stages of held_state(), and its /steps: free nodes move at random, the rest as it must."""
    random, state = np.random.default_rng(seed), held_state()
    body = equations.make_body(state)
    rest, moved = body.rest, (state.grid["pinned"] == 1) & (state.holders.of_node == 1)

    def place(time: float) -> tuple[Floats, Floats]:
        """Positions and offsets."""
        A, b = held_motion(time)
        u = np.where(body.loose, random.normal(0, 0.02 * H, rest.shape), 0)
        bar = rest @ A.T + b - rest
        u[moved] = bar[moved]
        offset = (bar - body.follow(bar))[body.dependent]
        u = body.follow(u)
        u[body.dependent] += offset
        return rest + u, offset

    x, offset = zip(*(place(t) for t in TIMES))
    state.holders = replace(state.holders, offset=np.array(offset))
    x_stage = np.full((len(SCHEMES), *rest.shape), np.nan)
    for step in np.flatnonzero(SCHEMES == SDIRK2):
        x_stage[step] = place(TIMES[step] + SHARE * LENGTHS_OF_STEPS[step])[0]
    v = [np.where(moved[:, None], np.cross((9 + 80 * t) * HELD_AXIS, x[k] - HELD_CENTRE), 0)
         for k, t in enumerate(TIMES)]
    v[0] += np.where(body.loose, random.normal(0, 0.3, rest.shape), 0)
    arrays, found = found_steps(state, np.array(x), x_stage, v)
    # reactions, of the pin about the mean of its nodes
    pin = rest[state.holders.of_node == 0].mean(0)
    state.steps = arrays | {"reaction_about": np.tile([pin, HELD_CENTRE, np.zeros(3)], (len(SCHEMES), 1, 1)),
                            "reaction_force": None}
    holding = Holding(state, body)
    both = np.array([holding.reactions(step, found[step], x[step + 1]) for step in range(len(SCHEMES))])
    return state, state.steps | {"reaction_force": both[:, 0], "reaction_moment": both[:, 1]}


def write_state(path: Path, state: State, steps: dict[str, Any], gravity: Floats,
                compound: bool = True) -> None:
    """A state file; the materials as a compound dataset or as attributes of a group."""
    columns = {f: [getattr(m, f) for m in state.materials] for f in FIELDS}
    with h5py.File(path, "w") as file:
        file.attrs.update(state.words | {"version": 5, "h": state.h, "dt": state.dt, "fps": 60.0,
                                         "gravity": gravity, "g_ref": state.g_ref,
                                         "tolerance": state.tolerance})
        for name, values in state.grid.items():
            file[f"grid/{name}"] = values
        for name, values in steps.items():
            file[f"steps/{name}"] = values
        if state.contact is not None:
            for name, values in state.contact.items():
                file.require_group("contact")
                target = file["contact"].attrs if name in LENGTHS else file["contact"]
                target[name] = values
        if state.moved:
            file.attrs["moved"] = 1
        if state.holders is not None:
            file["holders/name"] = np.array(state.holders.names, "S")
            file["holders/of_node"] = state.holders.of_node.astype(np.int32)
            if state.holders.offset is not None:
                file["holders/offset"] = state.holders.offset
        if compound:
            kinds = [(f, h5py.string_dtype() if f in FIELDS[:2] else "f8") for f in FIELDS]
            file["materials"] = np.array(list(zip(*columns.values())), np.dtype(kinds))
        else:
            file.create_group("materials").attrs.update(columns)
