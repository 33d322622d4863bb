# SPDX-License-Identifier: Apache-2.0
"""The elastic laws in float64: energy and first Piola-Kirchhoff stress of deformation gradients, by
closed matrix formulas in F; laws in log stretches use a singular value decomposition."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from state_file import Floats

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
