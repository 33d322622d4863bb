# SPDX-License-Identifier: Apache-2.0
"""Checks of an animated GLB against glTF 2.0 and docs/formats.md."""

from __future__ import annotations

from typing import Any

import numpy as np

from glb_file import (CERTIFICATE, TRIANGLES, Document, frame_count, require, world_matrices)


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


def check_primitive(document: Document, primitive: dict[str, Any], place: str) -> None:
    """Attributes and targets of one length, indices in range."""
    require("POSITION" in primitive["attributes"], place, " has no POSITION")
    count = check_positions(document, primitive["attributes"]["POSITION"], None)
    for name, accessor in primitive["attributes"].items():
        found = document.items("accessors")[accessor]["count"]
        require(found == count, f"{place}: {name} has {found} vertices, POSITION {count}")
    for target in primitive.get("targets", []):
        require(set(target) <= {"POSITION", "NORMAL"} and set(target) <= set(
            primitive["attributes"]), f"{place}: a target has {sorted(target)}")
        for accessor in target.values():
            check_positions(document, accessor, count)
            kind = document.items("accessors")[accessor]["componentType"]
            require(kind == 5126, f"{place}: a target is not of floats")
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
            require(targets == len(mesh.get("weights", [])),
                    f"meshes[{m}] has {len(mesh.get('weights', []))} weights, {targets} targets")
        require(not np.any(mesh.get("weights", 0)), f"meshes[{m}] rests with weights that move it")


def check_images(document: Document) -> None:
    """Images and textures point at something, and images are inside the file."""
    for index, image in enumerate(document.items("images")):
        inside = "bufferView" in image and "mimeType" in image
        require(inside or image.get("uri", "").startswith("data:"), f"images[{index}] is outside")
    for index, texture in enumerate(document.items("textures")):
        require(0 <= texture.get("source", 0) < len(document.items("images")),
                f"textures[{index}] has no image")


def check_channel(document: Document, animation: dict[str, Any], channel: dict[str, Any],
                  times: list[float]) -> None:
    """One channel plays the weights of a node without matrix, linearly, at the frames' times."""
    target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
    place = f"the channel of nodes[{target['node']}]"
    require(target["path"] == "weights" and sampler.get("interpolation", "LINEAR") == "LINEAR",
            place, " does not play weights linearly")
    keys = document.raw(sampler["input"])
    require(keys.shape == (len(times), 1) and np.allclose(keys[:, 0], times, rtol=1e-6, atol=0),
            f"{place} does not have the times of the frames")
    accessor = document.items("accessors")[sampler["input"]]
    require("min" in accessor and "max" in accessor, place, ": the times have no bounds")
    node = document.items("nodes")[target["node"]]
    require("matrix" not in node, place, ": the node has a matrix")
    mesh = document.items("meshes")[node["mesh"]]
    require(len(node.get("weights", mesh["weights"])) == len(mesh["weights"]), place,
            ": the node has another number of weights than its mesh")
    played = document.raw(sampler["output"])
    require(played.shape == (len(times) * len(mesh["weights"]), 1) and played.dtype == "<f4",
            f"{place} has {len(played)} values, {len(times)} keys of {len(mesh['weights'])} wanted")
    require(not played[: len(mesh["weights"])].any(), place, ": the rest frame is moved")


def check_record(document: Document) -> list[float]:
    """`asset.extras.elastogen`: every key, a certificate for each frame; returns their times."""
    record = document.json["asset"].get("extras", {}).get("elastogen")
    require(isinstance(record, dict), "asset.extras.elastogen is missing")
    for key in ("generator", "commit", "command", "fps", "profile", "modes", "max_error_m",
                "frames"):
        require(key in record, "asset.extras.elastogen has no ", key)
    require(record["profile"] in ("modal", "keyframe") and record["fps"] > 0,
            "asset.extras.elastogen has no profile or fps")
    if record["profile"] == "modal":
        require(0 <= record["max_error_m"] and record["modes"] <= 64,
                "asset.extras.elastogen: more than 64 modes or no error")
    for t, frame in enumerate(record["frames"]):
        require(set(frame) == set(CERTIFICATE) and isinstance(frame["converged"], bool),
                f"the certificate of frame {t} has {sorted(frame)}")
        finite = all(isinstance(frame[k], (int, float)) for k in ("residual", "min_j"))
        require(finite and frame["residual"] >= 0, f"the certificate of frame {t} is no number")
    require(record["frames"][0]["converged"], "the rest frame is not converged")
    return [t / record["fps"] for t in range(len(record["frames"]))]


def check_animation(document: Document) -> None:
    """All of the above. @throws GlbError naming the first place that is wrong."""
    require(document.json["asset"]["version"] == "2.0", "the version of the document is not 2.0")
    check_views(document)
    check_accessors(document)
    check_meshes(document)
    check_images(document)
    times, shown = check_record(document), world_matrices(document)
    targets = [channel["target"]["node"] for animation in document.items("animations")
               for channel in animation["channels"]]
    require(len(targets) == len(set(targets)), "a node is animated twice")
    require(len(document.items("animations")) <= 1, "there is more than one animation")
    for animation in document.items("animations"):
        for channel in animation["channels"]:
            require(channel["target"]["node"] in shown, "an animated node is not shown")
            check_channel(document, animation, channel, times)
    if frame_count(document) > 1 and document.json["asset"]["extras"]["elastogen"]["modes"] > 0:
        require(bool(targets), "nothing is animated")


def triangle_corners(document: Document, primitive: dict[str, Any]) -> int:
    """Indices, or vertices, of a primitive of triangles; 0 of others."""
    if primitive.get("mode", 4) not in TRIANGLES:
        return 0
    accessor = primitive.get("indices", primitive["attributes"]["POSITION"])
    return document.items("accessors")[accessor]["count"]
