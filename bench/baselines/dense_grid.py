# SPDX-License-Identifier: Apache-2.0
"""Fields on dense grids of voxels and nodes, (component, z, y, x), as tensors or NumPy arrays, and the
2x2x2 convolutions between them."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = Any  # of NumPy or a tensor


class Backend:
    """NumPy or PyTorch on a device: what of the two is not spelled alike."""

    def __init__(self, mode: str, device: str, dtype: str) -> None:
        self.torch = None
        self.xp: Any = np
        self.dtype: Any = np.dtype(dtype)
        self.device = "cpu"
        if mode == "numpy":
            return
        import torch
        self.torch = self.xp = torch
        self.dtype = getattr(torch, dtype)
        if device == "auto":
            device = "cuda" if torch.cuda.is_available() else "cpu"
        self.device = device

    def array(self, values: np.ndarray) -> Array:
        """On the device, in the type of the run."""
        if self.torch is None:
            return values.astype(self.dtype)
        return self.torch.as_tensor(np.ascontiguousarray(values)).to(self.device, self.dtype)

    def numpy(self, values: Array) -> np.ndarray:
        """On the host in float64."""
        return np.asarray(values if self.torch is None else values.double().cpu(), np.float64)

    def double(self, values: Array) -> Array:
        """In float64."""
        return values.astype(np.float64) if self.torch is None else values.double()

    def like(self, values: Array, other: Array) -> Array:
        """In the type of `other`."""
        return values.astype(other.dtype) if self.torch is None else values.to(other.dtype)

    def pad(self, values: Array, axis: int, before: int, after: int) -> Array:
        """Zeros around an axis, -1 ... -3."""
        if self.torch is None:
            width = [(0, 0)] * values.ndim
            width[axis] = (before, after)
            return np.pad(values, width)
        return self.torch.nn.functional.pad(values, [0, 0] * (-1 - axis) + [before, after])

    def wait(self) -> None:
        """Until the device has done its work."""
        if self.device == "cuda":
            self.torch.cuda.synchronize()


def pair(field: Array, axis: int) -> tuple[Array, Array]:
    """Sum and difference of neighbours along an axis."""
    low = [slice(None)] * field.ndim
    high = list(low)
    low[axis], high[axis] = slice(None, -1), slice(1, None)
    return field[tuple(high)] + field[tuple(low)], field[tuple(high)] - field[tuple(low)]


def patterns(field: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Node values to the sums over the corners of each voxel: the centre gradient times 4 h,
    (x, y, z), and what it does not see, (xy, yz, zx, xyz): convolutions with 2x2x2 signs."""
    s, d = pair(field, -1)
    (ss, sd), (ds, dd) = pair(s, -2), pair(d, -2)
    (y, yz), (x, zx), (xy, xyz) = pair(sd, -3), pair(ds, -3), pair(dd, -3)
    return (x, y, pair(ss, -3)[1]), (xy, yz, zx, xyz)


def unpair(backend: Backend, s: Array | None, d: Array | None, axis: int) -> Array:
    """The transpose of pair."""
    high = d if s is None else s if d is None else s + d
    low = -d if s is None else s if d is None else s - d
    return backend.pad(high, axis, 1, 0) + backend.pad(low, axis, 0, 1)


def transposed(backend: Backend, gradient: tuple[Array, ...], rest: tuple[Array, ...]) -> Array:
    """The transpose of patterns: forces on the nodes."""
    (x, y, z), (xy, yz, zx, xyz) = gradient, rest
    s = unpair(backend, unpair(backend, None, z, -3), unpair(backend, y, yz, -3), -2)
    d = unpair(backend, unpair(backend, x, zx, -3), unpair(backend, xy, xyz, -3), -2)
    return unpair(backend, s, d, -1)


def node_sum(backend: Backend, field: Array) -> Array:
    """Sum over the voxels of each node."""
    for axis in (-3, -2, -1):
        field = unpair(backend, field, None, axis)
    return field
