# SPDX-License-Identifier: Apache-2.0
"""Broken point clouds (PLY, XYZ, PCD, LAS) and splats (3DGS and PlayCanvas PLY, .splat, SPZ)."""

from __future__ import annotations

import gzip
import itertools
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from corpus import Case, cuts, read_anyhow, with_bytes
from corpus_mesh import COUNTS

SIDE = 6
POINTS = np.array(list(itertools.product(np.linspace(0, 1, SIDE), repeat=3)))  # a block
COUNT = len(POINTS)
VALUES = (("nan", np.nan), ("inf", np.inf), ("below", -np.inf))


def with_value(value: float) -> NDArray[np.float64]:
    """The points, number 5 not finite."""
    points = POINTS.copy()
    points[5, 1] = value
    return points


def rows_of(points: NDArray[np.float64]) -> bytes:
    return "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()).encode()


def head_of_ply(encoding: str, properties: list[str], count: object = COUNT) -> bytes:
    lines = ["ply", f"format {encoding} 1.0", f"element vertex {count}",
             *(f"property float {name}" for name in properties), "end_header"]
    return ("\n".join(lines) + "\n").encode()


def ply_cloud_cases() -> Iterator[Case]:
    text, little, big = (head_of_ply(e, ["x", "y", "z"]) for e in (
        "ascii", "binary_little_endian", "binary_big_endian"))
    bodies = {"text": (text, rows_of), "little": (little, lambda p: p.astype("<f4").tobytes()),
              "big": (big, lambda p: p.astype(">f4").tobytes())}
    for stem, (head, body) in bodies.items():
        whole = head + body(POINTS)
        yield from cuts(stem, "ply", whole, may_lack=3 if stem == "text" else 0)
        for name, value in VALUES:
            yield Case(f"{stem}_{name}.ply", head + body(with_value(value)), "bad-points (1)",
                       (0,))
        yield Case(f"{stem}_none.ply", head + body(POINTS * np.nan), "finite")
        for count in (b"0", *COUNTS):
            yield Case(f"{stem}_{count.decode()}.ply",
                       whole.replace(b"vertex %d" % COUNT, b"vertex " + count))
    yield Case("one_place.ply", little + bytes(12 * COUNT), "one place")
    yield Case("text_is_little.ply", little + rows_of(POINTS)[:12 * COUNT - 1])
    yield Case("little_is_text.ply", text + POINTS.astype("<f4").tobytes())
    yield from read_anyhow("text", "ply", text + rows_of(POINTS))


def xyz_cases() -> Iterator[Case]:
    whole = rows_of(POINTS)
    yield from read_anyhow("whole", "xyz", whole)
    yield from cuts("whole", "xyz", whole, codes=(0, 3))
    for name, value in VALUES:
        yield Case(f"{name}.xyz", rows_of(with_value(value)), "bad-points (1)", (0,))
    yield Case("header.xyz", b"x y z\n", "no points")
    yield Case("one.xyz", b"1 2 3\n", "one place")
    yield Case("comma.xyz", b"1,5;2,5;3,5\n", ":1")
    yield Case("two.xyz", whole + b"1 2\n", f":{COUNT + 1}")
    yield Case("word.xyz", whole + b"1 2 x\n", f":{COUNT + 1}")
    yield Case("binary.xyz", whole + bytes(50))
    yield Case("floats.xyz", POINTS.tobytes())
    for count in COUNTS:
        yield Case(f"{count.decode()}.pts", count + b"\n" + whole)
    for name, head, fill in (("numbers", b"", b"0.25 "), ("comment", b"# ", b"x "),
                             ("blank", b"", b" "), ("word", b"", b"1")):
        yield Case(f"line_{name}.xyz", head, "", (3,), fill)


def pcd_head(data: str, count: object = COUNT) -> bytes:
    return (f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
            f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\n"
            f"DATA {data}\n").encode()


def literals(data: bytes) -> bytes:
    """LZF that only copies, with the two lengths before it."""
    packed = b"".join(bytes([len(data[k:k + 32]) - 1]) + data[k:k + 32]
                      for k in range(0, len(data), 32))
    return struct.pack("<II", len(packed), len(data)) + packed


def pcd_cases() -> Iterator[Case]:
    floats = POINTS.astype("<f4")
    packed = literals(floats.T.tobytes())
    wholes = {"ascii": rows_of(POINTS), "binary": floats.tobytes(), "binary_compressed": packed}
    for data, body in wholes.items():
        whole = pcd_head(data) + body
        yield Case(f"{data}.pcd", whole, "usable", (0,))
        yield from cuts(data, "pcd", whole, may_lack=3 if data == "ascii" else 0)
        for count in (b"0", *COUNTS):
            yield Case(f"{data}_{count.decode()}.pcd", pcd_head(data, count.decode()) + body)
        for other, wrong in wholes.items():
            if other != data and data != "binary":
                yield Case(f"{data}_is_{other}.pcd", pcd_head(data) + wrong)
    for name, value in VALUES:
        points = with_value(value)
        for data, body in (("ascii", rows_of(points)), ("binary", points.astype("<f4").tobytes())):
            yield Case(f"{data}_{name}.pcd", pcd_head(data) + body, "bad-points (1)", (0,))
    yield from read_anyhow("ascii", "pcd", pcd_head("ascii") + rows_of(POINTS))
    big = 2**32 - 1
    for name, lengths in (("packed", (big, 12 * COUNT)), ("unpacked", (len(packed) - 8, big)),
                          ("big_endian", struct.unpack(">II", packed[:8]))):
        yield Case(f"lengths_{name}.pcd", pcd_head("binary_compressed")
                   + struct.pack("<II", *lengths) + packed[8:])
    # 264 bytes for each three
    bomb = b"\0\0" + b"\xe0\xff\0" * 1_000_000
    size = 1 + 264 * 1_000_000
    yield Case("bomb.pcd", pcd_head("binary_compressed", size // 12)
               + struct.pack("<II", len(bomb), size // 12 * 12) + bomb)
    for name, head in (("header", b"# .PCD v0.7\n"), ("body", pcd_head("ascii"))):
        yield Case(f"line_{name}.pcd", head, "", (3,), b"0.25 ")


def las_bytes(points: NDArray[np.float64] = POINTS) -> bytes:
    """LAS 1.2 of the point format 0, in millimetres."""
    head = bytearray(227)
    head[:4] = b"LASF"
    head[24:26] = bytes([1, 2])
    struct.pack_into("<HII", head, 94, 227, 227, 0)
    struct.pack_into("<BHI", head, 104, 0, 20, len(points))
    struct.pack_into("<6d", head, 131, *(1e-3,) * 3, *(0,) * 3)
    records = b"".join(struct.pack("<3i8x", *(int(1000 * x) for x in p)) for p in points)
    return bytes(head) + records


def las_cases() -> Iterator[Case]:
    whole = las_bytes()
    yield Case("whole.las", whole, "usable", (0,))
    yield Case("header.las", whole[:227])
    yield Case("none.las", las_bytes(POINTS[:0]), "no points")
    yield from cuts("whole", "las", whole)
    for name, offset, part in (
            ("count_31", 107, struct.pack("<I", 2**31)), ("count_32", 107, b"\xff" * 4),
            ("big_endian", 107, struct.pack(">I", COUNT)), ("offset", 96, b"\xff" * 4),
            ("inside", 96, struct.pack("<I", 4)), ("record_0", 105, bytes(2)),
            ("record_65535", 105, b"\xff\xff"), ("format", 104, b"\x0b"), ("laz", 104, b"\x80"),
            ("version", 24, b"\2"), ("nan", 131, struct.pack("<d", np.nan)),
            ("inf", 155, struct.pack("<d", np.inf)), ("zero", 131, bytes(24))):
        yield Case(f"{name}.las", with_bytes(whole, offset, part))
    head14 = bytearray(whole[:227] + bytes(148))
    head14[25] = 4
    struct.pack_into("<I", head14, 96, 375)
    for count in (2**31, 2**63, 2**64 - 1):
        struct.pack_into("<I", head14, 107, 0)
        struct.pack_into("<Q", head14, 247, count)
        yield Case(f"points_{count}.las", bytes(head14) + whole[227:])
    yield Case("line.las", b"LASF", "", (3,), b"0.25 ")


SPLAT = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
         "rot_0", "rot_1", "rot_2", "rot_3"]


def gaussians() -> NDArray[np.float32]:
    """Rows of 3DGS: balls of 0.1 at the points."""
    rows = np.zeros((COUNT, len(SPLAT)), "<f4")
    rows[:, :3] = POINTS
    rows[:, 6], rows[:, 7:10], rows[:, 10] = 3, np.log(0.1), 1
    return rows


def splat_ply_cases() -> Iterator[Case]:
    head, rows = head_of_ply("binary_little_endian", SPLAT), gaussians()
    yield Case("gaussians.ply", head + rows.tobytes(), "usable", (0,))
    yield from cuts("gaussians", "ply", head + rows.tobytes())
    for count in (b"0", *COUNTS):
        yield Case(f"gaussians_{count.decode()}.ply", head_of_ply(
            "binary_little_endian", SPLAT, count.decode()) + rows.tobytes())
    yield Case("gaussian.ply", head_of_ply("binary_little_endian", SPLAT, 1) + rows[:1].tobytes(),
               "enclose nothing")
    for name, column, value, finding in (
            ("nan", 1, np.nan, "bad-splats (1)"), ("inf", 2, np.inf, "bad-splats (1)"),
            ("quaternion", slice(10, 14), 0, "bad-rotations (1)"),
            ("quaternion_nan", 11, np.nan, "bad-rotations (1)"),
            ("scale", 8, np.inf, "bad-splats (1)"), ("scale_big", 8, 1e30, "bad-splats (1)"),
            ("scale_below", 8, -np.inf, "usable"), ("opacity", 6, np.nan, "bad-splats (1)"),
            ("colour", 3, np.nan, "bad-harmonics (1)")):
        changed = rows.copy()
        changed[7, column] = value
        yield Case(f"gaussians_{name}.ply", head + changed.tobytes(), finding, (0,))
    yield Case("harmonics.ply", head.replace(b"property float opacity",
                                             b"property float f_rest_0\nproperty float opacity")
               + rows.tobytes() + bytes(4 * COUNT), "f_rest")
    yield Case("big_endian.ply", head.replace(b"little", b"big") + rows.tobytes(), "", (0, 3))


def packed_ply(count: object = COUNT, chunks: object = 1) -> bytes:
    names = [f"{end}_{name}" for name in ("x", "y", "z", "scale_x", "scale_y", "scale_z")
             for end in ("min", "max")]
    words = [f"packed_{name}" for name in ("position", "rotation", "scale", "color")]
    lines = ["ply", "format binary_little_endian 1.0", f"element chunk {chunks}",
             *(f"property float {name}" for name in names), f"element vertex {count}",
             *(f"property uint {name}" for name in words), "end_header"]
    place = np.round(POINTS * [2047, 1023, 2047]).astype(np.uint32)
    position = place[:, 0] << 21 | place[:, 1] << 11 | place[:, 2]
    word = np.full((COUNT, 4), 512 << 20 | 512 << 10 | 512, "<u4")
    word[:, 0], word[:, 3] = position, 0xFFFFFFFF
    ranges = struct.pack("<12f", *(0, 1) * 3, *(-3, -2) * 3)
    return ("\n".join(lines) + "\n").encode() + ranges + word.tobytes()


def packed_cases() -> Iterator[Case]:
    whole = packed_ply()
    yield Case("packed.ply", whole, "usable", (0,))
    yield from cuts("packed", "ply", whole)
    for count in (b"0", b"257", *COUNTS):
        yield Case(f"packed_{count.decode()}.ply", packed_ply(count.decode()))
    for count in (b"0", b"2", *COUNTS):
        yield Case(f"packed_chunks_{count.decode()}.ply", packed_ply(chunks=count.decode()))
    ranges = whole.index(b"end_header\n") + 11
    for name, value in VALUES:
        yield Case(f"packed_{name}.ply", with_bytes(whole, ranges, struct.pack("<f", value)))


def splat_cases() -> Iterator[Case]:
    row = struct.pack("<3f", 0.1, 0.1, 0.1) + b"\x80\x80\x80\xff" + b"\xff\x80\x80\x80"
    whole = b"".join(struct.pack("<3f", *p) + row for p in POINTS)
    yield Case("whole.splat", whole, "usable", (0,))
    yield Case("text.splat", rows_of(POINTS)[:32 * 30 + 1], "multiple")
    for k in (1, 31, 33, len(whole) - 1):
        yield Case(f"whole_cut_{k}.splat", whole[:k], "multiple")
    yield from cuts("whole", "splat", whole, codes=(0, 3))
    for name, offset, value, finding in (
            ("nan", 4, np.nan, "bad-splats (1)"), ("inf", 8, np.inf, "bad-splats (1)"),
            ("scale", 12, np.inf, "bad-splats (1)"), ("negative", 16, -1, "bad-splats (1)")):
        yield Case(f"{name}.splat", with_bytes(whole, 32 * 9 + offset, struct.pack("<f", value)),
                   finding, (0,))
    yield Case("quaternion.splat", with_bytes(whole, 32 * 9 + 28, b"\x80" * 4),
               "bad-rotations (1)", (0,))
    yield Case("none.splat", struct.pack("<f", np.nan) * 8 * COUNT, "finite")
    yield Case("line.splat", b"", "", (0, 3), b"0.25" * 8)


def bomb(begin: bytes) -> bytes:
    """A gzip stream of a beginning and a gigabyte of zeros."""
    packer = zlib.compressobj(1, wbits=31)
    block = bytes(1 << 20)
    parts = [packer.compress(begin), *(packer.compress(block) for _ in range(1000))]
    return b"".join(parts) + packer.flush()


def spz4_cases(place: bytes) -> Iterator[Case]:
    def stored(values: bytes) -> bytes:  # a Zstandard frame of one block that is not packed
        block = (len(values) << 3 | 1).to_bytes(3, "little")
        return struct.pack("<IBI", 0xfd2fb528, 0xa0, len(values)) + block + values

    attributes = [place, b"\xf0" * COUNT, b"\x80" * 3 * COUNT, bytes([123]) * 3 * COUNT,
                  bytes([0, 0, 0, 0xc0]) * COUNT]
    streams = [stored(a) for a in attributes]
    table = b"".join(struct.pack("<QQ", len(s), len(a)) for s, a in zip(streams, attributes))
    whole = struct.pack("<4sIIBBBBI12x", b"NGSP", 4, COUNT, 0, 12, 0, 5, 32) + table
    whole += b"".join(streams)
    yield Case("four.spz", whole, "usable", (0,))
    yield from cuts("four", "spz", whole)
    for name, offset, value in (("count", 8, 2**31), ("table", 16, 2**31), ("size", 32, 2**31),
                                ("unpacked", 40, 2**31), ("block", 32 + 80 + 9, 0xffffffff)):
        yield Case(f"four_{name}.spz", with_bytes(whole, offset, struct.pack("<I", value)))


def spz_cases() -> Iterator[Case]:
    def head(count: int = COUNT, version: int = 2, degree: int = 0, fraction: int = 12) -> bytes:
        return struct.pack("<4sIIBBBB", b"NGSP", version, count, degree, fraction, 0, 0)

    place = np.round(POINTS * 4096).astype("<i4").reshape(-1, 1).view(np.uint8)[:, :3].tobytes()
    body = place + b"\xf0" * COUNT + b"\x80" * 3 * COUNT + bytes([123]) * 3 * COUNT
    body += b"\x80" * 3 * COUNT
    whole = gzip.compress(head() + body, mtime=0)
    yield Case("whole.spz", whole, "usable", (0,))
    yield from cuts("whole", "spz", whole)
    for count in (0, COUNT - 1, COUNT + 1, 2**31, 2**32 - 1):
        yield Case(f"count_{count}.spz", gzip.compress(head(count) + body))
    for name, content in (
            ("version", head(version=4) + body), ("degree", head(degree=4) + body),
            ("harmonics", head(degree=3) + body), ("fraction", head(fraction=24) + body),
            ("other", b"LASF" + bytes(100)), ("header", head()[:10])):
        yield Case(f"{name}.spz", gzip.compress(content))
    yield Case("plain.spz", head() + body)
    yield from spz4_cases(place)
    for k in (12, len(whole) // 2, len(whole) - 6):  # stream, stream, its sum
        yield Case(f"damaged_{k}.spz", with_bytes(whole, k, bytes([whole[k] ^ 0xFF])))
    yield Case("bomb.spz", bomb(head(50_000_000)), "too many")
    yield Case("bomb_behind.spz", bomb(head() + body), "more bytes")
    yield Case("line.spz", b"\x1f\x8b\x08\x00", "", (3,), b"0.25 ")
