# SPDX-License-Identifier: Apache-2.0
"""Blender, as the module `bpy` or as the program: the GLB by its glTF importer, each frame as the
dependency graph evaluates it."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from client_job import Answer, Values, load_job  # noqa: E402

MODULE = "bpy"


def allow_old_numpy_names() -> None:
    """Debian's Blender 3.4.1 uses `numpy.bool`, which Debian's numpy no longer has."""
    if "bool" not in np.__dict__:
        np.bool = bool  # type: ignore[attr-defined]


def empty_scene(fps: int) -> None:
    """Nothing in the scene; the importer turns seconds into frames by the rate that it finds."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = fps
    bpy.context.scene.render.fps_base = 1.0


def evaluated_positions(name: str) -> Values:
    """(vertices, 3) world positions of an object, z up turned to y up."""
    graph = bpy.context.evaluated_depsgraph_get()
    shown = bpy.data.objects[name].evaluated_get(graph)
    mesh = shown.to_mesh()
    local = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", local)
    matrix = np.array(shown.matrix_world, float)
    world = local.reshape(-1, 3).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
    return world[:, [0, 2, 1]] * [1, 1, -1]


def shown_meshes() -> list[str]:
    """Names of the mesh objects that are not hidden."""
    return [o.name for o in bpy.context.scene.objects if o.type == "MESH" and not o.hide_render]


def curves_of(animation: bpy.types.AnimData | None) -> dict[str, bpy.types.FCurve]:
    """The curves of a datablock by their paths; since 4.4 an action holds several such sets."""
    if not animation or not animation.action:
        return {}
    curves = list(getattr(animation.action, "fcurves", []))
    if hasattr(animation.action, "layers"):
        curves = [curve for layer in animation.action.layers for strip in layer.strips
                  for bag in strip.channelbags
                  if bag.slot_handle == animation.action_slot_handle for curve in bag.fcurves]
    return {curve.data_path: curve for curve in curves}


def clamp_note() -> list[str]:
    """How many keyed values of shape keys lie outside of what Blender lets them be."""
    outside, total = 0, 0
    for keys in bpy.data.shape_keys:
        curves = curves_of(keys.animation_data)
        for block in keys.key_blocks:
            curve = curves.get(f'key_blocks["{block.name}"].value')
            for point in curve.keyframe_points if curve else []:
                total += 1
                outside += not block.slider_min <= point.co[1] <= block.slider_max
    return [f"{outside} of {total} keyed weights are outside of the sliders"] if total else []


def main() -> None:
    """Imports, steps through the frames, answers."""
    job, _ = load_job()
    allow_old_numpy_names()
    empty_scene(job.fps)
    bpy.ops.import_scene.gltf(filepath=job.glb, merge_vertices=False)
    answer = Answer(bpy.app.version_string, clamp_note())
    for frame in job.frames:
        bpy.context.scene.frame_set(frame)
        for name in shown_meshes():
            answer.show(frame, evaluated_positions(name))
    answer.save(job)


if __name__ == "__main__":
    main()
