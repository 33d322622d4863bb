# SPDX-License-Identifier: Apache-2.0
"""Small valid inputs of each harness, and the words of its format."""

from __future__ import annotations

import gzip
import os
import struct
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
os.environ.setdefault("ELASTOGEN_BINARY", "")  # command.py asks for it; nothing is run here

from command import (Floats, glb_bytes, glb_parts, turned_box, write_obj,  # noqa: E402
                     write_ply, write_stl)

from packed_seeds import draco_glb, meshopt_glb, scene_glb  # noqa: E402
from tet_seeds import TET_WORDS, tet_seeds  # noqa: E402

POSITION, FACES = turned_box((0.3, 0.12, 0.1), (1, 2, 3), 25)
MAX_REAL = 300_000  # of a real file that becomes a seed [bytes]

# harness -> endings of real files, each with the byte that the harness wants before it
REAL = {
    "obj": {"obj": b""}, "ply": {"ply": b""}, "stl": {"stl": b""}, "off": {"off": b""},
    "gltf": {"glb": b"", "gltf": b""}, "xyz": {"xyz": b""}, "pcd": {"pcd": b""},
    "las": {"las": b""}, "splat": {"splat": b""}, "spz": {"spz": b""}, "vdb": {"vdb": b"\0"},
    "tets": {"msh": b"", "vtk": b"", "vtu": b""},
    "assimp": {"fbx": b"\0", "dae": b"\1", "3ds": b"\2", "x": b"\3", "ac": b"\4"},
}

SCENE_WORDS = ("pins gravity asset file size up voxels material preset young poisson density law "
               "region select node gltf_material pin motion velocity spin floor place friction "
               "collider shape sphere plane box name centre radius normal lower upper path time "
               "frames fps substeps scheme solver output files true false inf nan").split()
GRAMMAR_WORDS = ("all box( sphere( plane( x< y<= z>= % , ) friction name path : ; = node: "
                 "material: colour: #ff8000 attr: w.x rubber foam young poisson density law "
                 "neo-hookean stvk auto off m mm cm km in ft Pa MPa GPa kg/m3 g/cm3 s ms min deg "
                 "rad rpm m/s km/h m/s2 g0 kB GiB 1e308 -x").split()

# harness -> words that its texts are made of
WORDS = {
    "obj": "v vt vn f g o s usemtl mtllib newmtl Kd map_Kd d Tr // / -1 \\ fuzz.mtl".split(),
    "ply": ("ply format ascii binary_little_endian binary_big_endian 1.0 element vertex face "
            "chunk sh texcoord texnumber TextureFile property list uchar char short ushort int uint float double vertex_indices "
            "x y z nx red alpha f_dc_0 f_rest_0 opacity scale_0 rot_0 packed_position "
            "packed_rotation packed_scale packed_color min_x end_header comment").split(),
    "stl": "solid facet normal outer loop vertex endloop endfacet endsolid".split(),
    "off": "OFF COFF NOFF STOFF 4OFF nOFF BINARY #".split(),
    "xyz": ["nan", "//", "#", ";", ",", "1e308", "\t"],
    "pcd": ("VERSION FIELDS SIZE TYPE COUNT WIDTH HEIGHT VIEWPOINT POINTS DATA ascii binary "
            "binary_compressed x y z rgb rgba normal_x F U I").split(),
    "gltf": ("asset version scene scenes nodes children mesh meshes primitives attributes POSITION "
             "NORMAL TEXCOORD_0 COLOR_0 JOINTS_0 WEIGHTS_0 indices material mode targets accessors "
             "bufferView bufferViews byteOffset byteLength byteStride componentType count type "
             "SCALAR VEC2 VEC3 VEC4 MAT4 normalized sparse values buffers buffer uri skins skin "
             "joints inverseBindMatrices matrix translation rotation scale extensions "
             "extensionsUsed extensionsRequired KHR_draco_mesh_compression "
             "EXT_mesh_gpu_instancing TRANSLATION ROTATION SCALE KHR_node_visibility visible weights "
             "animations channels samplers sampler target input output path "
             "EXT_meshopt_compression KHR_mesh_quantization filter OCTAHEDRAL QUATERNION "
             "EXPONENTIAL ATTRIBUTES TRIANGLES INDICES fallback images animations "
             "data:application/octet-stream;base64,").split(),
    "tets": TET_WORDS,
    "scene_toml": [*SCENE_WORDS, "[[", "]]", '"""', "'''", "= [", "#"],
    "scene_json": [*SCENE_WORDS, '": [', "{", "}", "\\u0000"],
    "grammar": GRAMMAR_WORDS,
}


def written(write: Callable[..., Path], name: str, *arguments: Any) -> bytes:
    """What a writer of command.py writes."""
    with tempfile.TemporaryDirectory() as folder:
        return write(Path(folder) / name, *arguments).read_bytes()


def ply_header(encoding: str, *elements: tuple[str, int, list[str]]) -> bytes:
    """A header; each element has its name, its count and its properties."""
    lines = ["ply", f"format {encoding} 1.0"]
    for name, count, properties in elements:
        lines += [f"element {name} {count}", *(f"property {p}" for p in properties)]
    return "\n".join([*lines, "end_header", ""]).encode()


def shell(count: int) -> Floats:
    """Points of the unit sphere, (count, 3), on a spiral."""
    z = 1 - (2 * np.arange(count) + 1) / count
    angle = np.arange(count) * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)


def obj_seeds() -> list[bytes]:
    plain = written(write_obj, "a.obj", POSITION, FACES)
    rich = (b"mtllib fuzz.mtl\no a\n" + plain.replace(b"f ", b"usemtl red\nf ", 1)
            + b"v 0 0 1 1 0.5 0\nvt 0 1\nvn 0 0 1\nf -1/1/1 2/1/1 3//1\nf 1 2 \\\n 3\n\0"
            + b"newmtl red\nKd 1 0 0\nd 0.5\nmap_Kd a.png\n")
    groups = (b"".join(b"o %c\ng %d\n%s" % (b"AB"[k % 2], k % 3, b"f %d/1 %d/2 %d/1\n" % (
        8 - k, k + 1, (k + 3) % 8 + 1)) for k in range(7)) + b"g\nf 1 2 3\n")
    vertices = b"".join(line + b"\n" for line in plain.splitlines() if line.startswith(b"v "))
    return [plain, rich, vertices + b"vt 0 0\nvt 1 0.5\n" + groups]


def corner_plys() -> list[bytes]:
    """The box with UVs of corners, textures and colours of faces, and columns of its own."""
    vertices = [f"float {n}" for n in "xyz"] + ["uchar label", "double quality"]
    faces = ["list uchar int vertex_indices", "list uchar float texcoord", "int texnumber",
             *(f"uchar {n}" for n in ("red", "green", "blue"))]
    rows = [(face, [0.1 * k for k in range(8)], f % 3 - 1, (40 * f, 7, 255))
            for f, face in enumerate(FACES)]
    seeds = []
    for encoding in ("ascii", "binary_little_endian"):
        head = ply_header(encoding, ("vertex", 8, vertices), ("face", 6, faces)).replace(
            b"element", b"comment TextureFile a.png\ncomment TextureFile b.png\nelement", 1)
        if encoding == "ascii":
            lines = [f"{x} {y} {z} {v} 0.5" for v, (x, y, z) in enumerate(POSITION.tolist())]
            lines += [" ".join(map(str, [4, *face, 8, *uv, number, *colour]))
                      for face, uv, number, colour in rows]
            seeds.append(head + "\n".join(lines).encode() + b"\n")
            continue
        body = b"".join(struct.pack("<3fBd", *x, v, 0.5) for v, x in enumerate(POSITION.tolist()))
        body += b"".join(struct.pack("<B4iB8fi3B", 4, *face, 8, *uv, number, *colour)
                         for face, uv, number, colour in rows)
        seeds.append(head + body)
    return seeds


def ply_seeds() -> list[bytes]:
    seeds = [written(write_ply, "a.ply", POSITION, FACES, encoding)
             for encoding in ("ascii", "binary_little_endian", "binary_big_endian")]
    seeds += corner_plys()
    points = shell(200)
    names = ["x", "y", "z", "nx", "ny", "nz"]
    seeds.append(ply_header("binary_little_endian",
                            ("vertex", 200, [f"float {n}" for n in names]))
                 + np.hstack([points, points]).astype("<f4").tobytes())
    names += ["f_dc_0", "f_dc_1", "f_dc_2", *(f"f_rest_{k}" for k in range(9)), "opacity",
              "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    row = [0.1] * 12 + [2, -2, -2.5, -3, 1, 0, 0.2, 0]
    splats = np.hstack([points, points, np.tile(row, (200, 1))])
    seeds.append(ply_header("binary_little_endian",
                            ("vertex", 200, [f"float {n}" for n in names]))
                 + splats.astype("<f4").tobytes())
    rgb = [n for n in names if not n.startswith("f_") and n not in ("opacity", "nx", "ny", "nz")]
    row = np.array([0.1, 0.1, 0.05, 1, 0, 0.2, 0], "<f4").tobytes() + bytes([255, 0, 51, 7])
    seeds.append(ply_header("binary_little_endian", ("vertex", 200, [
        *(f"float {n}" for n in rgb), *(f"uchar {n}" for n in ("red", "green", "blue", "label"))]))
        + b"".join(x.astype("<f4").tobytes() + row for x in points))
    limits = [f"float {end}_{n}" for end in ("min", "max")
              for n in ("x", "y", "z", "scale_x", "scale_y", "scale_z")]
    packed = [f"uint packed_{n}" for n in ("position", "rotation", "scale", "color")]
    words = np.random.default_rng(1).integers(0, 2**32, (60, 4), np.uint32) | [0, 0, 0, 0xff << 24]
    seeds.append(ply_header("binary_little_endian", ("chunk", 1, limits), ("vertex", 60, packed))
                 + np.array([-1, -1, -1, -3, -3, -3, 1, 1, 1, -2, -2, -2], "<f4").tobytes()
                 + words.astype("<u4").tobytes())
    return seeds


def skinned_glb() -> bytes:
    """The box hung on two joints."""
    document, data = glb_parts(POSITION, FACES)
    joints, weights = np.tile(np.uint8([0, 1, 0, 0]), (8, 1)), np.tile(
        np.float32([0.25, 0.75, 0, 0]), (8, 1))
    inverse = np.tile(np.eye(4, dtype="<f4").ravel(), 2)
    for values, kind, component, count in ((joints, "VEC4", 5121, 8), (weights, "VEC4", 5126, 8),
                                           (inverse, "MAT4", 5126, 2)):
        data += bytes(-len(data) % 4)
        document["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1,
                                      "componentType": component, "count": count, "type": kind})
        data += values.tobytes()
    document["meshes"][0]["primitives"][0]["attributes"] |= {"JOINTS_0": 2, "WEIGHTS_0": 3}
    document["nodes"] = [{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [0, 0.1, 0]}]
    document["scenes"] = [{"nodes": [0, 1]}]
    document["skins"] = [{"joints": [1, 2], "inverseBindMatrices": 4}]
    document["buffers"][0]["byteLength"] = len(data)
    return glb_bytes(document, data)


def quantized_glb() -> bytes:
    """The box with positions of 16 bits."""
    document, data = glb_parts(POSITION, FACES)
    data = (POSITION * 100000).astype("<i2").tobytes() + data[96:]
    data = b"".join(data[6 * v:6 * v + 6] + b"\0\0" for v in range(8)) + data[48:]
    document["accessors"][0] |= {"componentType": 5122, "normalized": True,
                                 "min": [-32767] * 3, "max": [32767] * 3}
    document["bufferViews"] = [{"buffer": 0, "byteLength": 64, "byteStride": 8},
                               {"buffer": 0, "byteOffset": 64, "byteLength": 72}]
    document["buffers"] = [{"byteLength": 136}]
    document["extensionsUsed"] = document["extensionsRequired"] = ["KHR_mesh_quantization"]
    return glb_bytes(document, data)


def pcd_seeds() -> list[bytes]:
    points = np.hstack([shell(80), np.full((80, 1), 0.0)]).astype("<f4")

    def header(data: str) -> bytes:
        return ("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n"
                "COUNT 1 1 1 1\nWIDTH 80\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 80\n"
                f"DATA {data}\n").encode()

    text = "".join(f"{x} {y} {z} 16711680\n" for x, y, z, _ in points.tolist())
    plain = points.T.tobytes()
    # LZF without a saving: runs of 32 bytes
    packed = b"".join(b"\x1f" + plain[k:k + 32] for k in range(0, len(plain), 32))
    return [header("ascii") + text.encode(), header("binary") + points.tobytes(),
            header("binary_compressed") + struct.pack("<II", len(packed), len(plain)) + packed]


def las_seeds() -> list[bytes]:
    whole = np.rint(shell(80) * 1000).astype("<i4")
    seeds = []
    for minor, kind, size, record in ((2, 3, 227, 34), (4, 7, 375, 36), (0, 0, 227, 20)):
        head = bytearray(size)
        head[:4] = b"LASF"
        head[24:26] = bytes([1, minor])
        struct.pack_into("<HI", head, 94, size, size)
        struct.pack_into("<BHI", head, 104, kind, record, 80)
        struct.pack_into("<6d", head, 131, 0.001, 0.001, 0.001, 8e5, -10, 2)
        if minor == 4:
            struct.pack_into("<Q", head, 247, 80)
        seeds.append(bytes(head) + b"".join(x.tobytes() + bytes(record - 12) for x in whole))
    return seeds


def splat_seeds() -> list[bytes]:
    row = np.array([0.05, 0.05, 0.02], "<f4").tobytes() + bytes([200, 100, 50, 255, 255, 128, 128,
                                                                 128])
    return [b"".join(x.astype("<f4").tobytes() + row for x in shell(60))]


def zstd_stored(values: bytes) -> bytes:
    """A Zstandard frame of one block that is not packed (RFC 8878)."""
    block = (len(values) << 3 | 1).to_bytes(3, "little")
    return struct.pack("<IBI", 0xfd2fb528, 0xa0, len(values)) + block + values


def spz4(degree: int, attributes: list[bytes]) -> bytes:
    """Version 4: header, table of sizes, a stream for each attribute."""
    streams = [zstd_stored(a) for a in attributes]
    table = b"".join(struct.pack("<QQ", len(s), len(a)) for s, a in zip(streams, attributes))
    head = struct.pack("<IIIBBBBI12x", 0x5053474e, 4, len(attributes[1]), degree, 12, 0,
                       len(streams), 32)
    return head + table + b"".join(streams)


def spz_seeds() -> list[bytes]:
    fixed = np.rint(shell(60) * 4096).astype("<i4")
    place = b"".join(v.tobytes()[:3] for v in fixed.ravel())
    rest = bytes([250] * 60) + bytes([128] * 180) + bytes([100] * 180)
    attributes = [place, bytes([250] * 60), bytes([128] * 180), bytes([100] * 180),
                  bytes([128] * 240), bytes([128] * 540)]
    new = [spz4(0, attributes[:5]), spz4(1, attributes)]
    return new + [
        gzip.compress(struct.pack("<IIIBBBB", 0x5053474e, version, 60, degree, 12, 0, 0)
                          + place + rest + bytes([128] * rotation * 60)
                          + bytes([128] * 60 * 3 * ((degree + 1)**2 - 1)), mtime=0)
            for version, degree, rotation in ((2, 0, 3), (3, 1, 4))]


def stream_seed() -> bytes:
    """The box as elastogen-reader answers it (io/asset_stream.cpp)."""
    def array(values: bytes, size: int = 1) -> bytes:
        return struct.pack("<Q", len(values) // size) + values

    def words(*values: int) -> bytes:
        return np.array(values, "<i4").tobytes()

    corners = [v for f in FACES for v in (f[0], f[1], f[2], f[0], f[2], f[3])]
    mesh = (array(b"box") + array(POSITION.tobytes(), 24) + array(words(*range(8)), 4)
            + array(bytes(64), 8) + array(bytes(96), 12) + array(bytes(128), 16)
            + struct.pack("<Q", 1) + words(0) + array(words(*corners), 4))
    node = array(b"node") + words(-1) + np.eye(4).tobytes() + words(0)
    material = array(b"red") + bytes(16) + array(b"a.png")
    finding = array(b"skins") + struct.pack("<q", 1) + array(b"left out")
    one = struct.pack("<Q", 1)
    points = b"\1" + array(bytes(48), 24) + array(bytes(24), 12) + array(bytes(32), 16)
    return (b"elastogen-asset1\0" + words(2) + struct.pack("<d", 0.01) + one + mesh + one + node
            + one + material + points + one + finding)


TOML = b"""pins = ["y<5%", "sphere(0,50%,0, 3cm)"]
gravity = [0, "-981 cm/s2", 0]
[asset]
file = "bunny.obj"
size = "20 cm"
[material]
preset = "jelly"
young = "30 kPa"
[[region]]
select = "y>80%"
preset = "foam"
[[collider]]
shape = "sphere"
centre = [0, "1 m", 0]
radius = "5 cm"
path = [[0, 0, 0, 0], [1, 0, "-10 cm", 0]]
[floor]
place = "-30 cm"
[time]
frames = 60
[output]
files = ["bunny.glb"]
"""
JSON = b"""{"pins": ["y<5%"], "asset": {"file": "bunny.obj", "size": "20 cm"},
"collider": [{"shape": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}],
"material": {"preset": "rubber", "young": 2e6}, "time": {"frames": 60}}
"""
GRAMMAR = [b"\0all", b"\0y<5%", b"\0z >= 0.2m", b"\0box(0,0,0, 50%,1cm,1)",
           b"\0node:ear*", b"\0colour:#ff8000", b"\0attr:w.x>=0.5", b"\0sphere(0,50%,0, 3cm)",
           b"\1plane(0,0%,0, 0,1,0) friction 0.3 name floor", b"\1box(0,0,2, 100%,100%,2.5)",
           b"\1sphere(0,1m,0, 5cm) path 0:0,0,0; 1s:0,-10cm,0", b"\2y>80%: foam",
           b"\2node:ear*: rubber,young=2MPa,poisson=0.4", b"\x041.5 GiB", b"\x0530%", b"\x06-z",
           b"\2material:red: jelly, density=900, law=stvk", b"\x03\x010,-1,2 cm", b"\x03\x053km/h"]


def law_seeds() -> list[bytes]:
    matrices = [np.eye(3), np.diag([2, 1, 0.5]), np.diag([1, 1, -1]), np.zeros((3, 3)),
                np.ones((3, 3)), np.diag([1e20, 1, 1e-20]), np.arange(9).reshape(3, 3) - 4.5]
    return [np.asarray(F, "<f8").tobytes() + bytes([k % 4]) for k, F in enumerate(matrices)]


def tensor_seeds() -> list[bytes]:
    """A text and two tensors, without the seal, which the harness adds."""
    def text(words: bytes) -> bytes:
        return struct.pack("<I", len(words)) + words

    matrix = text(b"matrix") + struct.pack("<IQQ6f", 2, 2, 3, *range(6))
    number = text(b"number") + struct.pack("<If", 0, 7.5)
    return [b"elastogen-tensor" + struct.pack("<II", 1, 1) + text(b"law") + text(b"hencky")
            + struct.pack("<I", 2) + matrix + number]


def voxelize_seeds() -> list[bytes]:
    corners = bytes(b for v in POSITION for x in v
                    for b in int(32768 + 100000 * x).to_bytes(2, "big"))
    triangles = bytes(v for f in FACES for v in (f[0], f[1], f[2], f[0], f[2], f[3]))
    return [bytes([k, 4]) + corners + triangles for k in (0, 2)]


X_FILE = (b"xof 0303txt 0032\nMesh wedge {\n 4;\n 0;0;0;,\n 1;0;0;,\n 0;2;0;,\n 0;0;-3;;\n 4;\n"
          b" 3;0,1,2;,\n 3;0,3,1;,\n 3;0,2,3;,\n 3;1,3,2;;\n}\n")
AC_FILE = (b"AC3Db\nMATERIAL \"red\" rgb 1 0 0  amb 0 0 0  emis 0 0 0  spec 0 0 0  shi 1  trans 0\n"
           b"OBJECT world\nkids 1\nOBJECT poly\nname \"wedge\"\nnumvert 4\n0 0 0\n1 0 0\n0 2 0\n"
           b"0 0 3\nnumsurf 1\nSURF 0x0\nmat 0\nrefs 3\n0 0 0\n2 0 0\n1 0 0\nkids 0\n")


def seeds_of(harness: str) -> list[bytes]:
    """Valid inputs, made here."""
    box = glb_bytes(*glb_parts(POSITION, FACES))
    lines = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in shell(120))
    makers: dict[str, Callable[[], list[bytes]]] = {
        "obj": obj_seeds,
        "ply": ply_seeds,
        "stl": lambda: [written(write_stl, "a.stl", POSITION, FACES, t) for t in (True, False)],
        "off": lambda: [b"OFF\n8 6 0\n" + "".join(
            [f"{x} {y} {z}\n" for x, y, z in POSITION] +
            [" ".join(map(str, [4, *f])) + "\n" for f in FACES]).encode()],
        "gltf": lambda: [box, skinned_glb(), quantized_glb(), draco_glb(), meshopt_glb(), scene_glb()],
        "xyz": lambda: [lines.encode(), b"120\n" + lines.encode()],
        "pcd": pcd_seeds, "las": las_seeds, "splat": splat_seeds, "spz": spz_seeds,
        "assimp": lambda: [b"\3" + X_FILE, b"\4" + AC_FILE],
        "asset_stream": lambda: [stream_seed()], "tets": tet_seeds,
        "scene_toml": lambda: [TOML], "scene_json": lambda: [JSON],
        "grammar": lambda: GRAMMAR, "law": law_seeds, "tensors": tensor_seeds, "voxelize": voxelize_seeds,
    }
    return makers[harness]() if harness in makers else []


def real_seeds(harness: str, folder: Path) -> list[bytes]:
    """The small real files of the harness's formats."""
    endings = REAL.get(harness, {})
    files = [f for f in sorted(folder.rglob("*")) if f.suffix[1:].lower() in endings]
    return [endings[f.suffix[1:].lower()] + f.read_bytes() for f in files
            if f.stat().st_size < MAX_REAL]


def write_seeds(harness: str, folder: Path, assets: str | None) -> int:
    """Fills a folder; returns how many."""
    folder.mkdir(parents=True, exist_ok=True)
    seeds = seeds_of(harness) + (real_seeds(harness, Path(assets)) if assets else [])
    for k, seed in enumerate(seeds):
        (folder / f"seed{k}").write_bytes(seed)
    return len(seeds)


def write_dictionary(harness: str, path: Path) -> bool:
    """The words of a format as libFuzzer reads them; False if it has none."""
    lines = ['"' + w.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\x09") + '"'
             for w in WORDS.get(harness, [])]
    path.write_text("\n".join([*lines, ""]))
    return bool(lines)
