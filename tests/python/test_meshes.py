# SPDX-License-Identifier: Apache-2.0
"""What the command makes of the parts, colours and columns of OBJ, PLY, STL and OFF meshes."""

from __future__ import annotations

import json
import tempfile
import unittest
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from command import Floats, Run, animate, triangles_of, turned_box, write_obj
from glb_file import Document, read_document

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


def red_png() -> bytes:
    """An image of one red pixel."""
    def chunk(kind: bytes, data: bytes) -> bytes:
        return (len(data).to_bytes(4, "big") + kind + data
                + zlib.crc32(kind + data).to_bytes(4, "big"))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", bytes([0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0]))
            + chunk(b"IDAT", zlib.compress(b"\0\xff\0\0")) + chunk(b"IEND", b""))


def corner_uv(face: int, corner: int) -> tuple[float, float]:
    """Of a corner of a quad: a square of its own in a row of six."""
    return (face + (corner in (1, 2))) / 8, (corner > 1) / 2


def corner_ply(path: Path, uv: bool, texture: bool) -> Path:
    """The box with UVs by corner."""
    lines = ["ply", "format ascii 1.0", *(["comment TextureFile red.png"] if texture else []),
             "element vertex 8", *(f"property double {n}" for n in "xyz"), "property short label",
             "element face 6", "property list uchar int vertex_indices",
             *(["property list uchar double texcoord"] if uv else []), "end_header"]
    lines += [f"{x} {y} {z} {7 - v}" for v, (x, y, z) in enumerate(BOX.tolist())]
    for f, face in enumerate(FACES):
        row = [len(face), *face]
        if uv:
            row += [8, *(x for c in range(4) for x in corner_uv(f, c))]
        lines.append(" ".join(map(str, row)))
    path.write_text("\n".join(lines) + "\n")
    return path


def ball(radius: float, rows: int = 12) -> tuple[Floats, list[list[int]]]:
    """Positions and faces of a ball by latitudes and longitudes."""
    position = [[0.0, radius, 0.0]]
    for i in range(1, rows):
        a = np.pi * i / rows
        for j in range(2 * rows):
            b = np.pi * j / rows
            position.append([radius * np.sin(a) * np.cos(b), radius * np.cos(a),
                             -radius * np.sin(a) * np.sin(b)])
    position.append([0.0, -radius, 0.0])
    ring, last = 2 * rows, len(position) - 1
    faces = [[0, 1 + j, 1 + (j + 1) % ring] for j in range(ring)]
    for i in range(rows - 2):
        at = 1 + i * ring
        faces += [[at + j, at + ring + j, at + ring + (j + 1) % ring, at + (j + 1) % ring]
                  for j in range(ring)]
    faces += [[last, last - ring + (j + 1) % ring, last - ring + j] for j in range(ring)]
    return np.array(position), faces


def primitives(document: Document) -> list[tuple[dict[str, Any], bool]]:
    """Primitives, and whether the material of each has a texture."""
    def textured(p: dict[str, Any]) -> bool:
        material = document.items("materials")[p["material"]]
        return "baseColorTexture" in material["pbrMetallicRoughness"]

    return [(p, textured(p)) for m in document.items("meshes") for p in m["primitives"]]


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

    def animated(self, source: Path, *outputs: str) -> Run:
        """A frame without gravity."""
        words = [word for name in outputs[1:] for word in ("-o", self.folder / name)]
        done = animate(source, self.folder / outputs[0], "--gravity", "0,0,0", "--frames", 1,
                       "--voxels", 8, *words)
        self.assertEqual(done.code, 0, done.err)
        return done

    def test_uvs_of_corners_reach_the_glb_and_the_frames(self) -> None:
        (self.folder / "red.png").write_bytes(red_png())
        source = corner_ply(self.folder / "box.ply", uv=True, texture=True)
        done = self.animated(source, "out.glb", "out.ply")
        self.assertNotIn("missing-uvs", done.err)
        self.assertIn("own-columns (1)", done.err)  # the GLB has no place for the label
        document = read_document(self.folder / "out.glb")
        (primitive, textured), = primitives(document)
        self.assertTrue(textured)
        attributes = primitive["attributes"]
        corner = document.raw(primitive["indices"]).ravel()
        found = {(*map(float, x), *map(float, t)) for x, t in zip(
            document.values(attributes["POSITION"])[corner],
            document.values(attributes["TEXCOORD_0"])[corner])}
        # glTF counts v from the top
        wanted = {(*map(float, BOX[v]), u, 1 - t) for f, face in enumerate(FACES)
                  for v, (u, t) in ((v, corner_uv(f, c)) for c, v in enumerate(face))}
        self.assertEqual(found, wanted)
        # the written file can be animated again, with equal output
        again = self.animated(self.folder / "out_00000.ply", "again.glb", "again.ply")
        self.assertNotIn("missing-", again.err)
        self.assertEqual((self.folder / "out_00000.ply").read_bytes(),
                         (self.folder / "again_00000.ply").read_bytes())

    def test_textures_lie_only_where_coordinates_are(self) -> None:
        (self.folder / "red.png").write_bytes(red_png())
        (self.folder / "a.mtl").write_text("newmtl red\nKd 1 0 0\nmap_Kd red.png\n")
        obj = parts_obj(self.folder / "parts.obj")
        text = obj.read_text()
        hat = text[text.index("o Hat"):]
        with_uv = "".join("f " + " ".join(f"{v}/1" for v in line.split()[1:]) + "\n"
                          if line.startswith("f ") else line + "\n" for line in hat.splitlines())
        obj.write_text("mtllib a.mtl\nusemtl red\nvt 0.5 0.5\n" + text.replace(hat, with_uv))
        for source, drawn in ((obj, [False, False, True]),
                              (corner_ply(self.folder / "no.ply", False, True), [False]),
                              (corner_ply(self.folder / "uv.ply", True, True), [True])):
            done = self.animated(source, "out.glb")
            found = primitives(read_document(self.folder / "out.glb"))
            self.assertEqual([textured for _, textured in found], drawn)
            for primitive, textured in found:
                self.assertTrue(not textured or "TEXCOORD_0" in primitive["attributes"])
            self.assertEqual("missing-uvs" in done.err, not all(drawn))

    def test_a_ball_far_away_keeps_its_shape(self) -> None:
        place = np.array([3e7, -2e7, 1e7])
        position, faces = ball(0.5)
        source = write_obj(self.folder / "ball.obj", position + place, faces)
        done = self.animated(source, "out.ply", "out.pc2")
        self.assertIn(f"rounded-positions ({len(position)})", done.err)
        self.assertIn("go by steps of 2 there", done.err)
        body = (self.folder / "out_00000.ply").read_bytes().split(b"end_header\n", 1)[1]
        rest = np.frombuffer(body[:24 * len(position)], "<f8").reshape(-1, 3)
        np.testing.assert_array_equal(rest, position + place)
        near = self.animated(write_obj(self.folder / "near.obj", position, faces), "near.ply",
                             "near.pc2")
        self.assertNotIn("rounded-positions", near.err)


if __name__ == "__main__":
    unittest.main()
