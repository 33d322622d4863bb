# SPDX-License-Identifier: Apache-2.0
"""trimesh: it plays no morph targets, so only the rest frame is looked at."""

from __future__ import annotations

import trimesh

from client_job import Answer, load_job


def main() -> None:
    """Loads the scene, poses each geometry by the scene's graph, answers."""
    job, _ = load_job()
    scene = trimesh.load_scene(job.glb, process=False)
    names = sorted(str(name) for name in scene.graph.nodes_geometry)
    answer = Answer(trimesh.__version__, ["rest frame only", "nodes: " + ", ".join(names)])
    for node in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[node]
        vertices = scene.geometry[geometry].vertices
        answer.show(0, vertices @ matrix[:3, :3].T + matrix[:3, 3])
    answer.save(job)


if __name__ == "__main__":
    main()
