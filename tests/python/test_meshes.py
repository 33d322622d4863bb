# SPDX-License-Identifier: Apache-2.0
"""What the command makes of the parts, colours and columns of OBJ, PLY, STL and OFF meshes."""

from __future__ import annotations

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

from command import Floats, animate, triangles_of, turned_box

BOX, FACES = turned_box((1, 1, 1), (0, 0, 1), 0)
# three boxes in a row, a gap of one edge between them
PARTS: list[tuple[str, Floats]] = [("A", BOX), ("B", BOX + [2, 0, 0]), ("Hat", BOX + [4, 0, 0])]


def parts_obj(path: Path) -> Path:
    """Object Body with the groups A and B, object Hat."""
    lines = []
    for k, (name, position) in enumerate(PARTS):
        lines += [{"A": "o Body\ng A", "B": "g B", "Hat": "o Hat"}[name]]
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in position.tolist()]
        lines += ["f " + " ".join(str(8 * k + i + 1) for i in face) for face in FACES]
    path.write_text("\n".join(lines) + "\n")
    return path


def parts_stl(path: Path) -> Path:
    """A solid for each box."""
    lines = []
    for name, position in PARTS:
        lines.append(f"solid {name}")
        for facet in position[triangles_of(FACES)].tolist():
            lines += ["facet normal 0 0 0", "outer loop",
                      *(f"vertex {x} {y} {z}" for x, y, z in facet), "endloop", "endfacet"]
        lines.append("endsolid")
    path.write_text("\n".join(lines) + "\n")
    return path


class Meshes(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def materials(self, source: Path, *regions: str) -> list[str]:
        """Names of the materials that voxels have."""
        report = self.folder / "report.json"
        words = [word for region in regions for word in ("--region", region)]
        done = animate(source, self.folder / "out.pc2", "--material", "jelly", "--frames", 1,
                       "--voxels", 16, "--report", report, *words)
        self.assertEqual(done.code, 0, done.err)
        return sorted(m["name"] for m in json.loads(report.read_text())["materials"])

    def test_regions_take_objects_and_their_groups(self) -> None:
        source = parts_obj(self.folder / "parts.obj")
        hat, body = "node:Hat: foam", "node:Body: rubber"
        self.assertEqual(self.materials(source, hat), ["foam", "jelly"])
        self.assertEqual(self.materials(source, hat, body), ["foam", "rubber"])
        self.assertEqual(self.materials(source, hat, "node:A: rubber"),
                         ["foam", "jelly", "rubber"])
        self.assertEqual(self.materials(source, hat, "node:A: rubber", "node:B: rubber"),
                         self.materials(source, hat, body, "node:A: rubber"))

    def test_regions_take_solids_of_a_text_stl(self) -> None:
        source = parts_stl(self.folder / "parts.stl")
        self.assertEqual(self.materials(source, "node:Hat: foam"), ["foam", "jelly"])
        self.assertEqual(self.materials(source, "node:Hat: foam", "node:A: rubber",
                                        "node:B: rubber"), ["foam", "rubber", "rubber"])

    def test_a_point_cache_of_objects_has_the_order_of_the_file(self) -> None:
        source = parts_obj(self.folder / "parts.obj")
        # the hat's faces come first, its vertices last
        text = source.read_text().splitlines()
        vertices = [line for line in text if line.startswith("v ")]
        faces = [line for line in text if not line.startswith("v ")]
        split = faces.index("o Hat")
        source.write_text("\n".join([*vertices, *faces[split:], *faces[:split]]) + "\n")
        output = self.folder / "out.pc2"
        self.assertEqual(animate(source, output, "--gravity", "0,0,0", "--frames", 1,
                                 "--voxels", 16).code, 0)
        cache = np.frombuffer(output.read_bytes()[32:], "<f4").reshape(2, 24, 3)
        np.testing.assert_allclose(cache[0], np.vstack([p for _, p in PARTS]), atol=1e-6)


if __name__ == "__main__":
    unittest.main()
