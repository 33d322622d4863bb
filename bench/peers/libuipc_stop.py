# SPDX-License-Identifier: Apache-2.0
"""How far libuipc solves a step."""

from __future__ import annotations

from typing import Any


def tighten(config: Any) -> None:
    """A hundredth of the library's tolerances in a scene's configuration."""
    config["newton"]["velocity_tol"] /= 100
    config["newton"]["transrate_tol"] /= 100
    config["newton"]["semi_implicit"]["enable"] = 0
    config["linear_system"]["tol_rate"] /= 100
