# SPDX-License-Identifier: Apache-2.0
"""The equations of one time step in float64, written from the definitions and not for speed.

    Phi(x) = a0/(2 dt^2) sum_c m_c |x_c - xhat_c|^2 + sum_v W_v psi(F_v) + E_variance + E_torsion
    F_v    = I + sum_c u_c (x) dN_c/dX,                u = x - X,  W_v = phi_v h^3

The laws are in laws.py.
Corner c of a voxel lies on the + side of axis d when bit d of c is set; s_c are its signs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from laws import Law, determinant, lame, law_of, rotation
from nets import neural_law
from state_file import Floats, Ints, State

BLOCK = 8192  # voxels treated at once
BITS = (np.arange(8)[:, None] >> np.arange(3)) & 1  # (8, 3)
SIGNS = 2.0 * BITS - 1.0  # (8, 3): s_c
MIRROR = np.arange(8)[:, None] ^ (1 << np.arange(3))  # (8, 3): corner c mirrored along d


def mean_gradients(shape_mean: Floats, h: float) -> Floats:
    """(n, 8, 3) mean of dN_c/dX_d over the fill: s_cd (Nbar_c + Nbar_c')/h, c' mirrored along d."""
    return SIGNS * (shape_mean[:, :, None] + shape_mean[:, MIRROR]) / h


def patterns(shape_mean: Floats, h: float) -> Floats:
    """(n, 4, 8) rows that take corner values [m] to a_xy, a_yz, a_zx [1/m] and a_xyz [1/m^2].

    a_xyz = sum_c s_x s_y s_z u_c/h^3,  a_xy = sum_c s_x s_y u_c/(2h^2) + xi_z a_xyz and cyclic,
    with the centroid of the fill xi = h/2 sum_c Nbar_c s_c.
    """
    sx, sy, sz = SIGNS.T
    xyz = sx * sy * sz / h**3
    pairs = np.stack([sx * sy, sy * sz, sz * sx]) / (2 * h**2)
    centroid = h / 2 * shape_mean @ SIGNS
    rows = np.empty((len(shape_mean), 4, 8))
    rows[:, :3] = pairs + centroid[:, [2, 0, 1], None] * xyz
    rows[:, 3] = xyz
    return rows


@dataclass(frozen=True)
class Block:
    """Up to BLOCK voxels of one material."""

    corners: Ints  # (n, 8)
    gradients: Floats  # (n, 8, 3) [1/m]
    patterns: Floats  # (n, 4, 8)
    volume: Floats  # (n,) W = phi h^3 [m^3]
    weights: Floats  # (n, 4) [Pa] of the patterns, before the fill
    law: Law
    mu: float  # [Pa]
    lam: float  # [Pa]
    viscous_time: float = 0.0  # tau [s]


@dataclass(frozen=True)
class Body:
    """The constant data of a run."""

    rest: Floats  # (nodes, 3) [m]
    mass: Floats  # (nodes,) [kg]
    free: NDArray[np.bool_]  # (nodes,): a component is
    loose: NDArray[np.bool_]  # (nodes, 3): components that are neither pinned, held nor moved
    traction: Floats  # (nodes, 3) [N]
    h: float  # [m]
    variance: bool
    torsion: bool
    blocks: list[Block]
    dependent: NDArray[np.bool_]  # (nodes,): follows parent nodes
    parents: tuple[Ints, Ints, Floats]  # dependent node, parent node and weight, a row for each pair

    def fold(self, gradient: Floats) -> Floats:
        """The gradient by free nodes, dependent ones following: their part goes to their parents."""
        nodes, parents, weights = self.parents
        folded = gradient.copy()
        np.add.at(folded, parents, weights[:, None] * gradient[nodes])
        folded[self.dependent] = 0
        return folded

    def follow(self, values: Floats) -> Floats:
        """The same values with those of dependent nodes from their parents."""
        nodes, parents, weights = self.parents
        filled = values.copy()
        filled[self.dependent] = 0
        np.add.at(filled, nodes, weights[:, None] * values[parents])
        return filled


@dataclass(frozen=True)
class Potential:
    """Parts of Phi [J] and its gradient [N], (nodes, 3)."""

    inertia: float
    elastic: float
    hourglass: float
    gradient: Floats
    contact: float = 0.0
    load: float = 0.0  # of tractions
    viscous: float = 0.0
    inertial: Floats | None = None  # part of the gradient [N], (nodes, 3)

    @property
    def value(self) -> float:
        """Phi [J]."""
        return (self.inertia + self.elastic + self.hourglass + self.viscous + self.contact +
                self.load)

    def with_contact(self, energy: float, gradient: Floats) -> Potential:
        """The same with the energy of contact [J] and its gradient [N], (nodes, 3), added."""
        return replace(self, contact=energy, gradient=self.gradient + gradient)

    def with_damping(self, energy: float, gradient: Floats) -> Potential:
        """The same with the energy of damping [J] and its gradient [N], (nodes, 3), added."""
        return replace(self, viscous=energy, gradient=self.gradient + gradient)


def make_body(state: State) -> Body:
    """The body of a state file, its voxels sorted by material and cut into blocks."""
    grid, mode, blocks = state.grid, state.words["hourglass"], []
    for index, material in enumerate(state.materials):
        mine = np.flatnonzero(grid["material"] == index)
        mu, lam = lame(material.young, material.poisson)
        law = law_of(material.law)
        net = state.nets[index] if state.nets else None
        if net:
            law = neural_law(net, material.law, material.young, material.poisson)
        for start in range(0, len(mine), BLOCK):
            part = mine[start : start + BLOCK]
            mean = grid["shape_mean"][part]
            blocks.append(
                Block(grid["corners"][part].astype(np.int64), mean_gradients(mean, state.h),
                      patterns(mean, state.h), grid["fill"][part] * state.h**3,
                      grid["hourglass"][part], law, mu, lam, material.viscous_time))
    none, empty = np.zeros_like(grid["rest"]), np.zeros(0, np.int64)
    loose = (grid["pinned"][:, None] == 0) & (grid.get("fixed", none) == 0)
    return Body(grid["rest"], grid["mass"], loose.any(1), loose, grid.get("traction", none),
                state.h, mode != "off",
                mode == "full", blocks, grid["pinned"] == 2,
                (grid.get("dependent", empty), grid.get("parent", empty),
                 grid.get("parent_weight", np.zeros(0))))


def deformation_gradient(block: Block, u: Floats) -> Floats:
    """(n, 3, 3): F = I + sum_c u_c (x) dN_c/dX for displacements u [m], (nodes, 3)."""
    return np.eye(3) + u[block.corners].transpose(0, 2, 1) @ block.gradients


def rotations(body: Body, x: Floats) -> list[Floats]:
    """R_v of every block at the positions x [m]; empty when the torsion correction is off.

    0 where s_1 + s_2 <= 1e-6 max(s_0, 1) for the signed stretches: there the rotation is not unique.
    """
    if not body.torsion:
        return []
    result = []
    for block in body.blocks:
        F = deformation_gradient(block, x - body.rest)
        s = np.linalg.svd(F, compute_uv=False)
        s[:, 2] *= np.sign(determinant(F))
        unique = s[:, 1] + s[:, 2] > 1e-6 * np.maximum(s[:, 0], 1)
        result.append(rotation(F) * unique[:, None, None])
    return result


def _elastic(block: Block, u: Floats) -> tuple[float, Floats]:
    """Energy sum W psi and its gradient on the corners, W P dN_c/dX: (n, 8, 3)."""
    psi, P = block.law(deformation_gradient(block, u), block.mu, block.lam)
    return float(block.volume @ psi), block.gradients @ (P * block.volume[:, None, None]).transpose(
        0, 2, 1)


def _variance(block: Block, u: Floats, h: float) -> tuple[float, Floats]:
    """W/2 [h^2/6 sum c_p |a_p|^2 + h^4/48 c_xyz |a_xyz|^2] and its gradient on the corners."""
    a = block.patterns @ u[block.corners]  # (n, 4, 3)
    moments = np.array([h**2 / 6, h**2 / 6, h**2 / 6, h**4 / 48])
    slope = (block.volume[:, None] * block.weights * moments)[:, :, None] * a
    return float((slope * a).sum() / 2), block.patterns.transpose(0, 2, 1) @ slope


def _torsion(block: Block, u: Floats, R: Floats, h: float) -> tuple[float, Floats]:
    """Torsion correction with the rotations R held, and its gradient on the corners.

    W h^2/24 [ mu ((al+be)^2 + (be+ga)^2 + (ga+al)^2) - 2 (c_yz al^2 + c_zx be^2 + c_xy ga^2) ]
    al = (R^T a_yz)_x,  be = (R^T a_zx)_y,  ga = (R^T a_xy)_z
    """
    order = [1, 2, 0]  # yz, zx, xy belong to the components x, y, z
    rows, c = block.patterns[:, order], block.weights[:, order]
    a = rows @ u[block.corners]
    t = np.einsum("nid,ndi->nd", R, a)  # column d of R times pattern d
    scale = block.volume[:, None] * h**2 / 24
    slope = scale * (2 * block.mu * (t + t.sum(1, keepdims=True)) - 4 * c * t)
    force = slope[:, :, None] * R.transpose(0, 2, 1)  # (n, 3 patterns, 3)
    return float((slope * t).sum() / 2), rows.transpose(0, 2, 1) @ force


def internal_energy(body: Body, x: Floats, R: list[Floats]) -> tuple[float, float, Floats]:
    """Elastic energy, hourglass energy (variance and torsion) [J] and their gradient [N].

    @param x  positions [m], (nodes, 3)
    @param R  rotations of the torsion correction, from rotations() at the start of the step
    """
    u, gradient = x - body.rest, np.zeros_like(body.rest)
    elastic = hourglass = 0.0
    for index, block in enumerate(body.blocks):
        energy, force = _elastic(block, u)
        elastic += energy
        extra = [_variance(block, u, body.h)] if body.variance else []
        extra += [_torsion(block, u, R[index], body.h)] if body.torsion else []
        for energy, part in extra:
            hourglass += energy
            force = force + part
        for d in range(3):
            gradient[:, d] += np.bincount(block.corners.ravel(), force[:, :, d].ravel(), len(u))
    return elastic, hourglass, gradient


@dataclass(frozen=True)
class Motion:
    """What a step starts from: x^n, v^n and, for BDF2, x^{n-1}, v^{n-1}; all (nodes, 3)."""

    x: Floats
    v: Floats
    x_before: Floats | None = None  # None: implicit Euler
    v_before: Floats | None = None


def predictor(motion: Motion, gravity: Floats, dt: float) -> tuple[float, Floats]:
    """a0 and xhat [m].

    Euler  a0 = 1     xhat = x^n + dt v^n + dt^2 g
    BDF2   a0 = 9/4   xhat = (4x^n - x^{n-1})/3 + 2dt/9 (4v^n - v^{n-1}) + 4/9 dt^2 g
    """
    if motion.x_before is None or motion.v_before is None:
        return 1.0, motion.x + dt * motion.v + dt**2 * gravity
    x, v = 4 * motion.x - motion.x_before, 4 * motion.v - motion.v_before
    return 9 / 4, x / 3 + 2 * dt / 9 * v + 4 / 9 * dt**2 * gravity


def velocity(motion: Motion, x: Floats, dt: float) -> Floats:
    """v^{n+1}: Euler (x^{n+1} - x^n)/dt, BDF2 (3x^{n+1} - 4x^n + x^{n-1})/(2dt)."""
    if motion.x_before is None:
        return (x - motion.x) / dt
    return (3 * x - 4 * motion.x + motion.x_before) / (2 * dt)


def potential(body: Body, motion: Motion, gravity: Floats, dt: float, x: Floats,
              R: list[Floats]) -> Potential:
    """Phi(x) and its gradient, on pinned nodes too; R as in internal_energy()."""
    a0, xhat = predictor(motion, gravity, dt)
    return potential_about(body, a0 / dt**2, xhat, x, R)


def potential_about(body: Body, weight: float, xhat: Floats, x: Floats,
                    R: list[Floats]) -> Potential:
    """Phi(x) with the inertia weight/2 sum m |x - xhat|^2, weight in 1/s^2."""
    elastic, hourglass, gradient = internal_energy(body, x, R)
    pull = weight * body.mass[:, None] * (x - xhat)
    return Potential(float((pull * (x - xhat)).sum() / 2), elastic, hourglass,
                     gradient + pull - body.traction, load=-float((body.traction * x).sum()),
                     inertial=pull)


def residual(body: Body, gradient: Floats, g_ref: float) -> float:
    """|grad Phi|_2 / (g_ref sqrt(sum m_c^2)), over what is loose and over the free nodes."""
    reference = g_ref * np.linalg.norm(body.mass[body.free])
    folded = body.fold(gradient)
    return float(np.linalg.norm(folded[body.loose]) / reference) if reference > 0 else 0.0


def equilibrium(body: Body, gravity: Floats, factor: float, x: Floats) -> tuple[Potential, float]:
    """Potential at an equilibrium under a load factor, and its relative residual.

    The forces left on what is loose, with those of dependent nodes folded, over the larger of the loads
    there and the forces that hold the rest (2-norms).
    """
    elastic, hourglass, gradient = internal_energy(body, x, rotations(body, x))
    load = factor * (body.mass[:, None] * gravity + body.traction)
    left = gradient - load
    reference = max(np.linalg.norm(load[body.loose]), np.linalg.norm(left[~body.loose]))
    found = Potential(0.0, elastic, hourglass, left, load=-float((load * x).sum()))
    off = float(np.linalg.norm(body.fold(left)[body.loose]))
    return found, off / reference if reference > 0 else 0.0


def mass_factors(state: State) -> tuple[Floats, float]:
    """One density factor a material, and the worst relative error of the masses that it leaves.

    m_c = sum over materials of factor * sum_v rho phi_v h^3 Nbar_c, solved by least squares; the
    error of a node is taken relative to its mass plus 1e-3 of the largest mass.
    """
    grid, nodes, columns = state.grid, len(state.grid["mass"]), []
    for index, material in enumerate(state.materials):
        mine = grid["material"] == index
        part = grid["shape_mean"][mine] * (material.density * state.h**3 * grid["fill"][mine, None])
        columns.append(np.bincount(grid["corners"][mine].ravel(), part.ravel(), nodes))
    table = np.stack(columns, axis=1)
    factors = np.linalg.lstsq(table, grid["mass"], rcond=None)[0]
    error = np.abs(table @ factors - grid["mass"]) / (grid["mass"] + 1e-3 * grid["mass"].max())
    return factors, float(error.max())
