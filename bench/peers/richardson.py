# SPDX-License-Identifier: Apache-2.0
"""The value on an infinitely fine mesh, from three meshes, and how far it can be trusted.

    f(h) = f + c h^p        f, c, p from the three finest meshes (Richardson)

Where the differences have one sign and shrink as some power p in 0.5 ... 5 would have it, f is the
estimate and |f - f(h_finest)| its uncertainty: the whole extrapolation is in doubt, so the finest
value lies on the rim of the band. Else the estimate is the finest value and the uncertainty the
largest difference between the three.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

Floats = NDArray[np.float64]
ORDERS = (0.5, 5.0)


@dataclass(frozen=True)
class Estimate:
    """Arrays shaped as the probe; order is 0 where no power fits."""

    estimate: Floats
    uncertainty: Floats
    order: Floats


def _order(h: Floats, f: Floats) -> float:
    """p of f(h) = f + c h^p, 0 if there is none in the range."""
    first, second = f[0] - f[1], f[1] - f[2]
    if not first * second > 0:
        return 0.0

    def surplus(p: float) -> float:
        return float((h[0]**p - h[1]**p) / (h[1]**p - h[2]**p) - first / second)

    if surplus(ORDERS[0]) * surplus(ORDERS[1]) > 0:
        return 0.0
    return float(brentq(surplus, *ORDERS, xtol=1e-12))


def _extrapolate(h: Floats, f: Floats) -> tuple[float, float, float]:
    p = _order(h, f)
    if p == 0:
        return float(f[2]), float(np.ptp(f)), 0.0
    correction = (f[2] - f[1]) * h[2]**p / (h[1]**p - h[2]**p)
    return float(f[2] + correction), float(abs(correction)), p


def richardson(sizes: ArrayLike, values: ArrayLike) -> Estimate:
    """Estimate from the three finest meshes.

    @param sizes  h of each mesh, from coarse to fine, at least three
    @param values  the probe on each mesh, (meshes, ...)
    """
    h = np.asarray(sizes, float)[-3:]
    f = np.asarray(values, float)[-3:]
    if len(h) != 3 or len(f) != 3:
        raise ValueError(f"needs three meshes, got {len(h)}")
    flat = f.reshape(3, -1)
    parts = np.array([_extrapolate(h, flat[:, i]) for i in range(flat.shape[1])])
    return Estimate(*(parts[:, k].reshape(f.shape[1:]) for k in range(3)))
