# SPDX-License-Identifier: Apache-2.0
"""A body far from the origin moves as the same body at the origin."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from command import Floats, run, write_obj

PLACES = ((3e7, -2e7, 1e7), (4e8, 1.0, -4e8), (-2000.0, 0.0, 500.0))
GRID = 2.0 ** -20  # positions are multiples of it, which doubles hold at all places


def ball(n: int) -> tuple[Floats, list[list[int]]]:
    """A cube's surface of n x n squares a side, blown up to a ball of radius 0.5."""
    line = np.linspace(-1, 1, n + 1)
    number: dict[tuple[float, ...], int] = {}
    faces: list[list[int]] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for i in range(n):
                for j in range(n):
                    corners = [(line[i], line[j]), (line[i + 1], line[j]),
                               (line[i + 1], line[j + 1]), (line[i], line[j + 1])]
                    face = [number.setdefault(tuple(np.roll([side, u, v], axis)), len(number))
                            for u, v in corners]
                    faces.append(face if side > 0 else face[::-1])
    position = np.array(list(number))
    position /= 2 * np.linalg.norm(position, axis=1, keepdims=True)
    return np.round(position / GRID) * GRID, faces


def exact_obj(path: Path, position: Floats, faces: list[list[int]]) -> Path:
    """An OBJ with all digits of its numbers."""
    with path.open("w") as file:
        file.writelines("v {!r} {!r} {!r}\n".format(*map(float, p)) for p in position)
        file.writelines("f " + " ".join(str(v + 1) for v in face) + "\n" for face in faces)
    return path


def point_array(path: Path) -> Floats:
    """The points of a VTU whose first appended array they are."""
    data = path.read_bytes()
    start = data.index(b"<AppendedData encoding=\"raw\">\n_") + 31
    kind = np.float64 if b'type="Float64" Name="Points"' in data else np.float32
    size = int(np.frombuffer(data[start:start + 8], np.uint64)[0])
    return np.frombuffer(data[start + 8:start + 8 + size], kind).reshape(-1, 3).astype(float)


class FarAway(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.position, self.faces = ball(10)

    def clip(self, place: tuple[float, float, float], *options: str) -> dict[str, Any]:
        """Frames of a run at a place, about that place."""
        name = f"{place[0]:.0f}"
        source = exact_obj(self.folder / f"{name}.obj", self.position + place, self.faces)
        state, vtu = self.folder / f"{name}.h5", self.folder / f"{name}.pvd"
        done = run("animate", source, "--material", "jelly", "--voxels", 12, "--frames", 8,
                   "--state", state, "-o", vtu, *options)
        self.assertEqual(done.code, 0, done.err)
        with h5py.File(state) as file:
            offset = np.array(file.attrs["place"])
            moved = np.array(file["steps/x"]) + (offset - place)
            residual = np.array(file["steps/residual"])
            converged = np.array(file["steps/converged"])
        points = point_array(sorted(self.folder.glob(f"{name}*.vtu"))[-1]) - place
        return {"x": moved, "converged": converged, "residual": residual, "points": points}

    def compare(self, place: tuple[float, float, float], near: dict[str, Any],
                *options: str) -> None:
        far = self.clip(place, *options)
        self.assertTrue(far["converged"].all())
        np.testing.assert_array_equal(far["x"], near["x"])
        np.testing.assert_array_equal(far["residual"], near["residual"])
        step = np.spacing(np.abs(place).max())
        np.testing.assert_allclose(far["points"], near["points"], atol=step + 1e-6, rtol=0)

    def test_a_pinned_ball(self) -> None:
        near = self.clip((0.0, 0.0, 0.0), "--pin", "y>90%")
        self.assertGreater(np.abs(near["x"][-1] - near["x"][0]).max(), 1e-3)
        for place in PLACES:
            self.compare(place, near, "--pin", "y>90%")

    def test_lengths_are_those_of_the_file(self) -> None:
        def options(place: tuple[float, float, float]) -> list[str]:
            x, y, z = place
            return ["--floor", f"y={y - 0.5!r}", "--pin", f"box({x - 1!r},{y + 0.40625!r},{z - 1!r},"
                    f"{x + 1!r},{y + 1!r},{z + 1!r})",
                    "--collider", f"sphere({x!r},{y + 1!r},{z!r},0.5)"]

        near = self.clip((0.0, 0.0, 0.0), *options((0.0, 0.0, 0.0)))
        for place in PLACES:
            self.compare(place, near, *options(place))

    def test_what_is_said_has_the_numbers_of_the_file(self) -> None:
        source = exact_obj(self.folder / "far.obj", self.position + PLACES[0], self.faces)
        box = json.loads(run("inspect", source, "--json").out)["box"]
        np.testing.assert_array_equal(box["lower"], self.position.min(axis=0) + PLACES[0])
        done = run("animate", source, "--pin", "x<0", "--voxels", 8, "--frames", 1, "-o",
                   self.folder / "far.glb")
        self.assertIn("holds nothing", done.err)
        self.assertIn("3e+07..3e+07", done.err)


if __name__ == "__main__":
    unittest.main()
