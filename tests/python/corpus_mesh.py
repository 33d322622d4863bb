# SPDX-License-Identifier: Apache-2.0
"""Broken OBJ, PLY, STL and OFF files. Each is a whole file with one thing wrong."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np

from command import triangles_of, turned_box, write_obj, write_ply, write_stl
from corpus import Case, cuts, read_anyhow, written

POSITION, FACES = turned_box((0.3, 0.12, 0.1), (1, 2, 3), 25)
NAN = POSITION.copy()
NAN[5, 1] = np.nan
HUGE = POSITION.copy()
HUGE[2, 0] = np.inf
BELOW = POSITION.copy()
BELOW[0, 2] = -np.inf
PAST = [[*FACES[0][:3], 8], *FACES[1:]]  # one beyond the last
NEGATIVE = [[*FACES[0][:3], -1], *FACES[1:]]
FLAT = POSITION * [1, 0, 0]  # on a line
COUNTS = (b"2147483648", b"4000000000", b"9223372036854775808", b"18446744073709551616", b"-1")


def obj_cases() -> Iterator[Case]:
    whole = written(write_obj, "a.obj", POSITION, FACES)
    lines = whole.splitlines(keepends=True)
    yield Case("truncated.obj", b"".join(lines[:8]) + b"f 1 2 ")
    yield Case("cut_number.obj", b"".join(lines[:3]) + b"v 0.1 0.2", ":4")
    yield Case("no_face.obj", b"".join(lines[:8]))
    yield Case("word.obj", whole.replace(b"v ", b"v one ", 1), ":1")
    yield Case("nan.obj", written(write_obj, "a.obj", NAN, FACES), "vertex 5")
    yield Case("inf.obj", written(write_obj, "a.obj", HUGE, FACES), "vertex 2")
    yield Case("below.obj", written(write_obj, "a.obj", BELOW, FACES), "vertex 0")
    yield Case("past.obj", written(write_obj, "a.obj", POSITION, PAST), ":9")
    yield Case("zero.obj", whole + b"f 0 1 2\n", ":15")
    yield Case("before.obj", whole + b"f -9 -2 -1\n", ":15")
    yield Case("wrapped.obj", whole + b"f 1 2 4294967295\n", ":15")
    yield Case("overflow.obj", whole + b"f 1 2 99999999999999999999\n", ":15")
    yield Case("uv.obj", whole + b"f 1/5 2/5 3/5\n", ":15")
    yield Case("flat.obj", written(write_obj, "a.obj", FLAT, FACES), "area")
    yield Case("binary.obj", whole + bytes(50), ":15")
    yield Case("stl.obj", written(write_stl, "a.stl", POSITION, FACES, False))
    yield from read_anyhow("whole", "obj", whole)
    yield Case("utf16.obj", b"\xff\xfe" + whole.decode().encode("utf-16-le"), "UTF-16")
    for name in (b"o x\n", b"g x\n", b"o \ng \n", b"g a b c\n"):
        yield Case(f"{name.hex()}.obj", whole.replace(b"f ", name + b"f "), "usable", (0,))

    # without counts a text may end after any line
    yield from cuts("whole", "obj", whole, codes=(0, 3))
    vertices = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    for name, head, fill in (("numbers", b"", b"0.25 "), ("vertex", b"v ", b"0.25 "),
                             ("face", vertices + b"f ", b"1 2 3 4 "), ("blank", b"", b" "),
                             ("word", b"", b"x"), ("library", b"mtllib ", b"x")):
        yield Case(f"line_{name}.obj", head, "", (3,), fill)

    # these are read, and said
    face, area = b"f 1 3 4 2\n", b"f 1 1 2\n"
    for finding, text in (("duplicate-faces", face), ("zero-area", area),
                          ("non-manifold", b"v 9 9 9\nf 1 2 9\n"), ("unreferenced", b"v 0 0 0\n"),
                          ("duplicate-vertices", lines[0] + b"f 9 3 4\n")):
        yield Case(f"{finding}.obj", whole + text, finding, (0,))


def ply_cases() -> Iterator[Case]:
    bodies = {}
    for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
        short = encoding.split("_")[-2] if "_" in encoding else encoding
        whole = written(write_ply, "a.ply", POSITION, FACES, encoding)
        body = whole.index(b"end_header\n") + 11
        bodies[encoding] = whole[body:]
        yield Case(f"{short}_no_body.ply", whole[:body])
        for name, position, words in (("nan", NAN, "vertex 5"), ("inf", HUGE, "vertex 2"),
                                      ("below", BELOW, "vertex 0")):
            yield Case(f"{short}_{name}.ply",
                       written(write_ply, "a.ply", position, FACES, encoding), words)
        for name, faces in (("past", PAST), ("negative", NEGATIVE)):
            yield Case(f"{short}_{name}.ply",
                       written(write_ply, "a.ply", POSITION, faces, encoding), "face 0")
        for count in COUNTS:
            for element, own in ((b"vertex", b"8"), (b"face", b"6")):
                yield Case(f"{short}_{element.decode()}_{count.decode()}.ply",
                           whole.replace(b"element %s %s" % (element, own),
                                         b"element %s %s" % (element, count)), element.decode())
        yield from cuts(short, "ply", whole, may_lack=2 if encoding == "ascii" else 0)
    text = written(write_ply, "a.ply", POSITION, FACES, "ascii")
    yield from read_anyhow("text", "ply", text)
    for encoding, other in (("ascii", "binary_little_endian"), ("binary_little_endian", "ascii"),
                            ("binary_little_endian", "binary_big_endian"),
                            ("binary_big_endian", "binary_little_endian")):
        head = text[:text.index(b"end_header\n") + 11].replace(b"ascii", encoding.encode())
        yield Case(f"{encoding}_is_{other}.ply", head + bodies[other])
    whole = written(write_ply, "a.ply", POSITION, FACES, "binary_little_endian")
    yield Case("list.ply", whole.replace(b"list uchar int", b"list uint int"))
    yield Case("wrapped.ply", whole.replace(b"uchar int", b"uchar uint").replace(
        struct.pack("<4I", 0, 2, 3, 1), struct.pack("<4I", 0, 2, 3, 2**32 - 1)), "face 0")
    yield Case("encoding.ply", whole.replace(b"binary_little_endian", b"morse"), "morse")
    yield from corner_cases(text)
    yield Case("nothing.ply", whole.replace(b"element vertex",
                                            b"element nothing 2147483646\nelement vertex"), "",
               (0, 3))
    yield Case("line_header.ply", b"ply\n", "", (3,), b"x ")
    yield Case("line_comment.ply", b"ply\ncomment ", "", (3,), b"x ")
    yield Case("line_body.ply", text[:text.index(b"end_header\n") + 11], "", (3,), b"0.25 ")


def corner_cases(text: bytes) -> Iterator[Case]:
    """The text with UVs of corners, and lines of the wrong length."""
    lines = text.splitlines()
    end = lines.index(b"end_header")
    head, vertices, faces = lines[:end], lines[end + 1:end + 9], lines[end + 9:]
    corners = [*head, b"property list uchar float texcoord", b"end_header", *vertices]

    def uvs(*counts: int) -> bytes:
        rows = [b" ".join([face, b"%d" % n, *[b"0.5"] * n])
                for face, n in zip(faces, counts, strict=True)]
        return b"\n".join([*corners, *rows]) + b"\n"

    yield Case("corners.ply", uvs(*[8] * 6), "usable", (0,))
    yield Case("some_corners.ply", uvs(8, 0, 8, 0, 8, 0), "usable", (0,))
    for count in (1, 6, 7, 9, 16):
        yield Case(f"corners_{count}.ply", uvs(8, 8, count, 8, 8, 8), "face 2")
    for name, part in (("more", lines[end + 3] + b" 1"), ("fewer", lines[end + 3][:4]),
                       ("two", lines[end + 3] + b" " + lines[end + 4])):
        wrong = [*lines[:end + 3], part, *lines[end + 4:]]
        yield Case(f"line_of_{name}.ply", b"\n".join(wrong), f":{end + 4}")
    yield Case("less_vertices.ply", text.replace(b"vertex 8", b"vertex 7"), f":{end + 9}")
    yield Case("more_vertices.ply", text.replace(b"vertex 8", b"vertex 9"), f":{end + 10}")
    yield Case("less_faces.ply", text.replace(b"face 6", b"face 5"), "extra-bytes", (0,))
    yield Case("more_faces.ply", text.replace(b"face 6", b"face 7"), "face 6 of 7")
    yield Case("spoken.ply", text.replace(b"element", b"made by hand\nelement", 1), "header-lines",
               (0,))


def stl_cases() -> Iterator[Case]:
    binary, text = (written(write_stl, "a.stl", POSITION, FACES, is_text)
                    for is_text in (False, True))
    yield Case("binary_header.stl", binary[:50])
    yield Case("binary_none.stl", binary[:80] + bytes(4))
    for count in (13, 2**31, 2**32 - 1, 12 << 24):
        yield Case(f"binary_{count}.stl", binary[:80] + struct.pack("<I", count) + binary[84:])
    for name, position, words in (("nan", NAN, "vertex"), ("inf", HUGE, "vertex"),
                                  ("below", BELOW, "vertex 0"), ("flat", FLAT, "area")):
        for is_text in (False, True):
            yield Case(f"{name}_{'text' if is_text else 'binary'}.stl",
                       written(write_stl, "a.stl", position, FACES, is_text), words)
    yield Case("text_cut.stl", text[: text.index(b"vertex") + 9], ":4")
    yield Case("text_word.stl", text.replace(b"vertex ", b"vertex one ", 1), ":4")
    yield Case("text_two.stl", text.replace(b"vertex", b"color", 1), ":8")
    yield Case("text_header.stl", b"solid test\n")
    yield Case("solid_binary.stl", b"solid" + binary[5:], "usable", (0,))  # some programs do this
    yield Case("text_as_binary.stl", b"liquid" + text[6:])
    yield Case("line_solid.stl", b"solid ", "", (3,), b"0.25 ")
    yield Case("line_facet.stl", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex ", "", (3,),
               b"0.25 ")
    yield from read_anyhow("text", "stl", text)
    yield from cuts("binary", "stl", binary)
    yield from cuts("text", "stl", text, codes=(0, 3))


def off_bytes(head: str = "OFF", position: np.ndarray = POSITION,  # type: ignore[type-arg]
              faces: list[list[int]] = FACES) -> bytes:
    """A text OFF."""
    lines = [head, f"{len(position)} {len(faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in position.tolist()]
    lines += [" ".join(map(str, [len(face), *face])) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def off_cases() -> Iterator[Case]:
    whole = off_bytes()
    yield from read_anyhow("whole", "off", whole)
    yield from cuts("whole", "off", whole, may_lack=1)
    yield Case("header.off", b"OFF\n")
    yield Case("nan.off", off_bytes(position=NAN), "vertex 5")
    yield Case("inf.off", off_bytes(position=HUGE), "vertex 2")
    yield Case("below.off", off_bytes(position=BELOW), "vertex 0")
    yield Case("past.off", off_bytes(faces=PAST), ":11")
    yield Case("negative.off", off_bytes(faces=NEGATIVE), ":11")
    yield Case("wrapped.off", off_bytes(faces=[[0, 1, 2**32 - 1], *FACES[1:]]), ":11")
    yield Case("binary.off", off_bytes("OFF BINARY"), "binary")
    yield Case("many.off", off_bytes(faces=[[0] * 3]).replace(b"\n3 0", b"\n2147483646 0"), ":11")
    for count in COUNTS:
        yield Case(f"vertices_{count.decode()}.off", whole.replace(b"8 6 0", count + b" 6 0"), ":2")
        yield Case(f"faces_{count.decode()}.off", whole.replace(b"8 6 0", b"8 " + count + b" 0"),
                   ":2")
    yield Case("line_counts.off", b"OFF\n", "", (3,), b"1 ")
    yield Case("line_vertex.off", b"OFF\n8 6 0\n", "", (3,), b"0.25 ")
    yield Case("duplicate.off", off_bytes(faces=[*FACES, triangles_of(FACES)[0]]),
               "duplicate-faces", (0,))
