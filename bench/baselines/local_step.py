# SPDX-License-Identifier: Apache-2.0
"""The local step: stretches of every voxel to the lagged quadratic omega/2 |F N - R|^2."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from dense_grid import Array

JACOBI_SWEEPS = 4
SMALLEST_STRETCH = 0.1


def neo_hookean(xp: Any, stretches: list[Array], mu: float, lam: float) -> Array:
    """mu sum((s^2 - 1)/2 - ln s) + lambda/2 ln^2 J; the sum by its series near rest, where float32 has
    no digits left for the difference. J below 0.1 continues quadratically."""
    shear, volume = 0, 0
    for s in stretches:
        e = xp.log1p(s - 1)
        series = 1 + e * (2 / 3 + e * (1 / 3 + e * (2 / 15 + e * (2 / 45 + e * (4 / 315 + e / 315)))))
        shear = shear + xp.where(xp.abs(e) < 0.1, e * e * series, (s * s - 1) / 2 - e)
        volume = volume + e
    J = xp.exp(volume)
    d = (J - 0.1) / 0.1
    continued = xp.where(J > 0.1, volume, math.log(0.1) + d - d * d / 2)
    return mu * (shear + volume - continued) + lam / 2 * continued**2


def fitted_stretches(xp: Any, sigma: list[Array], young: float, poisson: float) -> list[Array]:
    """n_i: the strain sigma_i n_i - 1 has the direction that is exact at rest and the length that
    gives the energy (network/paper_model.hpp)."""
    mu = young / (2 * (1 + poisson))
    lam = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    a = math.sqrt(2 * mu / young)
    b = (math.sqrt((3 * lam + 2 * mu) / young) - a) / 3
    s = [xp.clip(x, SMALLEST_STRETCH, None) for x in sigma]
    e = [xp.log1p(x - 1) for x in s]
    q = [a * x + b * (e[0] + e[1] + e[2]) for x in e]
    length2 = q[0] ** 2 + q[1] ** 2 + q[2] ** 2
    psi = xp.clip(neo_hookean(xp, s, mu, lam), 0, None)
    safe = xp.clip(length2, 1e-30, None)
    scale = xp.where(length2 > 1e-30, xp.sqrt(2 * psi / (young * safe)), 0 * psi)
    return [(1 + q[i] * scale) / s[i] for i in range(3)]


def library_svd(xp: Any, H: list[list[Array]], fit: Callable[[list[Array]], list[Array]]) -> tuple[
        list[list[Array]], list[list[Array]], Array]:
    """N N^T, R N^T and max n^2 of F = I + H by the library's batched decomposition."""
    F = xp.stack([xp.stack([H[i][j] + (1 if i == j else 0) for j in range(3)], -1)
                  for i in range(3)], -2)
    U, S, Vh = xp.linalg.svd(F)
    sign = xp.where(xp.linalg.det(F) < 0, -1 + 0 * S[..., 2], 1 + 0 * S[..., 2])
    n = fit([S[..., 0], S[..., 1], S[..., 2] * sign])
    NN = [[sum(Vh[..., k, i] * n[k] ** 2 * Vh[..., k, j] for k in range(3)) for j in range(3)]
          for i in range(3)]
    m = [n[0], n[1], n[2] * sign]
    RN = [[sum(U[..., i, k] * m[k] * Vh[..., k, j] for k in range(3)) for j in range(3)]
          for i in range(3)]
    return NN, RN, xp.maximum(xp.maximum(n[0], n[1]), n[2]) ** 2


def rotate(xp: Any, A: list[list[Array]], V: list[list[Array]], p: int, q: int) -> None:
    """A Jacobi rotation that makes A[p][q] zero, in place."""
    r = 3 - p - q
    off = A[p][q]
    some = xp.abs(off) > 1e-18  # theta^2 stays in float32
    theta = (A[q][q] - A[p][p]) / xp.where(some, 2 * off, 1 + 0 * off)
    t = xp.where(theta < 0, -1 + 0 * theta, 1 + 0 * theta) / (xp.abs(theta) + xp.sqrt(theta**2 + 1))
    t = xp.where(some, t, 0 * t)
    c = 1 / xp.sqrt(t * t + 1)
    s = t * c
    A[p][p], A[q][q] = A[p][p] - t * off, A[q][q] + t * off
    A[p][q] = A[q][p] = 0 * off
    rp, rq = c * A[r][p] - s * A[r][q], s * A[r][p] + c * A[r][q]
    A[r][p] = A[p][r] = rp
    A[r][q] = A[q][r] = rq
    for i in range(3):
        V[i][p], V[i][q] = c * V[i][p] - s * V[i][q], s * V[i][p] + c * V[i][q]


def jacobi_svd(xp: Any, H: list[list[Array]], fit: Callable[[list[Array]], list[Array]]) -> tuple[
        list[list[Array]], list[list[Array]], Array]:
    """The same by rotations of F^T F - I, without a library, which compiles into one loop."""
    one, zero = 1 + 0 * H[0][0], 0 * H[0][0]
    A = [[H[i][j] + H[j][i] + sum(H[k][i] * H[k][j] for k in range(3)) for j in range(3)]
         for i in range(3)]
    V = [[one if i == j else zero for j in range(3)] for i in range(3)]
    for _ in range(JACOBI_SWEEPS):
        for p, q in ((0, 1), (1, 2), (0, 2)):
            rotate(xp, A, V, p, q)
    F = [[H[i][j] + (1 if i == j else 0) for j in range(3)] for i in range(3)]
    det = (F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1])
           - F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0])
           + F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]))
    # sigma - 1 without the digits that 1 + lambda loses
    length = [1 + A[k][k] / (1 + xp.sqrt(xp.clip(1 + A[k][k], 0, None))) for k in range(3)]
    least = xp.minimum(xp.minimum(length[0], length[1]), length[2])
    sigma = [xp.where((det < 0) & (s == least), -s, s) for s in length]
    n = fit(sigma)
    small = 1e-6
    ratio = [n[k] / xp.where(xp.abs(sigma[k]) > small, sigma[k], small + 0 * one) for k in range(3)]
    NN = [[sum(V[i][k] * n[k] ** 2 * V[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    M = [[sum(V[i][k] * ratio[k] * V[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    RN = [[sum(F[i][k] * M[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return NN, RN, xp.maximum(xp.maximum(n[0], n[1]), n[2]) ** 2
