# SPDX-License-Identifier: Apache-2.0
"""What an animated GLB must keep of its source: vertices and their order, UVs, materials, names."""

from __future__ import annotations

import json
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glb_check import triangle_corners
from glb_file import Document, local_positions, read_document, require
from source_mesh import READERS, SourceMesh

MATERIAL_LISTS = ("materials", "textures", "samplers")
SKIN = ("JOINTS_", "WEIGHTS_")
PACKED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}
RESOLVED = PACKED | {"KHR_mesh_quantization"}


def packed_glb(source: Path) -> Document | None:
    """A GLB file whose vertices are packed or skinned, with its first buffer; None for others."""
    data = source.read_bytes()
    if data[:4] != b"glTF":
        return None
    end = 20 + struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:end])
    packed = PACKED & set(document.get("extensionsUsed", [])) or "skins" in document
    return Document(document, [data[end + 8 :]]) if packed else None


def shown_nodes(document: Document) -> list[dict[str, Any]]:
    """Nodes with a mesh."""
    return [node for node in document.items("nodes") if "mesh" in node]


def file_positions(source: SourceMesh, document: Document) -> NDArray[np.float64]:
    """The file's positions in the numbers of its mesh."""
    nodes = shown_nodes(document)
    require(len(nodes) > 0, "no node shows a mesh")
    shift = np.array(nodes[0].get("translation", [0.0, 0.0, 0.0]))
    require(len(nodes) == 1 or not shift.any(), "one of several meshes is moved")
    return (source.position - shift).astype(np.float32).astype(float)


def check_parts(wanted: NDArray[np.float64], document: Document) -> None:
    """Several meshes of one file have its vertices and no others."""
    known = {tuple(x) for x in wanted}
    found = {tuple(x) for rest in local_positions(document, 0).values() for x in rest}
    require(found == known, f"{len(found - known)} vertices are new, {len(known - found)} missing")


def check_vertices(source: SourceMesh, document: Document) -> None:
    """The first vertices are the file's in its order; the rest frame is them to the last bit.

    A mesh far from the origin stands at a node that is moved; then its positions are the file's up
    to single precision of the mesh's own size.
    """
    wanted = file_positions(source, document)
    if len(shown_nodes(document)) > 1:
        return check_parts(wanted, document)
    for key, rest in local_positions(document, 0).items():
        require(len(rest) >= len(wanted), f"{key}: {len(rest)} vertices of {len(wanted)}")
        require((rest[: len(wanted)] == wanted).all(), f"{key}: vertices differ from the file's")
        known = {tuple(x) for x in wanted}
        require(all(tuple(x) in known for x in rest[len(wanted):]), f"{key}: a vertex is new")
        require(source.uv is not None or len(rest) == len(wanted) or bool(source.material),
                f"{key}: {len(rest)} vertices, the file has {len(wanted)}")


def check_uvs(source: SourceMesh, document: Document) -> None:
    """The pairs of place and uv that triangles use are the file's."""
    primitives = [p for mesh in document.items("meshes") for p in mesh["primitives"]]
    if source.uv is None:
        require(all("TEXCOORD_0" not in p["attributes"] for p in primitives), "UVs are new")
        return
    rows = []
    for p in primitives:
        require("TEXCOORD_0" in p["attributes"], "a primitive has no UVs")
        corner = np.unique(document.raw(p["indices"]))
        rows.append(np.hstack([document.values(p["attributes"]["POSITION"])[corner],
                               document.values(p["attributes"]["TEXCOORD_0"])[corner]]))
    found = np.unique(np.vstack(rows), axis=0)
    pairs = source.uvs()
    x = file_positions(source, document)[pairs[:, 0].astype(int)]
    wanted = np.unique(np.hstack([x, pairs[:, 1:]]), axis=0)
    require(found.shape == wanted.shape and (found == wanted).all(),
            f"{len(found)} pairs of place and uv, the file has {len(wanted)}, or they differ")


def check_materials(source: SourceMesh, document: Document) -> None:
    """As many triangles of each material as the file's faces have."""
    names, found = [m.get("name", "") for m in document.items("materials")], Counter[str]()
    for mesh in document.items("meshes"):
        for p in mesh["primitives"]:
            found[names[p["material"]]] += triangle_corners(document, p) // 3
    require(found == source.triangles(), f"triangles of materials {found}, the file has "
            f"{source.triangles()}")


def check_kept_lists(source: Document, document: Document) -> None:
    """Of any glTF source: materials, images, names and transforms stand where they stood."""
    for name in MATERIAL_LISTS:
        before, after = source.items(name), document.items(name)
        # a default material may be added, as a primitive without one has it anyway
        added = [{}] if name == "materials" and len(after) > len(before) else []
        require([*before, *added] == after, name, " differ from the source's")
    for k, image in enumerate(source.items("images")):
        if "bufferView" in image:
            view = document.items("images")[k]["bufferView"]
            require(source.view(image["bufferView"]) == document.view(view), f"images[{k}] differ")
    for k, node in enumerate(source.items("nodes")):
        kept: dict[str, Any] = document.items("nodes")[k]
        for key in ("name", "matrix", "translation", "rotation", "scale"):
            require(node.get(key) == kept.get(key), f"nodes[{k}].{key} differs")
    for k, mesh in enumerate(source.items("meshes")):
        kept = document.items("meshes")[k]
        require(mesh.get("name") == kept.get("name"), f"meshes[{k}].name differs")
        for p, primitive in enumerate(mesh["primitives"]):
            other = kept["primitives"][p]
            default = (len(source.items("materials")),)
            require(other.get("material") == primitive.get("material")
                    or "material" not in primitive and other["material"] in default,
                    f"meshes[{k}].primitives[{p}].material differs")
            names = {a for a in primitive["attributes"] if not a.startswith(SKIN)}
            if "targets" in other:
                names.discard("TANGENT")  # it would stay behind
            require(names == set(other["attributes"]),
                    f"meshes[{k}].primitives[{p}] has {sorted(other['attributes'])}")


def check_kept_document(source: Document, document: Document) -> None:
    """A glTF source whose vertices are there to read: its accessors and primitives too."""
    check_kept_lists(source, document)
    for k, accessor in enumerate(source.items("accessors")):
        same = accessor["componentType"] == document.items("accessors")[k]["componentType"]
        before = source.raw(k) if same else source.values(k).astype(np.float32)
        require(np.array_equal(before, document.raw(k)), f"accessors[{k}] differ")
    for k, mesh in enumerate(source.items("meshes")):
        for p, primitive in enumerate(mesh["primitives"]):
            other = document.items("meshes")[k]["primitives"][p]
            primitive = {**primitive, "attributes": dict(primitive["attributes"])}
            if "targets" in other:
                primitive["attributes"].pop("TANGENT", None)
            normal = primitive["attributes"].get("NORMAL")
            if normal is not None and (abs(np.linalg.norm(source.values(normal), axis=1) - 1)
                                       > 5e-4).any():  # it got the length one
                primitive["attributes"]["NORMAL"] = other["attributes"]["NORMAL"]
            for key in ("attributes", "indices", "mode"):
                require(primitive.get(key) == other.get(key),
                        f"meshes[{k}].primitives[{p}].{key} differs")


def check_plain(document: Document) -> None:
    """Nothing of what had to be resolved is left."""
    require("skins" not in document.json and not any(
        "skin" in node for node in document.items("nodes")), "a skin is left")
    used = {*document.items("extensionsUsed"), *document.items("extensionsRequired")}
    require(not used & RESOLVED, f"{sorted(used & RESOLVED)} are left")


def check_kept(source: Path, document: Document) -> None:
    """All of it. @throws GlbError naming the first difference."""
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        check_plain(document)
        if source.suffix.lower() not in (".glb", ".gltf"):
            return  # there is no second reader of these formats here
        if (packed := packed_glb(source)) is not None:
            check_kept_lists(packed, document)
            return
        check_kept_document(read_document(source), document)
        before, rest = local_positions(read_document(source), 0), local_positions(document, 0)
        found = sorted((x.shape, x.tobytes()) for x in rest.values())
        require(found == sorted((x.shape, x.tobytes()) for x in before.values()),
                "the rest frame is not the source's")
        return
    mesh = reader(source)
    check_vertices(mesh, document)
    check_uvs(mesh, document)
    check_materials(mesh, document)
