# SPDX-License-Identifier: Apache-2.0
"""Positions that a client shows against the point cache of the same run.

The cache holds the asset's own numbers and axes, the client those of the GLB, so the cache is put
under the scale of `--size` and the turn of `--up` first. A client may split, join and reorder
vertices. A vertex is known by its place at rest: it is compared with those points of the cache
that were there. Between frames the vertices of an object keep their order. An object that has
shrunk to a point does not show; another with as many vertices may stand in for it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Indices = NDArray[np.int64]

SAME = 1e-5  # places at rest closer than this share of the edge may be the same
NEIGHBOURS = 3  # places at rest that are tried for one vertex


def read_pc2(path: Path) -> Values:
    """(frames, points, 3) positions of a PC2 file."""
    data = path.read_bytes()
    magic, version, points, _, _, frames = struct.unpack_from("<12siiffi", data)
    if magic != b"POINTCACHE2\0" or version != 1 or len(data) != 32 + 12 * points * frames:
        raise ValueError(f"{path.name} is no point cache")
    return np.frombuffer(data, "<f4", offset=32).reshape(frames, points, 3).astype(float)


def longest_edge(rest: Values) -> float:
    """Of the box of positions (points, 3)."""
    return float(np.ptp(rest, axis=0).max())


def in_gltf_axes(cache: Values, size: float, up: str) -> Values:
    """Positions (frames, points, 3) in metres and with y up. @param size  longest edge at rest;
    0 keeps the numbers. @param up  y or z."""
    scale = size / longest_edge(cache[0]) if size else 1.0
    turned = cache if up == "y" else cache[..., [0, 2, 1]] * [1, 1, -1]
    return turned * scale


class Places:
    """Distinct positions of the cache at rest, and the points at each."""

    def __init__(self, rest: Values) -> None:
        self.edge = longest_edge(rest)
        self.places, place_of = np.unique(rest, axis=0, return_inverse=True)
        place_of = place_of.reshape(-1)
        order = np.argsort(place_of, kind="stable")
        counts = np.bincount(place_of)
        starts = np.cumsum(counts) - counts
        column = np.minimum(np.arange(counts.max())[None], counts[:, None] - 1)
        self.points: Indices = order[starts[:, None] + column]  # (places, most at one place)

    def candidates(self, positions: Values) -> tuple[Indices, Values, int]:
        """Points of the cache for each of (vertices, 3) positions at rest, (vertices, some), the
        distance to the nearest place, and how many places are no vertex's nearest."""
        unique, back = np.unique(positions, axis=0, return_inverse=True)
        near, distance = self._within(unique)
        alone = distance[:, 0] == np.inf
        if alone.any():
            near[alone], distance[alone] = self._nearest(unique[alone])
        allowed = np.maximum(2 * distance[:, :1], SAME * self.edge)
        near = np.where(distance <= allowed, near, near[:, :1])
        missed = self.far_from(np.unique(near))
        points = self.points[near].reshape(len(unique), -1)
        return points[back.reshape(-1)], distance[back.reshape(-1), 0], missed

    def _within(self, positions: Values) -> tuple[Indices, Values]:
        """The nearest places within SAME of the edge, (vertices, NEIGHBOURS), and their distances,
        infinite where there are no more. Places are looked up along a direction of no symmetry."""
        direction, reach = np.array([0.36, 0.48, 0.8]) + [0.01, -0.02, 0.013], SAME * self.edge
        along = self.places @ direction
        order = np.argsort(along, kind="stable")
        first = np.searchsorted(along[order], positions @ direction - 1.1 * reach)
        last = np.searchsorted(along[order], positions @ direction + 1.1 * reach)
        near = np.zeros((len(positions), NEIGHBOURS), int)
        distance = np.full((len(positions), NEIGHBOURS), np.inf)
        for step in range(int((last - first).max(initial=0))):
            row = np.flatnonzero(first + step < last)
            place = order[first[row] + step]
            gap = np.linalg.norm(positions[row] - self.places[place], axis=1)
            row, place, gap = row[gap <= reach], place[gap <= reach], gap[gap <= reach]
            all_gaps = np.column_stack([distance[row], gap])
            rank = np.argsort(all_gaps, axis=1, kind="stable")[:, :NEIGHBOURS]
            near[row] = np.take_along_axis(np.column_stack([near[row], place]), rank, 1)
            distance[row] = np.take_along_axis(all_gaps, rank, 1)
        return near, distance

    def _nearest(self, positions: Values) -> tuple[Indices, Values]:
        """The nearest places of all, and their distances, both (vertices, NEIGHBOURS)."""
        near = np.empty((len(positions), NEIGHBOURS), int)
        step = max(1, 4_000_000 // len(self.places))
        centre, some = self.places.mean(0), min(NEIGHBOURS, len(self.places))
        square = ((self.places - centre) ** 2).sum(1)
        for at in range(0, len(positions), step):
            gap = square - 2 * (positions[at : at + step] - centre) @ (self.places - centre).T
            rank = np.argpartition(gap, some - 1, axis=1)[:, :some]
            order = np.argsort(np.take_along_axis(gap, rank, 1), axis=1)
            rank = np.take_along_axis(rank, order, 1)
            near[at : at + step] = rank[:, np.minimum(np.arange(NEIGHBOURS), some - 1)]
        return near, np.linalg.norm(positions[:, None] - self.places[near], axis=2)

    def far_from(self, found: Indices) -> int:
        """How many places are none of those found, nor as good as one of them."""
        left = np.setdiff1d(np.arange(len(self.places)), found)
        gaps = [np.linalg.norm(self.places[found] - place, axis=1).min()
                for place in self.places[left]]
        return int((np.array(gaps) > SAME * self.edge).sum())


@dataclass
class Result:
    """Largest distance by frame as a share of the longest edge, and what else is wrong."""

    errors: dict[int, float] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def largest(self) -> float:
        """Of all frames."""
        return max(self.errors.values(), default=float("inf"))


def visible(objects: list[Values], edge: float) -> list[Values]:
    """Those that have not shrunk to a point."""
    return [x for x in objects if len(x) and np.ptp(x, axis=0).max() > 1e-4 * edge]


def largest_error(shown: Values, points: Indices, wanted: Values) -> float:
    """Of one object: each vertex against the nearest of its points of the cache."""
    gap = np.linalg.norm(shown[:, None] - wanted[points], axis=2).min(axis=1)
    return float(gap.max()) if np.isfinite(shown).all() else float("inf")


def frame_error(objects: list[Values], rest: list[Indices], wanted: Values) -> float:
    """Of a frame: each object is taken for that object at rest which it fits best."""
    free, worst = list(range(len(rest))), 0.0
    for shown in objects:
        fits = [(largest_error(shown, rest[k], wanted), k) for k in free
                if len(rest[k]) == len(shown)]
        if not fits:
            return float("inf")
        error, taken = min(fits)
        free.remove(taken)
        worst = max(worst, error)
    return worst


def compare(shown: dict[int, list[Values]], cache: Values) -> Result:
    """@param shown  positions (vertices, 3) of each object by frame, frame 0 among them
    @param cache  (frames, points, 3) in the same axes."""
    places, result = Places(cache[0]), Result()
    edge = places.edge
    at_rest = visible(shown.get(0, []), edge)
    if not at_rest:
        result.faults.append("shows nothing at rest")
        return result
    points, distance, missed = places.candidates(np.concatenate(at_rest))
    ends = np.cumsum([len(x) for x in at_rest])[:-1]
    parts = np.split(points, ends)
    result.errors[0] = float(distance.max()) / edge
    if missed:
        result.faults.append(f"lacks {missed} of {len(places.places)} places")
    for frame in sorted(set(shown) - {0}):
        objects = visible(shown[frame], edge)
        result.errors[frame] = frame_error(objects, parts, cache[frame]) / edge
        count = sum(len(x) for x in objects)
        if count != len(points):
            result.faults.append(f"frame {frame} has {count} vertices, the rest {len(points)}")
    return result
