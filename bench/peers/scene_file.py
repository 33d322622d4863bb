# SPDX-License-Identifier: Apache-2.0
"""Scenes that two codes shall solve: a box, one material, faces that are held or moved, runs.

A scene is a JSON file; README.md lists its keys. SI units throughout.
"""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FACES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")
ELEMENTS = ("hex", "hex27", "tet10")
QUANTITIES = ("face_mean", "point", "torque")


class SceneError(ValueError):
    """What a scene file has wrong, with the name of the file."""


@dataclass(frozen=True)
class Material:
    """psi = mu/2 (I - 3) - mu ln J + lambda/2 (ln J)^2."""

    law: str
    young: float  # [Pa]
    poisson: float
    density: float  # [kg/m^3]

    @property
    def mu(self) -> float:
        """[Pa]"""
        return self.young / (2 * (1 + self.poisson))

    @property
    def lam(self) -> float:
        """lambda [Pa]"""
        return self.young * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))


@dataclass(frozen=True)
class Boundary:
    """Components of the displacement that are prescribed on a face of the box.

    At the load factor t they are t shift, or those of a turn by t angle about the line along x
    through centre. Neither given: 0.
    """

    face: str
    components: tuple[int, ...] = (0, 1, 2)
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m]
    angle: float = 0.0  # [rad], positive from y to z
    centre: tuple[float, float] = (0.0, 0.0)  # y, z [m]


@dataclass(frozen=True)
class Probe:
    """face_mean: displacement averaged over a face [m]; point: that of the node at `at` [m];
    torque: moment [N m] about the axis of the turn that holds a face there."""

    name: str
    quantity: str
    face: str = ""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Run:
    """One mesh: element, cells of the box along x, y, z, and in dynamics the kind of mass."""

    element: str
    cells: tuple[int, int, int]
    mass: str = ""  # "lumped" or "consistent"


@dataclass(frozen=True)
class Scene:
    """Static if dt is 0, else steps of implicit Euler from rest."""

    name: str
    box: tuple[float, float, float]  # edges [m]; the box begins at the origin
    material: Material
    boundary: tuple[Boundary, ...]
    probes: tuple[Probe, ...]
    runs: tuple[Run, ...]
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m/s^2]
    load_factors: tuple[float, ...] = (1.0,)  # of gravity and of prescribed displacements
    tolerance: float = 1e-9  # of the residual, at the last load factor and in each time step
    dt: float = 0.0  # [s]
    steps: int = 0


def _frozen(value: Any) -> Any:
    return tuple(_frozen(v) for v in value) if isinstance(value, list) else value


def _build(kind: Any, values: dict[str, Any], where: str) -> Any:
    """A dataclass of the values; @throws SceneError on a key that is unknown or missing."""
    fields = {field.name: field for field in dataclasses.fields(kind)}
    unknown = sorted(set(values) - set(fields))
    missing = sorted(name for name, field in fields.items()
                     if field.default is dataclasses.MISSING and name not in values)
    if unknown or missing:
        raise SceneError(f"{where}: unknown keys {unknown}, missing keys {missing}")
    return kind(**{name: _frozen(value) for name, value in values.items()})


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise SceneError(message)


def _check(scene: Scene, where: str) -> None:
    _require(scene.material.law == "neo-hookean", f"{where}: unknown law {scene.material.law}")
    for face in (*(b.face for b in scene.boundary), *(p.face for p in scene.probes if p.face)):
        _require(face in FACES, f"{where}: unknown face {face}")
    turned = {b.face for b in scene.boundary if b.angle}
    for probe in scene.probes:
        _require(probe.quantity != "torque" or probe.face in turned,
                 f"{where}: {probe.name} is a torque, and no turn holds {probe.face}")
        _require(probe.quantity in QUANTITIES, f"{where}: unknown quantity {probe.quantity}")
    for run in scene.runs:
        _require(run.element in ELEMENTS, f"{where}: unknown element {run.element}")
        _require(run.mass in (("lumped", "consistent") if scene.dt else ("",)),
                 f"{where}: a run in time needs a mass, lumped or consistent, a static one none")
    _require(list(scene.load_factors) == sorted(scene.load_factors) and
             math.isclose(scene.load_factors[-1], 1), f"{where}: load_factors must grow to 1")


def read_scene(path: Path) -> Scene:
    """The scene of a file. @throws SceneError"""
    values = json.loads(path.read_text())
    where = path.name
    values["material"] = _build(Material, values["material"], f"{where}: material")
    for key, kind in (("boundary", Boundary), ("probes", Probe), ("runs", Run)):
        values[key] = [_build(kind, item, f"{where}: {key}") for item in values[key]]
    scene: Scene = _build(Scene, values, where)
    _check(scene, where)
    return scene
