# SPDX-License-Identifier: Apache-2.0
"""Start to first step and memory of the command on a solid sphere of 20448 triangles that it writes.

usage: startup.py BINARY        prints a Markdown table
"""

import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def write_sphere(path: Path, rings: int = 72, sectors: int = 144) -> None:
    """A sphere of radius 0.5 m as OBJ."""
    with path.open("w") as f:
        for i in range(rings + 1):
            t = math.pi * i / rings
            for j in range(sectors):
                p = 2 * math.pi * j / sectors
                x, y, z = math.sin(t) * math.cos(p), math.cos(t), math.sin(t) * math.sin(p)
                f.write(f"v {x / 2:.9f} {y / 2:.9f} {z / 2:.9f}\n")
        for i in range(rings):
            for j in range(sectors):
                a, b = i * sectors + j + 1, i * sectors + (j + 1) % sectors + 1
                if i > 0:
                    f.write(f"f {a} {b} {a + sectors}\n")
                if i < rings - 1:
                    f.write(f"f {b} {b + sectors} {a + sectors}\n")


def main() -> None:
    print("| material | solver | voxels | read | voxelise | set up | first step | all s | B a voxel |")
    print("|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        mesh, report = Path(folder, "sphere.obj"), Path(folder, "report.json")
        write_sphere(mesh)
        for material, solver, n in (("rubber", "auto", 48), ("jelly", "quasi", 58),
                                    ("rubber", "newton", 58), ("jelly", "quasi", 90)):
            start = time.monotonic()
            subprocess.run([sys.argv[1], "animate", mesh, "--material", material, "--solver", solver,
                            "--voxels", str(n), "--pin", "y<5%", "--frames", "1", "--fps", "60",
                            "--substeps", "1", "--quiet", "--report", report,
                            "-o", Path(folder, "out.glb")], check=True)
            seconds = time.monotonic() - start
            r = json.loads(report.read_text())
            s = r["stage_seconds"]
            print(f"| {material} | {solver} | {r['voxels']} | {s['read']:.2f} | {s['voxelize']:.2f} | "
                  f"{s['setup']:.2f} | {s['steps']:.2f} | {seconds:.2f} | "
                  f"{r['peak_memory_bytes'] / r['voxels']:.0f} |", flush=True)


main()
