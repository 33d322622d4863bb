# SPDX-License-Identifier: Apache-2.0
"""NeuralMTL from the weights or the table of a state file, written from the definitions.

    psi = psi_law + E D(e),   D = w (psi_theta - psi_law)/E,   e = ln sigma
    psi_theta/E = omega/2 sum_i q_i^2,   omega = 1/(1 - 2 nu)  (3K/E)
    q_i = (a+b) e_i + b (e_j+e_k) + f(x_i) - f(0) - f_0 e_i - f_1 (e_j+e_k)
    x_i = (e_i, e_j+e_k, e_j e_k),   f_0, f_1 the slopes of f at 0 in its first two inputs

D is evaluated by the net, or by the tricubic B-spline that the program says it used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from laws import Law, law_of
from state_file import Floats, Net

OTHERS = ((1, 2), (2, 0), (0, 1))
STRETCH, TRACE = (0.9, 1.25), (np.log(2), 1.2)  # the fitted box and where the law alone is left
SHARE = (0.9, 1.5)  # the same of I1 - 3 over the limit of Gent's law


def ramp(y: Floats, start: float, end: float) -> tuple[Floats, Floats]:
    """1 below start, 0 beyond end of |y|, a polynomial of degree five between; and its slope."""
    x = np.clip((np.abs(y) - start) / (end - start), 0, 1)
    slope = -30 * x**2 * (1 - x) ** 2 * np.sign(y) / (end - start)
    return 1 - x**3 * (10 - 15 * x + 6 * x**2), slope


def weight(e: Floats, limit: float) -> tuple[Floats, Floats]:
    """w (n,) and dw/de (n, 3); limit is that of I1 - 3, infinity where the law has none."""
    r, dr = ramp(e, *STRETCH)
    t, dt = ramp(e.sum(1), *TRACE)
    E = 2 * np.exp(2 * (e - e.mean(1, keepdims=True))) / limit
    g, dg = ramp(E.sum(1) / 2 - 3 / limit, *SHARE)
    slope = np.stack([dr[:, i] * r[:, j] * r[:, k] for i, (j, k) in enumerate(OTHERS)], 1)
    inner = slope * t[:, None] + (r.prod(1) * dt)[:, None]
    return (r.prod(1) * t * g,
            inner * g[:, None] + (r.prod(1) * t * dg)[:, None] * (E - E.mean(1, keepdims=True)))


@dataclass(frozen=True)
class Mlp:
    """f(x) = w3 silu(W2 silu(W1 x + b1) + b2) + b3."""

    W1: Floats
    b1: Floats
    W2: Floats
    b2: Floats
    w3: Floats
    b3: float

    @staticmethod
    def of(weights: Floats) -> Mlp:
        """From 17153 numbers, layer by layer."""
        parts = np.split(weights.astype(float), np.cumsum([384, 128, 16384, 128, 128]))
        return Mlp(parts[0].reshape(128, 3), parts[1], parts[2].reshape(128, 128), parts[3],
                   parts[4], float(parts[5][0]))

    def __call__(self, x: Floats) -> tuple[Floats, Floats]:
        """f (n,) and grad f (n, 3) at x (n, 3)."""
        z1 = x @ self.W1.T + self.b1
        s1 = 1 / (1 + np.exp(-z1))
        z2 = (z1 * s1) @ self.W2.T + self.b2
        s2 = 1 / (1 + np.exp(-z2))
        back = (self.w3 * s2 * (1 + z2 * (1 - s2))) @ self.W2
        return (z2 * s2) @ self.w3 + self.b3, (back * s1 * (1 + z1 * (1 - s1))) @ self.W1


def net_energy(net: Net, poisson: float, e: Floats) -> tuple[Floats, Floats]:
    """psi_theta/E (n,) and its slope in e (n, 3)."""
    omega = 1 / (1 - 2 * poisson)
    a = np.sqrt((1 - 2 * poisson) / (1 + poisson))
    b = (1 - a) / 3
    mlp = Mlp.of(net.weights)
    f0, g0 = mlp(np.zeros((1, 3)))
    g0[:, 2] = 0  # the slope in e_j e_k is of second order in e and stays
    psi, slope = np.zeros(len(e)), np.zeros_like(e)
    for i, (j, k) in enumerate(OTHERS):
        x = np.stack([e[:, i], e[:, j] + e[:, k], e[:, j] * e[:, k]], 1)
        f, g = mlp(x)
        q = (a + b) * x[:, 0] + b * x[:, 1] + f - f0[0] - x @ g0[0]
        g = g - g0[0] + np.array([a + b, b, 0])
        psi += omega / 2 * q**2
        slope[:, i] += omega * q * g[:, 0]
        slope[:, j] += omega * q * (g[:, 1] + e[:, k] * g[:, 2])
        slope[:, k] += omega * q * (g[:, 1] + e[:, j] * g[:, 2])
    return psi, slope


def spline(net: Net, e: Floats) -> tuple[Floats, Floats]:
    """The table's value (n,) and slope (n, 3), by the truncated powers of the cubic B-spline."""
    half = (len(net.table) - 3) // 2
    y = np.clip(np.nan_to_num(e) * net.cells, -half, half)
    cell = np.minimum(np.floor(y), half - 1)
    value, slope = np.zeros(len(e)), np.zeros_like(e)
    taps = np.arange(-1, 3)
    away = y[:, :, None] - (cell[:, :, None] + taps)  # (n, 3, 4) from each knot
    b = sum(c * np.maximum(away + o, 0) ** 3 for c, o in ((1, 2), (-4, 1), (6, 0), (-4, -1))) / 6
    d = sum(c * np.maximum(away + o, 0) ** 2 for c, o in ((1, 2), (-4, 1), (6, 0), (-4, -1))) / 2
    index = (cell[:, :, None] + taps + half + 1).astype(int)
    for z in range(4):
        for y_ in range(4):
            for x in range(4):
                c = net.table[index[:, 2, z], index[:, 1, y_], index[:, 0, x]]
                bx, by, bz = b[:, 0, x], b[:, 1, y_], b[:, 2, z]
                value += c * bx * by * bz
                slope[:, 0] += c * d[:, 0, x] * by * bz
                slope[:, 1] += c * bx * d[:, 1, y_] * bz
                slope[:, 2] += c * bx * by * d[:, 2, z]
    return value, slope * net.cells


def law_in_logs(law: Law, poisson: float, e: Floats) -> tuple[Floats, Floats]:
    """psi_law/E and its slope in e, from diagonal deformation gradients."""
    s = np.exp(e)
    mu, lam = 1 / (2 * (1 + poisson)), poisson / ((1 + poisson) * (1 - 2 * poisson))
    psi, P = law(s[:, :, None] * np.eye(3), mu, lam)
    return psi, np.einsum("nii->ni", P) * s


def difference(net: Net, name: str, poisson: float, e: Floats) -> tuple[Floats, Floats]:
    """D and its slope by the net itself, which stands for the law of that name."""
    law = law_of(name)
    safe = np.clip(e, -2, 2)
    w, dw = weight(e, limit_of(name))
    psi, slope = net_energy(net, poisson, safe)
    base, base_slope = law_in_logs(law, poisson, safe)
    gap = psi - base
    return w * gap, dw * gap[:, None] + w[:, None] * (slope - base_slope)


def limit_of(name: str) -> float:
    """The limit of I1 - 3 of a law by its name."""
    family, _, shape = name.partition("=")
    return float(shape) if family == "gent" else np.inf


def neural_law(net: Net, name: str, young: float, poisson: float) -> Law:
    """psi and P in F of a law with a net, with the arguments of a law."""
    law = law_of(name)

    def response(F: Floats, mu: float, lam: float) -> tuple[Floats, Floats]:
        psi, P = law(F, mu, lam)
        U, sigma, Vt = np.linalg.svd(F)
        sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
        U[:, :, 2] *= sign[:, None]
        sigma[:, 2] *= sign
        s = np.clip(sigma, 0.1, 10)  # there D is 0
        e = np.log(s)
        D, slope = spline(net, e) if net.cells else difference(net, name, poisson, e)
        t = young * slope / s
        return psi + young * D, P + (U * t[:, None, :]) @ Vt

    return response


def table_error(net: Net, name: str, poisson: float, count: int = 4000) -> float:
    """Largest error of the table's stress over the local stress, in the fitted box."""
    random = np.random.default_rng(5)
    e = random.uniform(-1, 1, (count, 3)) * 0.9 * 10 ** random.uniform(-2, 0, (count, 1))
    excess = np.exp(2 * (e - e.mean(1, keepdims=True))).sum(1) - 3
    e = e[(np.abs(e.sum(1)) <= np.log(2)) & (excess <= 0.9 * limit_of(name))]
    stress = law_in_logs(law_of(name), poisson, e)[1]
    error = spline(net, e)[1] - difference(net, name, poisson, e)[1]
    return float((np.linalg.norm(error, axis=1) / np.linalg.norm(stress, axis=1)).max())
