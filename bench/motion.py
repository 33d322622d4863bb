#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How right the motion is at defaults: the command against itself at 64 steps of SDIRK2 a frame.

    bench/motion.py COMMAND [--assets FOLDER] [--scenes NAME ...] [--steps 64] [--json FILE]

For each scene: rms error of the vertices over their motion from the start, at the end of the run and
the largest of all frames; the largest time error that the run says, in all, over the true one; solves a frame;
the rise of the energy over the largest kinetic one. Scenes with assets are left out where the folder
lacks them."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Scene = tuple[str, list[str]]  # an asset of the folder or "", options

BALL, BLOCK = "sphere(0,0,0, 0.1)", "box(0,0,0, 0.25,0.2,0.3)"
SCENES: dict[str, Scene] = {
    "ball drops 1 m": ("", ["--shape", BALL, "--h", "25mm", "--young", "0.5MPa", "--poisson", "0.4",
                            "--floor", "y=-1.1", "--frames", "30"]),
    "block lands on an edge": ("", ["--shape", BLOCK, "--h", "5cm", "--material", "foam", "--floor",
                                    "y=-0.5", "--spin", "0,0,2", "--frames", "30"]),
    "two blocks fall, one farther": ("two.obj", ["--h", "5cm", "--material", "soft-rubber", "--floor", "y=-0.3",
                                                 "--spin", "0,0,0.5", "--frames", "30"]),
    "block hit by a moving ball": ("", ["--shape", BLOCK, "--h", "5cm", "--material", "jelly", "--floor", "y=0",
                                        "--collider", "sphere(-0.3,0.1,0.15, 0.08) path 0:0,0,0; 0.5:0.35,0,0",
                                        "--frames", "24"]),
    "cow at 24 frames a second": ("closed/spot.obj", ["--size", "30cm", "--voxels", "14", "--material", "jelly",
                                                      "--floor", "y=-0.3", "--fps", "24", "--frames", "20"]),
    "bunny held by its feet": ("closed/bunny.obj", ["--size", "30cm", "--voxels", "14", "--material", "soft-rubber",
                                                    "--pin", "y<8%", "--spin", "0,0,3", "--frames", "30"]),
    "cactus swings at 60": ("closed/cactus.off", ["--size", "40cm", "--voxels", "20", "--material", "flesh",
                                                  "--pin", "z<5%", "--up", "z", "--velocity", "1,0,0",
                                                  "--fps", "60", "--frames", "40"]),
    "koala falls on its back": ("closed/koala.obj", ["--size", "25cm", "--voxels", "14", "--material", "plush",
                                                     "--floor", "y=-0.2", "--spin", "2,0,0", "--frames", "24"]),
    "wingnut spins": ("closed/wingnut.obj", ["--size", "10cm", "--voxels", "20", "--spin", "3,10,0", "--gravity",
                                             "0,0,0", "--frames", "40"]),
    "sword falls flat": ("closed/sword.obj", ["--size", "50cm", "--voxels", "30", "--material", "leather", "--floor",
                                              "y=-0.3", "--frames", "20"]),
}


def write_two_blocks(path: Path) -> None:
    """Two boxes, one to the side of and above the other."""
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    text = ""
    for k, (x, y) in enumerate(((0, 0), (0.6, 0.4))):
        text += "".join(f"v {x + 0.25 * (c & 1)} {y + 0.2 * (c >> 1 & 1)} {0.3 * (c >> 2)}\n" for c in range(8))
        text += "".join("f " + " ".join(str(1 + 8 * k + c) for c in reversed(quad)) + "\n" for quad in quads)
    path.write_text(text)


def vertices(path: Path) -> Floats:
    """Positions of a PLY file as the command writes it, (vertices, 3) [m]."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    first = next(k for k, line in enumerate(lines) if line[:2] == ["element", "vertex"])
    count = int(lines[first][2])
    types = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4", "uint": "u4", "ushort": "u2"}
    fields = []
    for line in lines[first + 1:]:
        if line[0] != "property" or line[1] == "list":
            break
        fields.append((line[2], "<" + types[line[1]]))
    table = np.frombuffer(body, np.dtype(fields), count)
    return np.stack([table[axis] for axis in "xyz"], 1).astype(np.float64)


def play(command: str, source: list[str], folder: Path, *more: str) -> tuple[list[Floats], list[dict[str, Any]]]:
    """Vertices of each frame, and the log."""
    folder.mkdir()
    subprocess.run([command, "animate", *source, *more, "--quiet", "-o", folder / "x.ply",
                    "--log-json", folder / "log"], check=False, stdout=subprocess.DEVNULL)
    frames = [vertices(path) for path in sorted(folder.glob("x_*.ply"))]
    return frames, [json.loads(line) for line in (folder / "log").read_text().splitlines()]


def measure(command: str, source: list[str], folder: Path, steps: int) -> dict[str, float]:
    """The numbers of one scene."""
    run, log = play(command, source, folder / "auto")
    fine, _ = play(command, source, folder / "fine", "--time-scheme", "sdirk2", "--substeps", str(steps))
    rms = [float(np.sqrt(((a - b) ** 2).sum(1).mean())) for a, b in zip(run, fine)]
    motion = max(float(np.sqrt(((b - fine[0]) ** 2).sum(1).mean())) for b in fine)
    energies = [sum(step["energies"].values()) for step in log]
    rise = max(now - min(energies[:k + 1]) for k, now in enumerate(energies))
    kinetic = max(step["energies"]["kinetic"] for step in log)
    return {"error_at_the_end_percent": 100 * rms[-1] / motion, "largest_error_percent": 100 * max(rms) / motion,
            "said_over_true": sum(step["time_error"] for step in log) / max(max(rms), 1e-300),
            "solves_a_frame": sum(step["solves"] for step in log) / (len(run) - 1),
            "rejected": sum(step["rejected"] for step in log),
            "energy_rise_percent": 100 * rise / kinetic, "min_j": min(step["min_j"] for step in log)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command")
    parser.add_argument("--assets", type=Path)
    parser.add_argument("--scenes", nargs="*", default=list(SCENES))
    parser.add_argument("--steps", type=int, default=64)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    results = {}
    for name in arguments.scenes:
        asset, options = SCENES[name]
        with tempfile.TemporaryDirectory() as folder:
            write_two_blocks(Path(folder) / "two.obj")
            places = [parent / asset for parent in (Path(folder), arguments.assets) if parent]
            source = [str(place) for place in places if asset and place.exists()]
            if asset and not source:
                continue
            results[name] = measure(arguments.command, [*source, *options], Path(folder), arguments.steps)
        print(name, {key: float(f"{value:.3g}") for key, value in results[name].items()}, flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
