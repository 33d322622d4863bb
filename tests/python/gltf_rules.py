# SPDX-License-Identifier: Apache-2.0
"""Rules of the glTF validator that concern what is written: what the schema cannot say."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from glb_file import Document, require

UNIT = 5e-3  # of normals and tangents: files come with the noise of their compression


def texture_places(value: Any) -> Iterator[dict[str, Any]]:
    """Every texture info of a material, those of its extensions too."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key.endswith("Texture") and isinstance(inner, dict) and "index" in inner:
                yield inner
            yield from texture_places(inner)


def check_textures(document: Document) -> None:
    """Primitives have the coordinates that the textures of their materials take."""
    materials, textures = document.items("materials"), document.items("textures")
    for m, mesh in enumerate(document.items("meshes")):
        for p, primitive in enumerate(mesh["primitives"]):
            if "material" not in primitive:
                continue
            for info in texture_places(materials[primitive["material"]]):
                place = f"meshes[{m}].primitives[{p}]"
                require(0 <= info["index"] < len(textures), place, ": its texture is not there")
                transform = info.get("extensions", {}).get("KHR_texture_transform", {})
                name = f"TEXCOORD_{transform.get('texCoord', info.get('texCoord', 0))}"
                require(name in primitive["attributes"], place, f" has a texture and no {name}")


def check_vectors(document: Document) -> None:
    """Normals and tangents have the length one, tangents a sign; normals stand across tangents."""
    for m, mesh in enumerate(document.items("meshes")):
        for p, primitive in enumerate(mesh["primitives"]):
            place, attributes = f"meshes[{m}].primitives[{p}]", primitive["attributes"]
            if "NORMAL" in attributes:
                length = np.linalg.norm(document.values(attributes["NORMAL"]), axis=1)
                require((np.abs(length - 1) < UNIT).all(), place,
                        f": a normal has the length {length[np.abs(length - 1).argmax()]}")
            if "TANGENT" in attributes:
                tangent = document.values(attributes["TANGENT"])
                require("NORMAL" in attributes, place, " has tangents and no normals")
                require(tangent.shape[1] == 4 and (np.abs(tangent[:, 3]) == 1).all(), place,
                        ": a tangent has no sign")
            sets = [name for name in attributes if name.startswith("TEXCOORD_")]
            require(set(sets) == {f"TEXCOORD_{k}" for k in range(len(sets))}, place,
                    f": sets of coordinates are not counted from 0: {sets}")


def check_samplers(document: Document) -> None:
    """Times ascend from 0 on and have bounds; outputs have a row for each key and target."""
    for a, animation in enumerate(document.items("animations")):
        place = f"animations[{a}]"
        require(bool(animation["channels"]) and bool(animation["samplers"]), place, " is empty")
        targets = [(c["target"].get("node"), c["target"]["path"]) for c in animation["channels"]
                   if "node" in c["target"]]
        require(len(targets) == len(set(targets)), place, " moves something twice")
        for s, sampler in enumerate(animation["samplers"]):
            accessor = document.items("accessors")[sampler["input"]]
            times = document.raw(sampler["input"])[:, 0]
            require(accessor["type"] == "SCALAR" and accessor["componentType"] == 5126
                    and "min" in accessor and "max" in accessor, place, f".samplers[{s}] has no times")
            require(times[0] >= 0 and (np.diff(times) > 0).all(), place,
                    f".samplers[{s}]: its times do not ascend")


def check_extensions(document: Document) -> None:
    """What is used is named, and what is required is used."""
    used: set[str] = set()

    def walk(value: Any) -> None:
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            if key == "extensions" and isinstance(inner, dict):
                used.update(inner)
            if isinstance(inner, (dict, list)) and key != "extras":
                walk(inner)

    walk(document.json)
    named = set(document.items("extensionsUsed"))
    require(used <= named, f"extensionsUsed does not name {sorted(used - named)}")
    require(set(document.items("extensionsRequired")) <= named, "extensionsRequired has others")


def check_rules(document: Document) -> None:
    """All of the above. @throws GlbError naming the first place that is wrong."""
    check_textures(document)
    check_vectors(document)
    check_samplers(document)
    check_extensions(document)
    for n, node in enumerate(document.items("nodes")):
        require("matrix" not in node or not {"translation", "rotation", "scale"} & set(node),
                f"nodes[{n}] has a matrix and its parts")
        rotation = np.linalg.norm(node.get("rotation", [0, 0, 0, 1]))
        require(abs(rotation - 1) < UNIT, f"nodes[{n}] has a rotation of length {rotation}")
    for s, scene in enumerate(document.items("scenes")):
        nodes = scene.get("nodes", [0])
        require(len(nodes) == len(set(nodes)) and bool(nodes), f"scenes[{s}] names a node twice")
