# SPDX-License-Identifier: Apache-2.0
"""Steps of libuipc, and how far it solves them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np


def tighten(config: Any) -> None:
    """A hundredth of the library's tolerances in a scene's configuration."""
    config["newton"]["velocity_tol"] /= 100
    config["newton"]["transrate_tol"] /= 100
    config["newton"]["semi_implicit"]["enable"] = 0
    config["linear_system"]["tol_rate"] /= 100


def steps(uipc: Any, world: Any, slot: Any, count: int) -> Iterator[tuple[float, np.ndarray]]:
    """Milliseconds of each step, and the positions of the nodes after it [m]."""
    for _ in range(count):
        begin = time.perf_counter()
        world.advance()
        world.sync()
        ms = 1e3 * (time.perf_counter() - begin)
        world.retrieve()
        yield ms, np.asarray(uipc.view(slot.geometry().positions())).reshape(-1, 3)
