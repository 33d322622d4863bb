# SPDX-License-Identifier: Apache-2.0
"""Blender: the point cache by the Mesh Cache modifier on the imported OBJ."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from blender_glb import empty_scene, evaluated_positions, shown_meshes  # noqa: E402
from client_job import Answer, load_job  # noqa: E402


def add_cache(name: str, path: str) -> None:
    """The modifier as its menu makes it, with the file's first frame at frame 0."""
    modifier = bpy.data.objects[name].modifiers.new("cache", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = path
    modifier.frame_start = 0


def main() -> None:
    """Imports, adds the modifier, steps through the frames, answers."""
    job, _ = load_job()
    empty_scene(job.fps)
    bpy.ops.wm.obj_import(filepath=job.source)  # by default y up, -z forward
    answer = Answer(bpy.app.version_string)
    for name in shown_meshes():
        add_cache(name, job.pc2)
    for frame in job.frames:
        bpy.context.scene.frame_set(frame)
        for name in shown_meshes():
            answer.show(frame, evaluated_positions(name))
    answer.save(job)


if __name__ == "__main__":
    main()
