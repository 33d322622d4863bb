# SPDX-License-Identifier: Apache-2.0
"""Files that lie or end early: exit code 3, a message with the file and the place, nothing written.

Each case is a whole file with one thing wrong, so that only this can be the reason."""

from __future__ import annotations

import copy
import struct
import tempfile
import unittest
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from command import (animate, glb_bytes, glb_parts, triangles_of, turned_box, write_obj,
                     write_ply, write_stl)

POSITION, FACES = turned_box((0.3, 0.12, 0.1), (1, 2, 3), 25)
NAN = POSITION.copy()
NAN[5, 1] = np.nan
HUGE = POSITION.copy()
HUGE[2, 0] = np.inf
PAST = [[*FACES[0][:3], 99], *FACES[1:]]
FLAT = POSITION * [1, 0, 0]  # on a line

# file name, content, what the message must say besides the file's name
Case = tuple[str, bytes, str]


def written(write: Callable[..., Path], name: str, *arguments: Any) -> bytes:
    """What a writer of command.py writes."""
    with tempfile.TemporaryDirectory() as folder:
        return write(Path(folder) / name, *arguments).read_bytes()


def obj_cases() -> Iterator[Case]:
    whole = written(write_obj, "a.obj", POSITION, FACES)
    lines = whole.splitlines(keepends=True)
    yield "truncated.obj", b"".join(lines[:8]) + b"f 1 2 ", ""
    yield "cut_number.obj", b"".join(lines[:3]) + b"v 0.1 0.2", ":4"
    yield "no_face.obj", b"".join(lines[:8]), ""
    yield "word.obj", whole.replace(b"v ", b"v one ", 1), ":1"
    yield "nan.obj", written(write_obj, "a.obj", NAN, FACES), "vertex 5"
    yield "inf.obj", written(write_obj, "a.obj", HUGE, FACES), "vertex 2"
    yield "past.obj", written(write_obj, "a.obj", POSITION, PAST), ":9"
    yield "zero.obj", whole + b"f 0 1 2\n", ":15"
    yield "before.obj", whole + b"f -9 -2 -1\n", ":15"
    yield "overflow.obj", whole + b"f 1 2 99999999999999999999\n", ":15"
    yield "uv.obj", whole + b"f 1/5 2/5 3/5\n", ":15"
    yield "flat.obj", written(write_obj, "a.obj", FLAT, FACES), "area"
    yield "binary.obj", whole + bytes(50), ":15"


def ply_cases() -> Iterator[Case]:
    for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
        short = encoding.split("_")[-2] if "_" in encoding else encoding
        whole = written(write_ply, "a.ply", POSITION, FACES, encoding)
        body = whole.index(b"end_header\n") + 11
        yield f"{short}_truncated.ply", whole[: body + (len(whole) - body) // 2], ""
        yield f"{short}_header.ply", whole[: body // 2], ""
        yield f"{short}_no_body.ply", whole[:body], ""
        yield f"{short}_nan.ply", written(write_ply, "a.ply", NAN, FACES, encoding), "vertex 5"
        yield f"{short}_past.ply", written(write_ply, "a.ply", POSITION, PAST, encoding), "face 0"
        for count in (b"4000000000", b"9223372036854775807", b"99999999999999999999", b"-1"):
            yield (f"{short}_vertices_{len(count)}.ply",
                   whole.replace(b"element vertex 8", b"element vertex " + count), "vertex")
            yield (f"{short}_faces_{len(count)}.ply",
                   whole.replace(b"element face 6", b"element face " + count), "face")
    whole = written(write_ply, "a.ply", POSITION, FACES, "binary_little_endian")
    yield "list.ply", whole.replace(b"list uchar int", b"list uint int"), ""
    yield "encoding.ply", whole.replace(b"binary_little_endian", b"morse"), "morse"


def stl_cases() -> Iterator[Case]:
    binary, text = (written(write_stl, "a.stl", POSITION, FACES, is_text)
                    for is_text in (False, True))
    yield "binary_truncated.stl", binary[:300], ""
    yield "binary_header.stl", binary[:50], ""
    yield "binary_count.stl", binary[:80] + struct.pack("<I", 4294967295) + binary[84:], ""
    yield "binary_none.stl", binary[:80] + bytes(4), ""
    yield "binary_nan.stl", written(write_stl, "a.stl", NAN, FACES, False), "vertex"
    yield "text_truncated.stl", text[: text.index(b"endloop")], ""
    yield "text_cut.stl", text[: text.index(b"vertex") + 9], ":4"
    yield "text_nan.stl", written(write_stl, "a.stl", NAN, FACES, True), "vertex"
    yield "text_word.stl", text.replace(b"vertex ", b"vertex one ", 1), ":4"
    yield "text_two.stl", text.replace(b"vertex", b"color", 1), ":8"


def glb_cases() -> Iterator[Case]:
    document, data = glb_parts(POSITION, FACES)
    whole = glb_bytes(document, data)
    yield "truncated.glb", whole[: len(whole) - 60], ""
    yield "header.glb", whole[:12], ""
    yield "json_cut.glb", whole[:200], ""
    yield "version.glb", whole[:4] + struct.pack("<I", 1) + whole[8:], ""
    yield "length.glb", whole[:12] + struct.pack("<I", 4294967292) + whole[16:], ""
    yield "no_json.glb", whole.replace(b'{"asset"', b'["asset"'), ""
    yield "nan.glb", glb_bytes(*glb_parts(NAN, FACES)).replace(b"NaN", b"0.0"), "vertex 5"
    yield "past.glb", glb_bytes(*glb_parts(POSITION, PAST)), "99"

    def changed(*place: Any, value: Any) -> bytes:
        """The file with one value of its JSON changed."""
        other: Any = copy.deepcopy(document)
        inner = other
        for key in place[:-1]:
            inner = inner[key]
        inner[place[-1]] = value
        return glb_bytes(other, data)

    for name, place, value in (
            ("count", ("accessors", 0, "count"), 4000000000),
            ("negative_count", ("accessors", 0, "count"), -8),
            ("offset", ("accessors", 0, "byteOffset"), 9007199254740992),
            ("view", ("bufferViews", 0, "byteLength"), 4000000000),
            ("view_offset", ("bufferViews", 1, "byteOffset"), 9007199254740992),
            ("no_view", ("accessors", 0, "bufferView"), 7),
            ("no_buffer", ("bufferViews", 0, "buffer"), 3),
            ("buffer", ("buffers", 0, "byteLength"), 4000000000),
            ("component", ("accessors", 0, "componentType"), 5124),
            ("no_accessor", ("meshes", 0, "primitives", 0, "attributes", "POSITION"), 9),
            ("no_mesh", ("nodes", 0, "mesh"), 4), ("no_node", ("scenes", 0, "nodes"), [5]),
            ("cycle", ("nodes", 0, "children"), [0]),
            ("matrix", ("nodes", 0, "matrix"), [1e39] * 16),
            ("skin", ("nodes", 0, "skin"), 0),
            ("required", ("extensionsRequired",), ["EXT_unheard_of"]),
            ("outside", ("buffers", 0, "uri"), "../../etc/passwd"),
            ("sparse", ("accessors", 0, "sparse"), {
                "count": 4000000000, "indices": {"bufferView": 1, "componentType": 5123},
                "values": {"bufferView": 0}})):
        yield f"{name}.glb", changed(*place, value=value), ""


class BrokenFiles(unittest.TestCase):
    """Each case on its own."""

    def refused(self, name: str, content: bytes, words: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / name
            source.write_bytes(content)
            outputs = [Path(folder) / n for n in ("out.glb", "s.h5", "l.json", "r.json")]
            done = animate(source, outputs[0], "--voxels", 4, "--frames", 1, "--state", outputs[1],
                           "--log-json", outputs[2], "--report", outputs[3], timeout=60)
            self.assertEqual(done.code, 3, done.err)
            self.assertEqual(done.err.count("\n"), 1, done.err)
            message = done.err.replace(str(source), "FILE", 1)
            self.assertTrue(message.startswith("elastogen: FILE"), done.err)
            self.assertIn(words, message)
            self.assertEqual([path.name for path in Path(folder).iterdir()], [name])

    def check(self, cases: Iterator[Case]) -> None:
        for name, content, words in cases:
            with self.subTest(name):
                self.refused(name, content, words)

    def test_obj(self) -> None:
        self.check(obj_cases())

    def test_ply(self) -> None:
        self.check(ply_cases())

    def test_stl(self) -> None:
        self.check(stl_cases())

    def test_glb(self) -> None:
        self.check(glb_cases())

    def test_empty_files_and_formats_that_are_not_read(self) -> None:
        for ending in ("obj", "ply", "stl", "glb", "gltf", ""):
            self.refused(f"empty.{ending}", b"", "empty")
        for name in ("a.usdz", "a.msh", "a"):
            self.refused(name, b"some text\n", ".obj .ply .stl .glb .gltf")

    def test_the_cases_are_well_but_for_one_thing(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            files = [write_obj(place / "a.obj", POSITION, FACES),
                     write_stl(place / "t.stl", POSITION, FACES, True),
                     write_stl(place / "b.stl", POSITION, FACES, False), place / "a.glb"]
            files[-1].write_bytes(glb_bytes(*glb_parts(POSITION, FACES)))
            files += [write_ply(place / f"{e}.ply", POSITION, triangles_of(FACES), e)
                      for e in ("ascii", "binary_little_endian", "binary_big_endian")]
            for file in files:
                done = animate(file, place / "out.glb", "--voxels", 4, "--frames", 1, "--pin",
                               "x<10%")
                self.assertEqual(done.code, 0, done.err)

    def test_missing_files_and_folders(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for source in (Path(folder) / "missing.obj", Path(folder)):
                done = animate(source, Path(folder) / "out.glb")
                self.assertEqual(done.code, 3)
                self.assertIn(str(source), done.err)
            self.assertEqual(list(Path(folder).iterdir()), [])


if __name__ == "__main__":
    unittest.main()
