# SPDX-License-Identifier: Apache-2.0
"""Layout of a state file (HDF5): every name, shape, type and attribute, checked before any use.

A state file holds what an outsider needs to recompute each time step: the grid, the materials and
the positions and velocities of every step. Shapes are written with the letters

    nodes, voxels    sizes of the grid           steps      T time steps
    records          T + 1, entry 0 is the start
    points           of the surface              colliders  of a run with contact
    followers        nodes that depend on others holders    what pins and moves nodes
    facets           of the surface in wind      forces     that change in time

Runs whose steps are made by stages (time_scheme sdirk2, auto) have the datasets of STAGES too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from state_layout import MOTION, LayoutError, check_layout, number, require, text

__all__ = ["LayoutError", "require"]  # besides what is defined here

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LAWS = ("fixed-corotated", "neo-hookean", "stable-neo-hookean", "stvk", "hencky", "ogden=4.5",
        "mooney-rivlin=0.3", "gent=8")  # the families with one of their members
FAMILIES = ("ogden", "mooney-rivlin", "gent")

# attribute -> allowed words; None allows any text
WORDS: dict[str, tuple[str, ...] | None] = {
    "format": ("elastogen-state",),
    "time_scheme": ("euler", "bdf2", "static", "sdirk2", "auto"),
    "hourglass": ("full", "variance", "off"),
    "element": ("voxel",),
    "solver": ("quasi", "newton", "paper", "fem"),
    "energy": ("analytic", "neural"),
    "commit": None,
}
VERSIONS = (4, 5)  # 4 has no time errors and mesh numbers
POSITIVE = ("h", "dt", "g_ref", "fps", "tolerance")
LENGTHS = ("layer", "slip_range", "impact_speed")  # attributes of /contact
PLANE, SPHERE, BOX = 0, 1, 2
FIELDS = ("name", "law", "young", "poisson", "density", "loss_factor", "loss_frequency")
EULER, BDF2, SDIRK2 = 0, 1, 2  # of /steps/scheme


@dataclass(frozen=True)
class Material:
    """One solid: law by name, Young's modulus [Pa], Poisson ratio, density [kg/m^3], loss factor at a
    frequency [Hz]."""

    name: str
    law: str
    young: float
    poisson: float
    density: float
    loss_factor: float = 0.0
    loss_frequency: float = 10.0

    @property
    def viscous_time(self) -> float:
        """tau [s] of docs/physics.md, section 5b."""
        return self.loss_factor / (2 * np.pi * self.loss_frequency)


@dataclass(frozen=True)
class Net:
    """What gives a material's energy in place of its law."""

    sha256: str  # of the file of its weights
    weights: Floats  # (17153,)
    cells: int  # of the table in a unit of log stretch; 0: the net itself was evaluated
    table: Floats | None = None  # B-spline coefficients, (n, n, n), last index along e_0


@dataclass(frozen=True)
class Holders:
    """What holds nodes: pins, at rest, moves, and holds along some axes."""

    names: tuple[str, ...]
    of_node: Ints  # (nodes,), -1: free
    offset: Floats | None = None  # (records, followers, 3) [m]; None: none moves followers
    of_component: Ints | None = None  # (nodes, 3), -1: not held along the axis; None: nothing is
    motion: dict[str, NDArray[Any]] | None = None  # the datasets of MOTION; None: none moves

    def rests(self, holder: int) -> bool:
        """Whether the option that it is named after is no move."""
        return not self.names[holder].startswith("--move ")


@dataclass
class State:
    """What a state file says. `x` and `v` stay on disk and are read one record at a time."""

    words: dict[str, str]  # text attributes
    h: float  # voxel edge [m]
    dt: float  # time step [s]
    gravity: Floats  # (3,) [m/s^2]
    g_ref: float  # [m/s^2]
    tolerance: float  # residual below which a step counts as converged
    materials: list[Material]
    grid: dict[str, NDArray[Any]]  # the datasets of GRID and, where they are there, BOUNDARY
    # the datasets of STEPS and STAGES without those of nodes, and the energies [J]
    steps: dict[str, NDArray[Any]]
    x: h5py.Dataset  # (records, nodes, 3) [m]
    v: h5py.Dataset  # (records, nodes, 3) [m/s]
    contact: dict[str, NDArray[Any]] | None = None  # datasets of CONTACT, BONDS, LENGTHS
    nets: tuple[Net | None, ...] = ()  # of each material, None: its law; empty: analytic
    x_stage: h5py.Dataset | None = None  # of STAGES
    moved: bool = False  # prescribed components follow a motion
    holders: Holders | None = None
    # of LOADS, where loads change; the datasets of FORCES; the group of WIND
    load: h5py.Dataset | None = None
    load_stage: h5py.Dataset | None = None
    forces: dict[str, NDArray[Any]] | None = None
    wind: h5py.Group | None = None

    @property
    def is_network(self) -> bool:
        """Whether the network, and not finite elements, made the steps."""
        return self.words["solver"] != "fem"

    @property
    def has_stages(self) -> bool:
        """Whether steps are made by stages."""
        return self.words["time_scheme"] in ("sdirk2", "auto")


def _attribute(file: h5py.File, name: str) -> Any:
    require(name in file.attrs, "root attribute '", name, "' is missing")
    return file.attrs[name]


def _read_words(file: h5py.File) -> dict[str, str]:
    words = {}
    for name, allowed in WORDS.items():
        words[name] = text(_attribute(file, name))
        require(allowed is None or words[name] in allowed,
                f"root attribute '{name}' must be one of {allowed}, got '{words[name]}'")
    return words


def _read_numbers(file: h5py.File) -> dict[str, float]:
    numbers = {}
    for name in POSITIVE:
        numbers[name] = number(_attribute(file, name), f"root attribute '{name}'")
        require(np.isfinite(numbers[name]) and numbers[name] > 0,
                f"root attribute '{name}' must be positive, got {numbers[name]}")
    version = number(_attribute(file, "version"), "root attribute 'version'")
    require(version in VERSIONS, f"version {VERSIONS} expected, got {version}")
    return numbers


def _material_columns(node: Any) -> dict[str, Any]:
    """The columns of /materials: a compound dataset, or a group with an attribute each."""
    if isinstance(node, h5py.Dataset):
        missing = set(FIELDS) - set(node.dtype.names or ())
        require(not missing, f"/materials must be compound with the fields {FIELDS}")
        table = node[()]
        return {field: np.atleast_1d(table[field]) for field in FIELDS}
    missing = set(FIELDS) - set(node.attrs)
    require(not missing, f"/materials lacks the attributes {sorted(missing)}")
    return {field: np.atleast_1d(node.attrs[field]) for field in FIELDS}


def _read_materials(file: h5py.File) -> list[Material]:
    columns = _material_columns(file["materials"])
    count = len(columns["name"])
    require(count >= 1 and all(len(column) == count for column in columns.values()),
            "the columns of /materials differ in length or are empty")
    materials = []
    for i in range(count):
        numbers = [number(columns[c][i], f"/materials {c}") for c in FIELDS[2:]]
        material = Material(text(columns["name"][i]), text(columns["law"][i]), *numbers)
        require(material.law in LAWS or material.law.partition("=")[0] in FAMILIES,
                f"/materials: unknown law '{material.law}'")
        require(material.young > 0 and material.density > 0 and -1 < material.poisson < 0.5
                and material.loss_factor >= 0 and material.loss_frequency > 0,
                f"/materials: '{material.name}' has values out of range")
        materials.append(material)
    return materials


def _read_nets(file: h5py.File, materials: int) -> tuple[Net | None, ...]:
    """/nets: a group for each material that has one; none where the energy is analytic."""
    neural = text(file.attrs["energy"]) == "neural"
    require(neural == ("nets" in file), "/nets must be there where, and only where, energy is neural")
    nets: list[Net | None] = []
    require(not neural or 0 < len(set(file["nets"]) & {str(m) for m in range(materials)})
            == len(file["nets"]), "/nets must hold one group or more, named by materials")
    for m in range(materials if neural else 0):
        place = f"/nets/{m}"
        if str(m) not in file["nets"]:
            nets.append(None)
            continue
        group = file["nets"][str(m)]
        weights = group["weights"][()].astype(float)
        require(weights.shape == (17153,) and np.isfinite(weights).all(),
                place, "/weights must be 17153 finite numbers")
        cells = int(number(group.attrs["cells"], f"{place} attribute 'cells'"))
        table = group["table"][()].astype(float) if cells else None
        if table is not None:
            n = table.shape[1]
            require(table.shape == (n * n, n) and n % 2 == 1 and np.isfinite(table).all(),
                    place, "/table must be a cube of finite numbers")
            table = table.reshape(n, n, n)
        nets.append(Net(text(group.attrs["sha256"]), weights, cells, table))
    return tuple(nets)


def _check_voxels(grid: dict[str, NDArray[Any]], materials: int, h: float) -> None:
    """Values of the grid: indices in range, cubes of edge h, fills and shape means that add up."""
    nodes = len(grid["rest"])
    for name in ("rest", "fill", "shape_mean", "mass", "hourglass"):
        require(np.isfinite(grid[name]).all(), f"/grid/{name} has values that are not finite")
    ends = dict(corners=nodes, material=materials, pinned=3, fixed=2, dependent=nodes, parent=nodes)
    for name, end in ((name, end) for name, end in ends.items() if name in grid):
        inside = (grid[name] >= 0) & (grid[name] < end)
        require(inside.all(), f"/grid/{name} must lie in 0..{end - 1}")
    fill, mean = grid["fill"], grid["shape_mean"]
    require(((fill > 0) & (fill <= 1.5)).all(), "/grid/fill must lie in (0, 1.5]")
    require((mean >= 0).all() and np.allclose(mean.sum(1), 1, rtol=0, atol=1e-9),
            "/grid/shape_mean must be >= 0 with sum 1 in each voxel")
    require((grid["mass"] >= 0).all(), "/grid/mass must be >= 0")
    if "fixed" in grid:
        require((grid["fixed"].T == (grid["pinned"] == 1)).T[grid["pinned"] > 0].all(), "/grid/fixed: not as pinned")
    if "dependent" in grid:
        require(np.isfinite(grid["parent_weight"]).all(), "/grid/parent_weight is not finite")
        require((grid["pinned"][grid["dependent"]] == 2).all() and (grid["pinned"][grid["parent"]] == 0).all(),
                "/grid/dependent must be marked by /grid/pinned, and /grid/parent free")
    if "traction" in grid:
        require(np.isfinite(grid["traction"]).all(), "/grid/traction has values that are not finite")
    corner = grid["rest"][grid["corners"]]
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    slack = 1e-9 * h + 16 * np.finfo(float).eps * np.abs(grid["rest"]).max()
    error = np.abs(corner - corner[:, :1] - h * bits).max()
    require(error <= slack, f"/grid/corners: a voxel is off a cube of edge h by {error:.3g} m")


def _check_steps(steps: dict[str, NDArray[Any]], time_scheme: str, dt: float) -> None:
    """Values of the steps: their lengths, a start without a step before, flags that are 0 or 1."""
    stages, length = time_scheme in ("sdirk2", "auto"), steps["length"]
    require(((length > 0) & (length <= dt * (1 + 1e-6))).all(), "/steps/length must be in (0, dt]")
    uneven = np.abs(np.diff(steps["time"]) - (length if stages else dt)).max()
    require(uneven <= 1e-6 * dt, f"/steps/time is off the time step dt by {uneven:.3g} s")
    require((steps["tolerance"] > 0).all(), "/steps/tolerance must be positive")
    for name in {"converged", "guarded", "mesh_error_trusted"} & set(steps):
        require((steps[name] <= 1).all(), f"/steps/{name} must be 0 or 1")
    for name in {"time_error", "time_ratio"} & set(steps):
        require((steps[name] >= 0).all(), f"/steps/{name} must be >= 0")
    if "mesh_error" in steps:
        has = np.isfinite(steps["mesh_error"])
        require((steps["mesh_error"][has] >= 0).all() and (steps["mesh_error_trusted"][~has] == 0).all()
                and (steps["mesh_error_largest"][has] >= steps["mesh_error"][has]).all(),
                "/steps/mesh_error: rms, largest and trusted contradict each other")
    require((steps["scheme"] <= (SDIRK2 if stages else BDF2)).all(), "/steps/scheme is out of range")
    if stages:
        require(steps["scheme"][0] != BDF2, "/steps/scheme: the first step cannot be BDF2 (1)")
        return
    require(steps["scheme"][0] == 0, "/steps/scheme: the first step must be Euler (0)")
    require(time_scheme == "bdf2" or not steps["scheme"].any(),
            "/steps/scheme has BDF2 steps in a run whose time_scheme is euler")


def _read_contact(file: h5py.File, voxels: int) -> dict[str, NDArray[Any]] | None:
    """/contact with its values checked; None where there is none."""
    if "contact" not in file:
        return None
    group = file["contact"]
    contact = {name: node[()] for name, node in group.items()}
    for name in LENGTHS:
        require(name in group.attrs, f"/contact lacks the attribute '{name}'")
        contact[name] = np.array(number(group.attrs[name], f"/contact attribute '{name}'"))
        positive = contact[name] > 0 or (name == "impact_speed" and contact[name] == 0)
        require(positive, f"/contact attribute '{name}' must be positive")
    for name in ("weights", "area", "centre", "normal", "half", "radius", "friction", "offset",
                 *({"bonds"} & set(contact))):
        require(np.isfinite(contact[name]).all(), f"/contact/{name} has values that are not finite")
    inside = (contact["voxel"] >= 0) & (contact["voxel"] < voxels)
    require(inside.all(), f"/contact/voxel must lie in 0..{voxels - 1}")
    require((contact["shape"] <= BOX).all(), "/contact/shape must be 0, 1 or 2")
    for name in ("area", "half", "radius", "friction"):
        require((contact[name] >= 0).all(), f"/contact/{name} must be >= 0")
    length = np.linalg.norm(contact["normal"][contact["shape"] == PLANE], axis=1)
    require(np.allclose(length, 1, rtol=0, atol=1e-9), "/contact/normal of a plane must have length 1")
    return contact


def _read_holders(file: h5py.File, grid: dict[str, NDArray[Any]], steps: dict[str, NDArray[Any]]) -> Holders | None:
    """/holders with its values checked, and those of the reactions in `steps`; None where there is none."""
    if "holders" not in file:
        return None
    group, pinned = file["holders"], grid["pinned"]
    names, of_node = tuple(text(name) for name in group["name"][()]), group["of_node"][()].astype(np.int64)
    require(all(names), "/holders/name has an empty name")
    inside = (of_node >= -1) & (of_node < len(names))
    require(inside.all(), f"/holders/of_node must lie in -1..{len(names) - 1}")
    require(((of_node >= 0) == (pinned != 0)).all(),
            "/holders/of_node must be -1 where /grid/pinned is 0, and only there")
    offset = group["offset"][()] if "offset" in group else None
    if offset is not None:
        followers = int((pinned == 2).sum())
        require(offset.shape[1] == followers,
                f"/holders/offset must be of the {followers} dependent nodes, got {offset.shape[1]}")
        require(np.isfinite(offset).all(), "/holders/offset has values that are not finite")
        require("moved" not in file.attrs or file.attrs["moved"],
                "/holders/offset is there where root attribute 'moved' is 0")
    component = group["of_component"][()].astype(np.int64) if "of_component" in group else None
    if component is not None:
        require("fixed" in grid, "/holders/of_component is there without /grid/fixed")
        require(((component >= -1) & (component < len(names))).all(),
                f"/holders/of_component must lie in -1..{len(names) - 1}")
        require(((component >= 0) == ((grid["fixed"] == 1) & (pinned == 0)[:, None])).all(),
                "/holders/of_component must be -1 where /grid/fixed is 0 or /grid/pinned is not, and only there")
    for name in {"reaction_force", "reaction_moment", "reaction_about"} & set(steps):
        require(np.isfinite(steps[name]).all(), f"/steps/{name} has values that are not finite")
        idle = np.setdiff1d(np.arange(len(names)), of_node if component is None else np.append(of_node, component))
        require((steps[name][:, idle] == 0).all(), f"/steps/{name} is not 0 of what holds no node")
    motion = {name: group[name][()] for name in MOTION} if "rate" in group else None
    require(motion is None or all(np.isfinite(values).all() for values in motion.values()),
            "/holders: a motion has values that are not finite")
    return Holders(names, of_node, offset, component, motion)


def _read_forces(file: h5py.File) -> dict[str, NDArray[Any]] | None:
    """/forces; None where there is none."""
    if "forces" not in file:
        return None
    forces = {name: node[()] for name, node in file["forces"].items()}
    require(all(np.isfinite(values).all() for values in forces.values()), "/forces has values that are not finite")
    require(np.allclose(forces["share"].sum(1), 1, rtol=0, atol=1e-9), "/forces/share must sum to 1")
    return forces


def read_state(file: h5py.File) -> State:
    """Checks the whole layout and reads all but x and v.

    @param file  open state file; it must stay open while `x` and `v` are in use
    @throws LayoutError  naming the first place that differs from the format
    """
    words, numbers = _read_words(file), _read_numbers(file)
    gravity = np.asarray(_attribute(file, "gravity"))
    require(gravity.shape == (3,) and gravity.dtype.kind == "f" and np.isfinite(gravity).all(),
            "root attribute 'gravity' must be three finite numbers")
    check_layout(file)
    materials = _read_materials(file)
    grid = {name: node[()] for name, node in file["grid"].items()}
    steps = {name: node[()] for name, node in file["steps"].items() 
             if name not in ("x", "v", "x_stage", "load", "load_stage")}
    _check_voxels(grid, len(materials), numbers["h"])
    _check_steps(steps, words["time_scheme"], numbers["dt"])
    return State(words, numbers["h"], numbers["dt"], gravity.astype(float), numbers["g_ref"],
                 numbers["tolerance"], materials, grid, steps, file["steps"]["x"],
                 file["steps"]["v"], _read_contact(file, len(grid["corners"])),
                 _read_nets(file, len(materials)), file["steps"].get("x_stage"),
                 bool(file.attrs.get("moved", 0)), _read_holders(file, grid, steps),
                 file["steps"].get("load"), file["steps"].get("load_stage"), _read_forces(file), file.get("wind"))
