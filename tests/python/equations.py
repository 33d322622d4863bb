# SPDX-License-Identifier: Apache-2.0
"""The equations of one time step in float64, written from the definitions and not for speed.

    Phi(x) = a0/(2 dt^2) sum_c m_c |x_c - xhat_c|^2 + sum_v W_v psi(F_v) + E_variance + E_torsion
    F_v    = I + sum_c u_c (x) dN_c/dX,                u = x - X,  W_v = phi_v h^3

Stresses come from closed matrix formulas in F; laws in log stretches use a singular value
decomposition.
Corner c of a voxel lies on the + side of axis d when bit d of c is set; s_c are its signs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nets import neural_law
from state_file import Floats, Ints, State

BLOCK = 8192  # voxels treated at once
BITS = (np.arange(8)[:, None] >> np.arange(3)) & 1  # (8, 3)
SIGNS = 2.0 * BITS - 1.0  # (8, 3): s_c
MIRROR = np.arange(8)[:, None] ^ (1 << np.arange(3))  # (8, 3): corner c mirrored along d
CONTINUE_BELOW = 0.1  # ln is continued by a quadratic below this value

# psi [Pa] (n,) and P [Pa] (n, 3, 3) of deformation gradients (n, 3, 3)
Law = Callable[[Floats, float, float], tuple[Floats, Floats]]


def lame(young: float, poisson: float) -> tuple[float, float]:
    """mu = E/(2(1+nu)), lambda = E nu/((1+nu)(1-2nu)) [Pa]."""
    mu = young / (2 * (1 + poisson))
    return mu, young * poisson / ((1 + poisson) * (1 - 2 * poisson))


def continued_log(s: Floats) -> tuple[Floats, Floats]:
    """l(s) and l'(s): ln s above s0 = 0.1, below it ln s0 + d - d^2/2 with d = (s - s0)/s0."""
    s0 = CONTINUE_BELOW
    inside = s > s0
    safe, d = np.where(inside, s, s0), (s - s0) / s0
    value = np.where(inside, np.log(safe), np.log(s0) + d - d * d / 2)
    return value, np.where(inside, 1 / safe, (1 - d) / s0)


def cofactor(F: Floats) -> Floats:
    """cof F = dJ/dF: its columns are f2 x f3, f3 x f1, f1 x f2 for the columns f of F."""
    f1, f2, f3 = F[..., 0], F[..., 1], F[..., 2]
    return np.stack([np.cross(f2, f3), np.cross(f3, f1), np.cross(f1, f2)], axis=-1)


def determinant(F: Floats) -> Floats:
    """J = f1 . (f2 x f3)."""
    return np.einsum("ni,ni->n", F[..., 0], np.cross(F[..., 1], F[..., 2]))


def rotation(F: Floats) -> Floats:
    """The rotation R that maximises tr(R^T F), also for det F < 0.

    It is U V^T of the singular value decomposition whose U and V are rotations. Found without it:
    tr(R(q)^T F) = q^T K q for a unit quaternion q = (w, x, y, z), so q is the eigenvector of the
    largest eigenvalue of the symmetric (4, 4) matrix K.
    """
    K = np.empty((len(F), 4, 4))
    trace = np.trace(F, axis1=1, axis2=2)
    K[:, 0, 0] = trace
    K[:, 1:, 1:] = F + F.transpose(0, 2, 1) - trace[:, None, None] * np.eye(3)
    for d in range(3):
        i, j = (d + 1) % 3, (d + 2) % 3
        K[:, 0, d + 1] = K[:, d + 1, 0] = F[:, j, i] - F[:, i, j]
    q = np.linalg.eigh(K)[1][:, :, 3]
    w, axis = q[:, 0, None, None], q[:, 1:]
    turn = np.cross(axis[:, None, :], np.eye(3)).transpose(0, 2, 1)  # turn b = axis x b
    dyad = axis[:, :, None] * axis[:, None, :]
    return (2 * w * w - 1) * np.eye(3) + 2 * dyad + 2 * w * turn


def fixed_corotated(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
    """psi = mu |F - R|^2 + lambda/2 (J-1)^2,  P = 2 mu (F - R) + lambda (J-1) cof F."""
    strain, J = F - rotation(F), determinant(F)
    psi = mu * np.einsum("nij,nij->n", strain, strain) + lam / 2 * (J - 1) ** 2
    return psi, 2 * mu * strain + (lam * (J - 1))[:, None, None] * cofactor(F)


def neo_hookean(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
    """psi = mu/2 (|F|^2-3) - mu l + lambda/2 l^2,  P = mu F + (lambda l - mu) l'(J) cof F.

    l = l(J) is the continued logarithm.
    """
    l, dl = continued_log(determinant(F))
    psi = mu / 2 * (np.einsum("nij,nij->n", F, F) - 3) - mu * l + lam / 2 * l * l
    return psi, mu * F + ((lam * l - mu) * dl)[:, None, None] * cofactor(F)


def stable_neo_hookean(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
    """The 2018 form with mu' = 4mu/3, lambda' = lambda + 5mu/6, a = 1 + 3mu'/(4lambda'), I = |F|^2:

    psi = mu'/2 [I - 3 - ln((I+1)/4)] + lambda'/2 [(J-a)^2 - (1-a)^2]
    P   = mu' (1 - 1/(I+1)) F + lambda' (J-a) cof F
    """
    m, k = 4 * mu / 3, lam + 5 * mu / 6
    a = 1 + 3 * m / (4 * k)
    I, J = np.einsum("nij,nij->n", F, F), determinant(F)
    psi = m / 2 * (I - 3 - np.log((I + 1) / 4)) + k / 2 * ((J - a) ** 2 - (1 - a) ** 2)
    P = (m * (1 - 1 / (I + 1)))[:, None, None] * F + (k * (J - a))[:, None, None] * cofactor(F)
    return psi, P


def stvk(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
    """psi = mu |E|^2 + lambda/2 (tr E)^2,  P = F (2 mu E + lambda tr E I),  E = (F^T F - I)/2."""
    E = (F.transpose(0, 2, 1) @ F - np.eye(3)) / 2
    trace = np.trace(E, axis1=1, axis2=2)
    psi = mu * np.einsum("nij,nij->n", E, E) + lam / 2 * trace**2
    return psi, F @ (2 * mu * E + lam * trace[:, None, None] * np.eye(3))


def signed_svd(F: Floats) -> tuple[Floats, Floats, Floats]:
    """F = U diag(sigma) V^T of rotations: the smallest stretch carries the sign of det F."""
    U, sigma, Vt = np.linalg.svd(F)
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    U[:, :, 2] *= sign[:, None]
    sigma[:, 2] *= sign
    return U, sigma, Vt


def hencky(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
    """psi = mu sum e^2 + lambda/2 (sum e)^2,  P = U diag((2mu e + lambda sum e) l') V^T.

    e = l(sigma) is the continued logarithm.
    """
    U, sigma, Vt = signed_svd(F)
    e, de = continued_log(sigma)
    total = e.sum(1)
    psi = mu * (e * e).sum(1) + lam / 2 * total**2
    return psi, (U * ((2 * mu * e + lam * total[:, None]) * de)[:, None, :]) @ Vt


def continued_exp(x: Floats) -> tuple[Floats, Floats]:
    """exp(x) - 1 - x and the slope of exp, which is a parabola of the same curvature above 12."""
    inside = np.minimum(x, 12)
    d, e = x - inside, np.exp(inside)
    return np.expm1(inside) - inside + e * (d + d * d / 2) - d, e * (1 + d)


def isochoric_sum(F: Floats, power: float) -> tuple[Floats, Floats, tuple[Floats, ...]]:
    """S = sum exp(a e'_i) - 3, its slope in F, and ln J with its own; e' = e - ln J/3."""
    U, sigma, Vt = signed_svd(F)
    e, de = continued_log(sigma)
    log_J = e.sum(1)
    y, dy = continued_exp(power * (e - log_J[:, None] / 3))
    slope = power * (dy - dy.mean(1)[:, None])
    return y.sum(1), (U * (slope * de)[:, None, :]) @ Vt, (log_J, (U * de[:, None, :]) @ Vt)


def with_volume(psi: Floats, P: Floats, volume: tuple[Floats, ...], bulk: float
                ) -> tuple[Floats, Floats]:
    """Adds K/2 (ln J)^2."""
    log_J, slope = volume
    return psi + bulk / 2 * log_J**2, P + bulk * log_J[:, None, None] * slope


def ogden(power: float) -> Law:
    """psi = 2 mu/a^2 (sum exp(a e'_i) - 3) + K/2 (ln J)^2."""
    def law(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
        S, dS, volume = isochoric_sum(F, power)
        c = 2 * mu / power**2
        return with_volume(c * S, c * dS, volume, lam + 2 * mu / 3)
    return law


def mooney_rivlin(share: float) -> Law:
    """psi = mu/2 [(1-r) (I1-3) + r (I2-3)] + K/2 (ln J)^2."""
    def law(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
        (I1, dI1, volume), (I2, dI2, _) = isochoric_sum(F, 2), isochoric_sum(F, -2)
        c1, c2 = mu / 2 * (1 - share), mu / 2 * share
        return with_volume(c1 * I1 + c2 * I2, c1 * dI1 + c2 * dI2, volume, lam + 2 * mu / 3)
    return law


def gent(limit: float) -> Law:
    """psi = -mu L/2 l(1 - (I1-3)/L) + K/2 (ln J)^2."""
    def law(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
        I1, dI1, volume = isochoric_sum(F, 2)
        value, slope = continued_log(1 - I1 / limit)
        return with_volume(-mu * limit / 2 * value, (mu / 2 * slope)[:, None, None] * dI1, volume,
                           lam + 2 * mu / 3)
    return law


def law_of(name: str) -> Law:
    """The law of a name as files spell it: "hencky", "ogden=4"."""
    family, _, shape = name.partition("=")
    return FAMILY[family](float(shape)) if shape else LAW[name]


FAMILY: dict[str, Callable[[float], Law]] = {
    "ogden": ogden, "mooney-rivlin": mooney_rivlin, "gent": gent,
}
LAW: dict[str, Law] = {
    "fixed-corotated": fixed_corotated,
    "neo-hookean": neo_hookean,
    "stable-neo-hookean": stable_neo_hookean,
    "stvk": stvk,
    "hencky": hencky,
}


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


@dataclass(frozen=True)
class Potential:
    """Parts of Phi [J] and its gradient [N], (nodes, 3)."""

    inertia: float
    elastic: float
    hourglass: float
    gradient: Floats
    contact: float = 0.0
    load: float = 0.0  # of tractions

    @property
    def value(self) -> float:
        """Phi [J]."""
        return self.inertia + self.elastic + self.hourglass + self.contact + self.load

    def with_contact(self, energy: float, gradient: Floats) -> Potential:
        """The same with the energy of contact [J] and its gradient [N], (nodes, 3), added."""
        return replace(self, contact=energy, gradient=self.gradient + gradient)


def make_body(state: State) -> Body:
    """The body of a state file, its voxels sorted by material and cut into blocks."""
    grid, mode, blocks = state.grid, state.words["hourglass"], []
    for index, material in enumerate(state.materials):
        mine = np.flatnonzero(grid["material"] == index)
        mu, lam = lame(material.young, material.poisson)
        law = law_of(material.law)
        net = state.nets[index] if state.nets else None
        if net:
            law = neural_law(net, law, material.young, material.poisson)
        for start in range(0, len(mine), BLOCK):
            part = mine[start : start + BLOCK]
            mean = grid["shape_mean"][part]
            blocks.append(
                Block(grid["corners"][part].astype(np.int64), mean_gradients(mean, state.h),
                      patterns(mean, state.h), grid["fill"][part] * state.h**3,
                      grid["hourglass"][part], law, mu, lam))
    none = np.zeros_like(grid["rest"])
    loose = (grid["pinned"][:, None] == 0) & (grid.get("fixed", none) == 0)
    return Body(grid["rest"], grid["mass"], loose.any(1), loose, grid.get("traction", none),
                state.h, mode != "off",
                mode == "full", blocks)


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
    elastic, hourglass, gradient = internal_energy(body, x, R)
    pull = a0 * body.mass[:, None] * (x - xhat) / dt**2
    return Potential(float((pull * (x - xhat)).sum() / 2), elastic, hourglass,
                     gradient + pull - body.traction, load=-float((body.traction * x).sum()))


def residual(body: Body, gradient: Floats, g_ref: float) -> float:
    """|grad Phi|_2 / (g_ref sqrt(sum m_c^2)), over what is loose and over the free nodes."""
    reference = g_ref * np.linalg.norm(body.mass[body.free])
    return float(np.linalg.norm(gradient[body.loose]) / reference) if reference > 0 else 0.0


def equilibrium(body: Body, gravity: Floats, factor: float, x: Floats) -> tuple[Potential, float]:
    """Potential at an equilibrium under a load factor, and its relative residual.

    The forces left on what is loose over the larger of the loads there and the forces that hold the
    rest (2-norms).
    """
    elastic, hourglass, gradient = internal_energy(body, x, rotations(body, x))
    load = factor * (body.mass[:, None] * gravity + body.traction)
    left = gradient - load
    reference = max(np.linalg.norm(load[body.loose]), np.linalg.norm(left[~body.loose]))
    found = Potential(0.0, elastic, hourglass, left, load=-float((load * x).sum()))
    return found, float(np.linalg.norm(left[body.loose]) / reference) if reference > 0 else 0.0


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
