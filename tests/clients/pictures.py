# SPDX-License-Identifier: Apache-2.0
"""Differences of two pictures of one body before a background of one colour."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SIZE = 512  # width and height of pictures
DIRECTION = (-1.0, -0.3, -1.0)  # in which the camera looks
VIEW_DEGREES = 30.0

Pixels = NDArray[Any]


def camera_position(centre: list[float], radius: float) -> list[float]:
    """From where a ball fills most of the picture."""
    direction = np.array(DIRECTION) / np.linalg.norm(DIRECTION)
    distance = 1.1 * radius / np.sin(np.radians(VIEW_DEGREES / 2))
    return (np.array(centre) - distance * direction).tolist()


def inner(mask: Pixels) -> Pixels:
    """Pixels whose eight neighbours are in the mask too."""
    grown = np.pad(mask, 1)
    result = mask.copy()
    for dy in (0, 1, 2):
        for dx in (0, 1, 2):
            result &= grown[dy : dy + mask.shape[0], dx : dx + mask.shape[1]]
    return result


def difference(shown: Pixels, wanted: Pixels) -> dict[str, float]:
    """Of pictures (height, width, 3) in 0..255 whose corner shows the background: the mean of the
    differences of shading inside both outlines, what 99 % of them do not exceed, the largest, and
    the pixels that only one covers as a share of those that the wanted one covers."""
    background = wanted[0, 0].astype(int)
    masks = [np.any(np.abs(p.astype(int) - background) > 2, axis=2) for p in (shown, wanted)]
    both = inner(masks[0] & masks[1])
    gap = np.abs(shown.astype(int) - wanted.astype(int)).max(axis=2)[both]
    covered = max(1, int(masks[1].sum()))
    return {"largest": float(gap.max(initial=0)), "mean": float(gap.mean()) if gap.size else 255.0,
            "most": float(np.percentile(gap, 99)) if gap.size else 255.0,
            "outline": float((masks[0] ^ masks[1]).sum() / covered), "pixels": float(covered)}
