# SPDX-License-Identifier: Apache-2.0
"""Filament (gltfio), through `filly`: it shows no positions, so pictures of the animated GLB are
compared with those of GLBs baked in the same poses."""

from __future__ import annotations

import filly
import numpy as np
from PIL import Image

import pictures
from client_job import Answer, Job, load_job


def add_lights(scene: filly.Scene, centre: list[float], radius: float) -> None:
    """Light of another colour from each side, so that every normal shows."""
    for axis in range(3):
        for sign in (-1.0, 1.0):
            position = np.array(centre) + 4 * radius * sign * np.eye(3)[axis]
            colour = np.full(3, 0.3) + 0.7 * (np.eye(3)[axis] if sign > 0 else 1 - np.eye(3)[axis])
            scene.add_point_light(position=position.tolist(), color=colour.tolist(),
                                  intensity=2e6 * radius**2, range=20 * radius)


def picture(renderer: filly.Renderer, job: Job, path: str,
            frame: int | None) -> pictures.Pixels:
    """The file at a frame; None: as it stands."""
    scene = renderer.create_scene()
    scene.background = [0.0, 0.0, 0.0, 1.0]
    model = scene.load(path)
    if frame is not None:
        for index in range(len(model.animations)):
            model.apply_animation(index, job.seconds(frame), loop=False)
    centre, radius = job.bounds[:3], job.bounds[3]
    add_lights(scene, centre, radius)
    camera = renderer.create_camera()
    camera.position = pictures.camera_position(centre, radius)
    camera.set_perspective(fov_y_deg=pictures.VIEW_DEGREES, near=0.1 * radius, far=20 * radius)
    camera.look_at(centre)
    scene.camera = camera
    target = renderer.create_render_target(width=pictures.SIZE, height=pictures.SIZE)
    renderer.render(scene, target)
    result = np.array(target.read())[:, :, :3]
    scene.close()
    return result


def main() -> None:
    """Draws both at each frame and answers."""
    job, _ = load_job()
    answer = Answer(f"filly {filly.__version__}")
    with filly.Renderer() as renderer:
        for frame in job.frames:
            pair = [picture(renderer, job, job.glb, frame),
                    picture(renderer, job, job.baked[str(frame)], None)]
            answer.pictures[str(frame)] = pictures.difference(*pair)
            Image.fromarray(np.hstack(pair)).save(f"{job.folder}/{frame}.png")
    answer.save(job)


if __name__ == "__main__":
    main()
