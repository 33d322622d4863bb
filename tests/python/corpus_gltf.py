# SPDX-License-Identifier: Apache-2.0
"""Broken GLB and glTF files: containers, JSON, ranges, compression, and paths that lead outside."""

from __future__ import annotations

import base64
import copy
import json
import struct
from collections.abc import Iterator
from typing import Any

from command import glb_bytes, glb_parts
from corpus import Case, cuts, read_anyhow
from corpus_mesh import BELOW, FACES, HUGE, NAN, PAST, POSITION

DOCUMENT, DATA = glb_parts(POSITION, FACES)
NODES = 100_000
DRACO, MESHOPT = "KHR_draco_mesh_compression", "EXT_meshopt_compression"


def changed(*changes: tuple[tuple[Any, ...], Any]) -> dict[str, Any]:
    """The document with values at some places."""
    other = copy.deepcopy(DOCUMENT)
    for place, value in changes:
        inner: Any = other
        for key in place[:-1]:
            inner = inner[key]
        inner[place[-1]] = value
    return other


def container_cases() -> Iterator[Case]:
    whole = glb_bytes(DOCUMENT, DATA)
    yield Case("header.glb", whole[:12])
    yield Case("version.glb", whole[:4] + struct.pack("<I", 1) + whole[8:])
    yield Case("big_endian.glb", whole[:4] + struct.pack(">II", 2, len(whole)) + whole[12:])
    for length in (len(whole) + 4, 2**31, 2**32 - 4):
        yield Case(f"length_{length}.glb", whole[:8] + struct.pack("<I", length) + whole[12:])
        yield Case(f"chunk_{length}.glb", whole[:12] + struct.pack("<I", length) + whole[16:])
    yield Case("no_json.glb", whole.replace(b'{"asset"', b'["asset"'))
    yield from cuts("whole", "glb", whole)
    for name, position in (("nan", NAN), ("inf", HUGE), ("below", BELOW)):
        content = glb_bytes(*glb_parts(position, FACES))
        for word in (b"-Infinity", b"Infinity", b"NaN"):
            content = content.replace(word, b"0" + b" " * (len(word) - 1))
        yield Case(f"{name}.glb", content, "is not finite")
    yield Case("past.glb", glb_bytes(*glb_parts(POSITION, PAST)), "8")
    document, data = glb_parts(POSITION, FACES)
    index = document["bufferViews"][1]["byteOffset"]
    yield Case("wrapped.glb", glb_bytes(document, data[:index] + b"\xff\xff" + data[index + 2:]),
               "65535")


def range_cases() -> Iterator[Case]:
    sparse = {"count": 4, "indices": {"bufferView": 1, "componentType": 5123},
              "values": {"bufferView": 0}}
    for name, place, value in (
            ("count", ("accessors", 0, "count"), 2**31),
            ("count_63", ("accessors", 0, "count"), 2**63),
            ("negative_count", ("accessors", 0, "count"), -8),
            ("offset", ("accessors", 0, "byteOffset"), 2**53),
            ("offset_64", ("accessors", 0, "byteOffset"), 2**64 - 8),
            ("view", ("bufferViews", 0, "byteLength"), 4000000000),
            ("view_64", ("bufferViews", 0, "byteLength"), 2**64 - 8),
            ("view_offset", ("bufferViews", 1, "byteOffset"), 2**53),
            ("view_offset_64", ("bufferViews", 1, "byteOffset"), 2**64 - 8),
            ("no_view", ("accessors", 0, "bufferView"), 7),
            ("no_buffer", ("bufferViews", 0, "buffer"), 3),
            ("buffer", ("buffers", 0, "byteLength"), 4000000000),
            ("component", ("accessors", 0, "componentType"), 5124),
            ("no_accessor", ("meshes", 0, "primitives", 0, "attributes", "POSITION"), 9),
            ("no_mesh", ("nodes", 0, "mesh"), 4), ("no_node", ("scenes", 0, "nodes"), [5]),
            ("cycle", ("nodes", 0, "children"), [0]),
            ("ring", ("nodes",), [{"children": [1], "mesh": 0}, {"children": [0]}]),
            ("two_parents", ("nodes",), [{"children": [2]}, {"children": [2]}, {"mesh": 0}]),
            ("matrix", ("nodes", 0, "matrix"), [1e39] * 16),
            ("skin", ("nodes", 0, "skin"), 0),
            ("required", ("extensionsRequired",), ["EXT_unheard_of"]),
            ("sparse_31", ("accessors", 0, "sparse"), {**sparse, "count": 2**31}),
            ("sparse_overflow", ("accessors", 0, "sparse"), {**sparse, "count": 2**31 // 6 + 1}),
            ("sparse_offset", ("accessors", 0, "sparse"), {
                **sparse, "values": {"bufferView": 0, "byteOffset": 2**64 - 8}}),
            ("sparse_outside", ("accessors", 0, "sparse"), {
                **sparse, "indices": {"bufferView": 0, "componentType": 5125}})):
        yield Case(f"{name}.glb", glb_bytes(changed((place, value)), DATA))


def bomb_cases() -> Iterator[Case]:
    """Little that claims to be much."""
    chain: list[dict[str, Any]] = [{"children": [n + 1]} for n in range(NODES - 1)]
    nested = changed((("nodes",), [*chain, {"mesh": 0}]))
    yield Case("nested.glb", glb_bytes(nested, DATA), "usable", (0,))
    nested["nodes"][-1]["children"] = [0]
    yield Case("nested_ring.glb", glb_bytes(nested, DATA), "cycle")
    for name, opening, closing in (("lists", b"[", b"]"), ("objects", b'{"a":', b"}")):
        deep = opening * NODES + b"1" + closing * NODES
        yield Case(f"deep_{name}.gltf", b'{"asset": {"version": "2.0"}, "extras": ' + deep + b"}",
                   "nested")
    yield Case("line.gltf", b'{"a": ', "", (3,), b"0.25 ")
    uri = b'{"asset": {"version": "2.0"}, "buffers": [{"byteLength": %d, "uri": "data:;base64,'
    for length in (4, 2**31, 2**63):
        yield Case(f"data_{length}.gltf", uri % length, "", (3,), b"AAAA", b'"}]}')
    accessors = [{"componentType": 5126, "count": 2**28, "type": "VEC3"},
                 {"componentType": 5125, "count": 3 * 2**28, "type": "SCALAR"}]
    stream = b"DRACO\2\2\1\0\0\0" + b"\xff\xff\xff\xff\x07" * 2 + b"\1" + bytes(64)
    for name, content, count in (("accessor", stream, 2**28), ("stream", stream, 8),
                                 ("noise", bytes(range(256)), 2**28)):
        extension = {DRACO: {"bufferView": 0, "attributes": {"POSITION": 0}}}
        accessors = [{**accessors[0], "count": count}, {**accessors[1], "count": 3 * count}]
        document = changed(
            (("accessors",), accessors), (("bufferViews",), [{"buffer": 0,
                                                               "byteLength": len(content)}]),
            (("buffers",), [{"byteLength": len(content)}]),
            (("meshes", 0, "primitives", 0, "extensions"), extension),
            (("extensionsRequired",), [DRACO]), (("extensionsUsed",), [DRACO]))
        yield Case(f"draco_{name}.glb", glb_bytes(document, content))
    for count in (8, 2**24, 2**31 - 1):
        view = {"buffer": 0, "byteLength": len(DATA), "byteStride": 12, "count": count,
                "mode": "ATTRIBUTES"}
        document = changed(
            (("bufferViews", 0), {"buffer": 0, "byteLength": 12 * count,
                                  "extensions": {MESHOPT: view}}),
            (("accessors", 0, "count"), count), (("extensionsRequired",), [MESHOPT]),
            (("extensionsUsed",), [MESHOPT]))
        yield Case(f"meshopt_{count}.glb", glb_bytes(document, DATA))


def path_cases() -> Iterator[Case]:
    """The buffer lies outside: whoever opened it could read the mesh."""
    outside = {"../outside.bin": DATA, "beside.bin": DATA}
    for name, uri, codes in (
            ("beside", "beside.bin", (0,)), ("up", "../outside.bin", (3,)),
            ("up_down", "x/../../outside.bin", (3,)), ("escaped", "%2e%2e/outside.bin", (3,)),
            ("slashes", "..\\\\outside.bin", (3,)), ("absolute", "@FOLDER@/outside.bin", (3,)),
            ("file", "file://@FOLDER@/outside.bin", (3,)),
            ("http", "http://127.0.0.1:9/outside.bin", (3,)),
            ("host", "//127.0.0.1/outside.bin", (3,)), ("device", "/dev/zero", (3,)),
            ("null", "beside.bin%00", (3,))):
        for kind in ("gltf", "glb"):
            text = json.dumps(changed((("buffers", 0, "uri"), "URI"))).replace("URI", uri)
            # in a GLB the lengths are those before @FOLDER@ is known: only fixed names
            if kind == "glb" and "@" in uri:
                continue
            content = text.encode() if kind == "gltf" else glb_bytes(json.loads(text), b"")
            yield Case(f"{name}.{kind}", content, "usable" if codes == (0,) else "buffers[0]",
                       codes, beside=outside)
    image = changed((("images",), [{"uri": "../outside.png"}]),
                    (("buffers", 0, "uri"), "beside.bin"))
    yield Case("image.gltf", json.dumps(image).encode(), "images[0]", beside={
        "../outside.png": b"\x89PNG", "beside.bin": DATA})
    material = b"mtllib ../outside.mtl\nmtllib @FOLDER@/outside.mtl\nmtllib http://127.0.0.1/m\n"
    yield Case("library.obj", material + b"usemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
               b"f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "missing-material-file", (0,),
               beside={"../outside.mtl": b"newmtl m\n"})


def gltf_cases() -> Iterator[Case]:
    uri = "data:application/octet-stream;base64," + base64.b64encode(DATA).decode()
    whole = json.dumps(changed((("buffers", 0, "uri"), uri)), indent=1).encode()
    yield from read_anyhow("whole", "gltf", whole)
    yield from cuts("whole", "gltf", whole)
    yield Case("no_base64.gltf", whole.replace(b"base64,", b"base64,!"), "base64")
    yield Case("no_comma.gltf", whole.replace(b"base64,", b"base64"), "base64")
    yield Case("glb.gltf", glb_bytes(DOCUMENT, DATA)[20:])
