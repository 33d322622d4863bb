# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs: their files, sizes, colours, and that what moves is seen to move."""

from __future__ import annotations

import json
import struct
import tempfile
import unittest
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from command import Run, animate, run, turned_box, write_obj

BOX = turned_box((0.3, 0.12, 0.1), (0, 0, 1), 0)
SHORT = ("--analytic", "--voxels", 8, "--substeps", 1, "--young", "50kPa")
Bytes = NDArray[np.uint8]


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_png(path: Path, pixels: Bytes) -> Path:
    """Height, width, 3."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    return path


def read_png(path: Path) -> Bytes:
    """Pixels of a picture of the command, (height, width, 3)."""
    data, at, packed, width, height = path.read_bytes(), 8, b"", 0, 0
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        packed += body if kind == b"IDAT" else b""
        at += size + 12
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 3 * width + 1)
    return rows[:, 1:].reshape(height, width, 3)


def sphere(count: int) -> NDArray[np.float64]:
    """Points spread over a unit sphere."""
    k = np.arange(count)
    z = 1 - (2 * k + 1) / count
    radius, turn = np.sqrt(1 - z * z), np.pi * (3 - np.sqrt(5)) * k
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def write_points(path: Path) -> Path:
    """A sphere of points of one colour, with normals."""
    points = sphere(1500)
    head = ("ply\nformat ascii 1.0\nelement vertex 1500\n"
            + "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
            + "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
            + "end_header\n")
    lines = [" ".join(f"{v:.6f}" for v in (*p, *p)) + " 200 40 30" for p in points]
    path.write_text(head + "\n".join(lines) + "\n")
    return path


def write_splats(path: Path) -> Path:
    """A sphere of green splats."""
    names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
             "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    points = sphere(1500)
    row = np.zeros((1500, len(names)), np.float32)
    row[:, :3] = points
    row[:, 3:6] = (np.array([0.1, 0.7, 0.2]) - 0.5) / 0.28209479177387814
    row[:, 6], row[:, 7:10], row[:, 10] = 4, np.log(0.05), 1
    head = ("ply\nformat binary_little_endian 1.0\nelement vertex 1500\n"
            + "".join(f"property float {name}\n" for name in names) + "end_header\n")
    path.write_bytes(head.encode() + row.tobytes())
    return path


class Pictures(unittest.TestCase):
    """A folder of its own, with a box in it."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.box = write_obj(self.folder / "box.obj", *BOX)

    def done(self, done: Run, code: int = 0) -> None:
        self.assertEqual(done.code, code, done.err)

    def tiles(self, source: Path, *options: object) -> list[Bytes]:
        """The twelve pictures of a sheet of 64 x 48 each, without the lines between them."""
        out = self.folder / "sheet.png"
        self.done(animate(source, out, *SHORT, "--frames", 13, "--image-size", "64x48", *options))
        sheet = read_png(out)
        self.assertEqual(sheet.shape, (3 * 48, 4 * 64, 3))
        self.assertTrue((sheet[47::48] == 255).all() and (sheet[:, 63::64] == 255).all())
        return [sheet[48 * (k // 4):][:47, 64 * (k % 4):][:, :63] for k in range(12)]

    def check_falls(self, source: Path, colour: int, *options: object) -> None:
        """A body of mostly one colour sinks from the first to the last picture."""
        tiles = self.tiles(source, *options)
        height = []
        for tile in tiles:
            body = tile.astype(int)
            others = [c for c in range(3) if c != colour]
            seen = (body[:, :, colour] > 1.3 * body[:, :, others].max(axis=2))
            self.assertGreater(seen.sum(), 50)
            height.append(np.nonzero(seen)[0].mean())
        self.assertGreater(max(height), height[0] + 2)
        self.assertTrue((np.diff(height[:6]) > -0.5).all(), height)

    def test_a_sheet_shows_a_mesh_that_bends(self) -> None:
        (self.folder / "box.mtl").write_text("newmtl red\nKd 0.9 0.1 0.1\n")
        text = self.box.read_text()
        self.box.write_text("mtllib box.mtl\nusemtl red\n" + text)
        self.check_falls(self.box, 0, "--pin", "x<10%")

    def test_points_and_splats_fall(self) -> None:
        self.check_falls(write_points(self.folder / "p.ply"), 0, "--no-strict")
        self.check_falls(write_splats(self.folder / "s.ply"), 1)

    def test_a_numbered_name_is_a_picture_a_frame_beside_other_outputs(self) -> None:
        out = self.folder / "clip_%03d.png"
        self.done(run("animate", self.box, *SHORT, "--frames=3", "--pin", "x<10%", "--quiet", "-o",
                      out, "-o", self.folder / "a.glb", "-o", self.folder / "a.png"))
        names = sorted(p.name for p in self.folder.iterdir())
        self.assertEqual(names, ["a.glb", "a.png", "box.obj"]
                         + [f"clip_{k:03}.png" for k in range(4)])
        frames = [read_png(self.folder / f"clip_{k:03}.png") for k in range(4)]
        self.assertEqual({frame.shape for frame in frames}, {(540, 960, 3)})
        self.assertEqual(read_png(self.folder / "a.png").shape, (320, 4 * 320, 3))
        self.assertFalse((frames[0] == frames[3]).all())

    def test_pictures_do_not_depend_on_the_threads(self) -> None:
        sheets = []
        for threads in (1, 3):
            out = self.folder / f"{threads}.png"
            self.done(animate(self.box, out, *SHORT, "--frames", 13, "--floor", "--threads",
                              threads))
            sheets.append(out.read_bytes())
        self.assertEqual(*sheets)

    def test_a_run_out_of_time_shows_the_frames_that_there_are(self) -> None:
        out = self.folder / "clip_%d.png"
        self.done(animate(self.box, out, *SHORT, "--frames", 100000, "--max-time", "0.3s",
                          "--pin", "x<10%", "--image-size", "32x32"), 4)
        count = len(list(self.folder.glob("clip_*.png")))
        self.assertTrue(1 <= count < 100000)
        self.assertTrue((self.folder / f"clip_{count - 1}.png").exists())

    def test_finite_elements_are_drawn_too(self) -> None:
        out = self.folder / "fem.png"
        self.done(run("simulate", self.box, "-o", out, "--voxels", 4, "--frames", 1, "--pin",
                      "x<10%", "--quiet", "--camera", "front"))
        self.assertEqual(read_png(out).shape, (320, 640, 3))

    def test_textures_stand_upright_and_broken_ones_are_notes(self) -> None:
        pixels = np.zeros((16, 16, 3), np.uint8)
        pixels[:8, :, 0] = pixels[8:, :, 2] = 255  # red above blue
        skin, mtl = self.folder / "skin.png", self.folder / "skin.mtl"
        write_png(skin, pixels)
        mtl.write_text("newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n")
        source = self.folder / "skin.obj"
        position, faces = BOX
        # v of OBJ goes up: each side has the image by its height
        lines = ["mtllib skin.mtl", "usemtl skin"] + [f"v {x} {y} {z}" for x, y, z in position]
        lines += [f"vt 0.5 {(y + 0.06) / 0.12}" for _, y, _ in position]
        lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in faces]
        source.write_text("\n".join(lines) + "\n")
        out, report = self.folder / "skin_%d.png", self.folder / "report.json"
        options = (*SHORT, "--frames", 0, "--pin", "all", "--camera", "front", "--report", report)
        self.done(animate(source, out, *options))
        picture = read_png(self.folder / "skin_0.png").astype(int)
        rows, columns = np.nonzero(picture.min(axis=2) < 200)
        middle = int(columns.mean())
        above = picture[int(np.quantile(rows, 0.3)), middle]
        below = picture[int(np.quantile(rows, 0.8)), middle]
        self.assertGreater(above[0], 3 * above[2])
        self.assertGreater(below[2], 3 * below[0])
        skin.write_bytes(skin.read_bytes()[:50])
        self.done(animate(source, out, *options))
        notes = json.loads(report.read_text())["notes"]
        self.assertTrue(any("skin.png" in note and "base colour" in note for note in notes), notes)

    def test_refusals_name_what_is_wrong(self) -> None:
        for name, words, says in (
                ("a_%d_%d.png", (), "a % in the name of pictures"),
                ("a_%s.png", (), "a % in the name of pictures"),
                ("a.png", ("--camera", "topp"), "did you mean top?"),
                ("a.png", ("--image-size", "0x0"), "WIDTHxHEIGHT"),
                ("a.jpg", (), ".png"),
                ("none/a.png", (), "none")):
            done = animate(self.box, self.folder / name, *SHORT, *words)
            self.assertIn(done.code, (2, 6))
            self.assertIn(says, done.err)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["box.obj"])


if __name__ == "__main__":
    unittest.main()
