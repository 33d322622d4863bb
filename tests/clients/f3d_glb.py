# SPDX-License-Identifier: Apache-2.0
"""F3D, which draws by vtkGLTFImporter: pictures as in filament_glb.py."""

from __future__ import annotations

from pathlib import Path

import f3d
import numpy as np

import pictures
from client_job import Answer, Job, load_job


def make_engine() -> f3d.Engine:
    """Without a window, plain background, nothing of its own in the picture."""
    engine = f3d.Engine.create(True)
    engine.window.size = (pictures.SIZE, pictures.SIZE)
    engine.options.update({
        "render.background.color": [0.0, 0.0, 0.0], "render.grid.enable": False, "ui.axis": False,
        "ui.loader_progress": False, "render.hdri.ambient": False})
    return engine


def picture(job: Job, path: str, frame: int | None) -> pictures.Pixels:
    """The file at a frame; None: as it stands."""
    engine = make_engine()
    engine.scene.add(path)
    if frame is not None:
        engine.scene.animation.load_time(job.seconds(frame))
    centre, radius = job.bounds[:3], job.bounds[3]
    camera = engine.window.camera
    camera.position = pictures.camera_position(centre, radius)
    camera.focal_point = centre
    camera.view_up = [0.0, 1.0, 0.0]
    camera.view_angle = pictures.VIEW_DEGREES
    image = engine.window.render_to_image()
    image.save(f"{job.folder}/{Path(path).stem}.{'baked' if frame is None else frame}.png")
    pixels = np.frombuffer(image.content, np.uint8)
    return pixels.reshape(image.height, image.width, -1)[::-1, :, :3]


def main() -> None:
    """Draws both at each frame and answers."""
    job, _ = load_job()
    f3d.Log.set_verbose_level(f3d.Log.VerboseLevel.ERROR)
    answer = Answer(f3d.Engine.get_lib_info().version)
    for frame in job.frames:
        answer.pictures[str(frame)] = pictures.difference(
            picture(job, job.glb, frame), picture(job, job.baked[str(frame)], None))
    answer.save(job)


if __name__ == "__main__":
    main()
