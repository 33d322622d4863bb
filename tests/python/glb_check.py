# SPDX-License-Identifier: Apache-2.0
"""Checks of an animated GLB against glTF 2.0 and docs/formats.md."""

from __future__ import annotations

from typing import Any

import numpy as np

import gltf_rules
from glb_file import (ANIMATION, CERTIFICATE, ESTIMATES, TRIANGLES, Document, channels, frame_count, record, require,
                      world_matrices)


def check_views(document: Document) -> None:
    """Every buffer view lies in its buffer and has a stride that is allowed."""
    for index, view in enumerate(document.items("bufferViews")):
        document.view(index)
        stride = view.get("byteStride", 4)
        require(4 <= stride <= 252 and stride % 4 == 0, f"bufferViews[{index}] has stride {stride}")


def check_accessors(document: Document) -> None:
    """Every accessor lies in its view, is finite, and has the bounds that it states."""
    for index, accessor in enumerate(document.items("accessors")):
        values, place = document.raw(index), f"accessors[{index}]"
        require(np.isfinite(values).all(), place, " has values that are not finite")
        for name, found in (("min", values.min(0)), ("max", values.max(0))):
            if name in accessor:
                stated = np.array(accessor[name]).astype(values.dtype)
                require(stated.shape == found.shape and (stated == found).all(),
                        f"{place}: {name} is {found}, stated is {stated}")


def check_positions(document: Document, accessor: int, count: int | None) -> int:
    """Positions, or their targets: three floats a vertex with bounds; returns their number."""
    a, place = document.items("accessors")[accessor], f"accessors[{accessor}]"
    require(a["type"] == "VEC3" and "min" in a and "max" in a, place, " is no POSITION")
    require(count in (None, a["count"]), f"{place} has {a['count']} vertices, not {count}")
    return a["count"]


def check_target(document: Document, primitive: dict[str, Any], target: dict[str, int], count: int,
                 place: str) -> None:
    """Attributes of the primitive, as many."""
    names = set(primitive["attributes"])
    require(bool(target) and set(target) <= names, f"{place}: a target has {sorted(target)}")
    for accessor in target.values():
        check_positions(document, accessor, count)


def check_played_targets(document: Document, mesh: dict[str, Any], place: str) -> None:
    """Targets that we wrote: positions and normals in floats, a weight of 0 for each at rest."""
    require(not np.any(mesh["weights"]), place, " rests with weights that move it")
    for primitive in mesh["primitives"]:
        require("TANGENT" not in primitive["attributes"], place, " moves, its tangents do not")
        for target in primitive.get("targets", []):
            require(set(target) <= {"POSITION", "NORMAL"},
                    f"{place}: a target has {sorted(target)}")
            kinds = {document.items("accessors")[a]["componentType"] for a in target.values()}
            require(kinds == {5126}, f"{place}: a target is not of floats")


def check_primitive(document: Document, primitive: dict[str, Any], place: str) -> None:
    """Attributes and targets of one length, indices in range."""
    require("POSITION" in primitive["attributes"], place, " has no POSITION")
    count = check_positions(document, primitive["attributes"]["POSITION"], None)
    for name, accessor in primitive["attributes"].items():
        found = document.items("accessors")[accessor]["count"]
        require(found == count, f"{place}: {name} has {found} vertices, POSITION {count}")
    for target in primitive.get("targets", []):
        check_target(document, primitive, target, count, place)
    if "indices" in primitive:
        indices = document.raw(primitive["indices"])
        require(indices.dtype.kind == "u" and indices.max() < count,
                f"{place}: an index is out of range")
        count = len(indices)
    if primitive.get("mode", 4) == 4:
        require(count % 3 == 0, f"{place}: {count} corners are no triangles")
    material = primitive.get("material", 0)
    require(0 <= material < max(1, len(document.items("materials"))),
            f"{place}: there is no material {material}")


def check_meshes(document: Document) -> None:
    """Every primitive; primitives of a mesh have as many targets as the mesh has weights."""
    for m, mesh in enumerate(document.items("meshes")):
        for p, primitive in enumerate(mesh["primitives"]):
            check_primitive(document, primitive, f"meshes[{m}].primitives[{p}]")
            targets = len(primitive.get("targets", []))
            weights = len(mesh.get("weights", [0] * targets))
            require(targets == weights, f"meshes[{m}] has {weights} weights, {targets} targets")


def check_images(document: Document) -> None:
    """Images and textures point at something, and images are inside the file."""
    for index, image in enumerate(document.items("images")):
        inside = "bufferView" in image and "mimeType" in image
        require(inside or image.get("uri", "").startswith("data:"), f"images[{index}] is outside")
    for index, texture in enumerate(document.items("textures")):
        require(0 <= texture.get("source", 0) < len(document.items("images")),
                f"textures[{index}] has no image")


def check_weights(document: Document, node: int, sampler: dict[str, Any],
                  times: list[float]) -> None:
    """Weights of a node without matrix, linear, at times of frames that follow each other."""
    place = f"the weights of nodes[{node}]"
    require(sampler.get("interpolation", "LINEAR") == "LINEAR", place, " are not linear")
    keys = document.raw(sampler["input"])[:, 0]
    first = int(np.abs(np.array(times) - keys[0]).argmin())
    known = times[first : first + len(keys)]
    require(len(known) == len(keys) and np.allclose(keys, known, rtol=1e-6, atol=0), place,
            " do not have the times of frames")
    accessor = document.items("accessors")[sampler["input"]]
    require("min" in accessor and "max" in accessor, place, ": the times have no bounds")
    shown = document.items("nodes")[node]
    require("matrix" not in shown, place, ": the node has a matrix")
    mesh = document.items("meshes")[shown["mesh"]]
    require(shown.get("weights", mesh["weights"]) == mesh["weights"], place,
            " are at rest not those of the mesh")
    played = document.raw(sampler["output"])
    require(played.shape == (len(keys) * len(mesh["weights"]), 1) and played.dtype == "<f4",
            f"{place}: {len(played)} values, {len(keys)} keys of {len(mesh['weights'])} wanted")
    require(played.min() >= 0 and played.max() <= 1, place, " leave 0 ... 1")
    require(first > 0 or not played[: len(mesh["weights"])].any(), place,
            ": the rest frame is moved")


def nodes_below(document: Document, node: int) -> set[int]:
    """Children of a node, their children and so on."""
    children = document.items("nodes")[node].get("children", [])
    return set(children).union(*(nodes_below(document, child) for child in children))


def check_clients(document: Document, most: int) -> None:
    """What programs need that the format does not ask for (docs/formats.md)."""
    nodes, taken = document.items("nodes"), set()
    for node, path, sampler in channels(document):
        if path == "scale":
            scale = document.raw(sampler["output"])
            require(sampler.get("interpolation") == "STEP" and np.isin(scale, (0, 1)).all(),
                    f"the scale of nodes[{node}] is no switch")
            continue
        if path == "translation":
            continue  # a collider that moves
        require(path == "weights", f"{path} of nodes[{node}] is animated")
        mesh = document.items("meshes")[nodes[node]["mesh"]]
        require(nodes[node]["mesh"] not in taken, f"nodes[{node}] shares an animated mesh")
        taken.add(nodes[node]["mesh"])
        require(not any("mesh" in nodes[n] for n in nodes_below(document, node)),
                f"nodes[{node}] has meshes below it")
        check_played_targets(document, mesh, f"meshes[{nodes[node]['mesh']}]")
        targets = len(mesh["weights"])
        require(targets <= most, f"nodes[{node}] has {targets} targets, not {most} at most")
        extras = mesh.get("extras", {})
        require(not isinstance(extras, dict) or len(extras.get("targetNames", [])) == targets,
                f"nodes[{node}] has {targets} targets and other names")


def check_record(document: Document) -> list[float]:
    """`asset.extras.elastogen`: every key, a certificate for each frame; returns their times."""
    said = record(document)
    require(bool(said), "asset.extras.elastogen is missing")
    for key in ("generator", "commit", "command", "fps", "profile", "targets", "pieces",
                "max_error_m", "normal_error_deg", "frames"):
        require(key in said, "asset.extras.elastogen has no ", key)
    require(said["profile"] in ("modal", "keyframe") and said["fps"] > 0,
            "asset.extras.elastogen has no profile or fps")
    if said["profile"] == "modal":
        require(0 <= said["max_error_m"] and said["tolerance_m"] > 0,
                "asset.extras.elastogen states no error")
    for t, frame in enumerate(said["frames"]):
        known = set(CERTIFICATE) <= set(frame) <= {*CERTIFICATE, *ESTIMATES}
        require(known and isinstance(frame["converged"], bool),
                f"the certificate of frame {t} has {sorted(frame)}")
        finite = all(isinstance(frame[k], (int, float)) for k in frame)
        require(finite and frame["residual"] >= 0, f"the certificate of frame {t} is no number")
    require(said["frames"][0]["converged"], "the rest frame is not converged")
    return [t / said["fps"] for t in range(len(said["frames"]))]


def check_other_animations(document: Document) -> None:
    """Ours is the first one; the others move no node with a mesh of ours, nor one above it."""
    others = [a for a in document.items("animations") if a.get("name") != ANIMATION]
    require(document.items("animations")[-len(others):] == others or not others,
            "our animation is not the first one")
    ours = {node for node, path, _ in channels(document) if path == "weights"}
    for animation in others:
        for channel in animation["channels"]:
            node = channel["target"].get("node", -1)
            require(-1 <= node < len(document.items("nodes")), "an animated node is not there")
            require(node not in ours, f"nodes[{node}] is moved by two animations")
            require(node < 0 or not ours & nodes_below(document, node),
                    f"a body hangs below nodes[{node}], which moves")
            sampler = animation["samplers"][channel["sampler"]]
            keys, rows = len(document.raw(sampler["input"])), len(document.raw(sampler["output"]))
            require(keys > 0 and rows % keys == 0, "an animation has no row for each key")


def check_animation(document: Document, most: int = 64) -> None:
    """All of the above. @throws GlbError naming the first place that is wrong."""
    require(document.json["asset"]["version"] == "2.0", "the version of the document is not 2.0")
    check_views(document)
    check_accessors(document)
    check_meshes(document)
    check_images(document)
    gltf_rules.check_rules(document)
    times, shown = check_record(document), world_matrices(document)
    found = channels(document)
    targets = [(node, path) for node, path, _ in found]
    require(len(targets) == len(set(targets)), "a node is animated twice")
    check_other_animations(document)
    for node, path, sampler in found:
        require(node in shown, "an animated node is not shown")
        if path == "weights":
            check_weights(document, node, sampler, times)
    check_clients(document, most)
    require(not found or record(document)["targets"] > 0, "the record states no target")
    if frame_count(document) > 1 and record(document)["targets"] > 0:
        require(bool(targets), "nothing is animated")


def triangle_corners(document: Document, primitive: dict[str, Any]) -> int:
    """Indices, or vertices, of a primitive of triangles; 0 of others."""
    if primitive.get("mode", 4) not in TRIANGLES:
        return 0
    accessor = primitive.get("indices", primitive["attributes"]["POSITION"])
    return document.items("accessors")[accessor]["count"]
