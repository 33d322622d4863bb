# SPDX-License-Identifier: Apache-2.0
"""Broken files of the formats that go through the reader process: FBX, DAE, 3DS, VDB."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from command import run, write_obj
from corpus import Case, cuts, read_anyhow, with_bytes
from corpus_mesh import FACES, POSITION

DEEP = 100_000
NUMBERS = b"0,0,0,1,0,0,0,2,0,0,0,3"
FBX = (b"; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n FBXHeaderVersion: 1003\n"
       b" FBXVersion: 7400\n}\nObjects:  {\n Geometry: 1000, \"Geometry::wedge\", \"Mesh\" {\n"
       b"  Vertices: *12 {\n   a: " + NUMBERS + b"\n  }\n"
       b"  PolygonVertexIndex: *12 {\n   a: 0,2,-2,0,1,-4,0,3,-3,1,2,-4\n  }\n"
       b"  GeometryVersion: 124\n }\n Model: 2000, \"Model::wedge\", \"Mesh\" {\n  Version: 232\n"
       b" }\n}\nConnections:  {\n C: \"OO\",2000,0\n C: \"OO\",1000,2000\n}\n")
INDICES = b"0 2 1 0 1 3 0 3 2 1 2 3"
DAE = (b"<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' "
       b"version='1.4.1'><asset><unit name='u' meter='1'/><up_axis>Y_UP</up_axis></asset>"
       b"<library_geometries><geometry id='g' name='wedge'><mesh><source id='p'>"
       b"<float_array id='a' count='12'>" + NUMBERS.replace(b",", b" ") + b"</float_array>"
       b"<technique_common><accessor source='#a' count='4' stride='3'>"
       b"<param name='X' type='float'/><param name='Y' type='float'/>"
       b"<param name='Z' type='float'/></accessor></technique_common></source><vertices id='v'>"
       b"<input semantic='POSITION' source='#p'/></vertices><triangles count='4'>"
       b"<input semantic='VERTEX' source='#v' offset='0'/><p>" + INDICES + b"</p></triangles>"
       b"</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'>"
       b"<node id='n'><instance_geometry url='#g'/></node></visual_scene></library_visual_scenes>"
       b"<scene><instance_visual_scene url='#s'/></scene></COLLADA>")


def fbx_cases() -> Iterator[Case]:
    yield Case("crlf.fbx", FBX.replace(b"\n", b"\r\n"), "usable", (0,))
    yield Case("mark.fbx", b"\xef\xbb\xbf" + FBX, "FBX-Parser")  # not assimp's
    yield from cuts("whole", "fbx", FBX, codes=(0, 3))
    yield Case("header.fbx", FBX[:FBX.index(b"Objects")])
    for name, old, new in (
            ("old", b"7400", b"6100"), ("nan", NUMBERS, b"nan" + NUMBERS[1:]),
            ("inf", NUMBERS, b"1e999" + NUMBERS[1:]), ("past", b"0,2,-2", b"0,4,-2"),
            ("wrapped", b"0,2,-2", b"0,2147483647,-2"), ("word", NUMBERS, b"one" + NUMBERS[1:])):
        yield Case(f"{name}.fbx", FBX.replace(old, new))
    for count in (b"2147483648", b"9223372036854775808", b"-1"):
        yield Case(f"count_{count.decode()}.fbx",
                   FBX.replace(b"Vertices: *12", b"Vertices: *" + count), "", (0, 3))
    yield Case("deep.fbx", FBX + b"a: {" * DEEP + b"}" * DEEP, "", (0, 3))
    ring = b" C: \"OO\",2000,0\n"
    yield Case("ring.fbx", FBX.replace(ring, ring + b" C: \"OO\",2000,2000\n"), "", (0, 3))
    binary = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400)
    yield Case("binary_header.fbx", binary)
    for name, node in (("end", (2**32 - 1, 1, 4)), ("many", (200, 2**32 - 1, 4)),
                       ("long", (200, 1, 2**32 - 1)), ("back", (10, 1, 4))):
        yield Case(f"binary_{name}.fbx", binary + struct.pack("<3IB", *node, 3) + b"abc"
                   + bytes(200))
    nested = b"".join(struct.pack("<3IB", 27 + 13 * DEEP, 0, 0, 0) for _ in range(DEEP))
    yield Case("binary_deep.fbx", binary + nested)
    yield Case("text_as_binary.fbx", binary + FBX)
    yield Case("line.fbx", b"; FBX 7.4.0 project file\n", "", (3,), b"0.25 ")


def dae_cases() -> Iterator[Case]:
    yield from read_anyhow("whole", "dae", DAE.replace(b"><", b">\n<"))
    yield from cuts("whole", "dae", DAE)
    numbers = NUMBERS.replace(b",", b" ")
    for name, old, new in (
            ("nan", numbers, b"nan" + numbers[1:]), ("past", INDICES, b"4" + INDICES[1:]),
            ("inf", numbers, b"1e999" + numbers[1:]),
            ("negative", INDICES, b"-1" + INDICES[1:]),
            ("wrapped", INDICES, b"4294967295" + INDICES[1:]),
            ("no_mesh", b"<mesh>", b"<mess>")):
        # assimp uses 0 in place of an index that is no int
        codes = (0, 3) if name in ("negative", "wrapped") else (3,)
        yield Case(f"{name}.dae", DAE.replace(old, new), "", codes)
    for count in (b"2147483648", b"4294967295", b"18446744073709551616", b"-1"):
        for attribute in (b"count='12'", b"count='4' stride", b"count='4'><input"):
            where = attribute.split(b"'")[1] + attribute[-1:]
            yield Case(f"count_{where.decode()}_{count.decode()}.dae".replace(">", ""), DAE.replace(
                attribute, attribute.replace(attribute.split(b"'")[1], count)), "", (0, 3))
    laughs = b"".join(b"<!ENTITY a%d '%s'>" % (k, b"&a%d;" % (k - 1) * 10) for k in range(1, 12))
    doctype = b"<!DOCTYPE COLLADA [<!ENTITY a0 'ha'>" + laughs + b"]>"
    yield Case("entities.dae", DAE.replace(b"<COLLADA", doctype + b"<COLLADA", 1).replace(
        b"'wedge'", b"'&a11;'"), "", (0, 3))
    external = b"<!DOCTYPE COLLADA [<!ENTITY a SYSTEM '../outside.txt'>]><COLLADA"
    yield Case("external.dae", DAE.replace(b"<COLLADA", external, 1).replace(numbers, b"&a;"),
               beside={"../outside.txt": numbers})
    yield Case("deep.dae", DAE.replace(b"<node id='n'>", b"<node>" * DEEP + b"<node id='n'>")
               .replace(b"</node>", b"</node>" * (DEEP + 1)))
    node = b"<node id='n'><instance_node url='#n'/>"
    yield Case("ring.dae", DAE.replace(b"<node id='n'>", node), "", (0, 3))
    yield Case("line.dae", b"<?xml version='1.0'?>", "", (3,), b"0.25 ")


def chunk(name: int, content: bytes) -> bytes:
    """A chunk of 3DS."""
    return struct.pack("<HI", name, 6 + len(content)) + content


def three_ds(count: int = 4, face: tuple[int, ...] = (0, 2, 1, 0), faces: int = 4,
             first: float = 0) -> bytes:
    points = struct.pack("<H12f", count, first, *map(float, NUMBERS.split(b",")[1:]))
    corners = struct.pack("<17H", faces, *face, 0, 1, 3, 0, 0, 3, 2, 0, 1, 2, 3, 0)
    mesh = chunk(0x4100, chunk(0x4110, points) + chunk(0x4120, corners))
    return chunk(0x4D4D, chunk(0x3D3D, chunk(0x4000, b"wedge\0" + mesh)))


def three_ds_cases() -> Iterator[Case]:
    whole = three_ds()
    yield Case("whole.3ds", whole, "usable", (0,))
    yield from cuts("whole", "3ds", whole)
    yield Case("header.3ds", whole[:6])
    for name, content in (("points", three_ds(65535)), ("none", three_ds(0)),
                          ("faces", three_ds(faces=65535)), ("past", three_ds(face=(0, 2, 4, 0))),
                          ("wrapped", three_ds(face=(0, 2, 65535, 0))),
                          ("nan", three_ds(first=float("nan"))),
                          ("inf", three_ds(first=float("inf")))):
        # assimp uses the last vertex in place of a missing one
        codes = (0, 3) if name in ("past", "wrapped") else (3,)
        yield Case(f"{name}.3ds", content, "", codes)
    for size in (0, 5, 2**31, 2**32 - 1):
        yield Case(f"size_{size}.3ds", with_bytes(whole, 2, struct.pack("<I", size)), "", (0, 3))
        yield Case(f"inner_{size}.3ds", with_bytes(whole, 8, struct.pack("<I", size)), "", (0, 3))
    yield Case("big_endian.3ds", with_bytes(whole, 2, struct.pack(">I", len(whole))), "", (0, 3))
    deep = b"".join(struct.pack("<HI", 0x4D4D, 6 * (DEEP - k)) for k in range(DEEP))
    yield Case("deep.3ds", deep)
    yield Case("text.3ds", b"MM" + b"0.25 " * 50)
    yield Case("line.3ds", b"MM", "", (3,), b"0.25 ")


@cache
def vdb_bytes() -> bytes:
    """A block of 8^3 voxels, as the command writes it."""
    with tempfile.TemporaryDirectory() as folder:
        source = write_obj(Path(folder) / "a.obj", POSITION, FACES)
        done = run("voxelize", source, "-o", Path(folder) / "a.vdb", "--voxels", 100)
        assert done.code == 0, done.err
        return (Path(folder) / "a.vdb").read_bytes()


def vdb_cases() -> Iterator[Case]:
    whole = vdb_bytes()
    yield Case("whole.vdb", whole, "usable", (0,))
    yield from cuts("whole", "vdb", whole, codes=(0, 3))  # the second grid may be missing
    for k in range(CHUNKS):
        offset = 40 + (len(whole) - 40) * k // CHUNKS
        yield Case(f"chunk_{offset}.vdb", with_bytes(whole, offset, b"\xff" * 8), "", (0, 3))
        yield Case(f"zeros_{offset}.vdb", with_bytes(whole, offset, bytes(8)), "", (0, 3))
    yield Case("line.vdb", whole[:12], "", (3,), b"0.25 ")


CHUNKS = 16
