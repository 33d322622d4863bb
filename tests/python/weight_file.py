# SPDX-License-Identifier: Apache-2.0
"""Weight files of nets, read by docs/formats.md."""

from __future__ import annotations

import hashlib
import struct
from pathlib import Path

import numpy as np

from state_file import Floats


def read_weights(path: Path) -> tuple[dict[str, str], Floats]:
    """Model card and weights of a file, by docs/formats.md."""
    data, at = path.read_bytes(), 20
    assert data[:16] == b"elastogen-tensor"
    assert hashlib.sha256(data[:-32]).digest() == data[-32:]

    def word() -> bytes:
        nonlocal at
        length, = struct.unpack_from("<I", data, at)
        at += 4 + length
        return data[at - length:at]

    count, = struct.unpack_from("<I", data, at)
    at += 4
    card = {}
    for _ in range(count):
        key = word().decode()
        card[key] = word().decode()
    weights = np.frombuffer(data[-32 - 4 * 17153:-32], "<f4").astype(float)
    return card, weights
