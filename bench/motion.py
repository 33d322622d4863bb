#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How right the motion is at defaults: the command against itself at 64 steps of SDIRK2 a frame.

    bench/motion.py COMMAND [--assets FOLDER] [--scenes NAME ...] [--steps 64] [--frame-steps 32] [--json FILE]
                    [--frames-only]

COMMAND lies beside bench_local_error. For each scene: rms error of the vertices over their largest motion, at
the end of the run and the largest of all frames; each frame made again from its start in 32 steps, and what the
run said of it over what came out; solves a frame; frames that missed their time error; the rise of the energy
over the largest kinetic one. Scenes with assets are left out where the folder lacks them; --frames-only keeps
the rest of FILE. docs/how_right.md has the tables."""

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


LEAST = 0.1  # of what is accepted: frames of smaller errors have no ratio


def play(command: str, source: list[str], folder: Path, *more: str) -> tuple[list[Floats], dict[str, Any]]:
    """Vertices of each frame [m], and the report. The file has the numbers of the asset."""
    folder.mkdir()
    subprocess.run([command, "animate", *source, *more, "--quiet", "--mesh-error", "off", "-o", folder / "x.ply",
                    "--report", folder / "report"], check=False, stdout=subprocess.DEVNULL)
    report = json.loads((folder / "report").read_text())
    frames = [vertices(path) for path in sorted(folder.glob("x_*.ply"))]
    scale = report["asset"]["size"]["longest_edge"] / np.ptp(frames[0], axis=0).max()
    return [scale * frame for frame in frames], report


def distances(run: list[Floats], other: list[Floats]) -> list[float]:
    """rms over the vertices, of each frame [m]."""
    return [float(np.sqrt(((a - b) ** 2).sum(1).mean())) for a, b in zip(run, other)]


def percentile(values: list[float], share: float) -> float | None:
    return float(np.quantile(values, share)) if values else None


def local_ratios(command: str, source: list[str], folder: Path, steps: int) -> dict[str, Any]:
    """Of each frame made again from its start: what the run says of its error over what that is. Frames
    are smooth where no collider touches the body in them or in the one before; else the error of the rigid
    motion after the contact counts too, for a frame."""
    program = Path(command).resolve().parent / "bench_local_error"
    done = subprocess.run([program, str(steps), "animate", *source, "--quiet", "-o", folder / "none.ply"], check=True,
                          capture_output=True, text=True)
    frames = [json.loads(line) for line in done.stdout.splitlines()]
    result: dict[str, Any] = {"frames": frames}
    touched = [frame["touches"] for frame in frames]
    rough = [here or before for here, before in zip(touched, [False, *touched])]
    for name, kind in (("smooth", False), ("rough", True)):
        pairs = [(frame["estimate"], frame["shown"] + kind * frame["kick"], frame["accepted"])
                 for frame, is_rough in zip(frames, rough) if is_rough == kind]
        said = [estimate / error for estimate, error, accepted in pairs if max(estimate, error) > LEAST * accepted]
        result[name] = {"count": len(said), "median": percentile(said, 0.5), "tenth": percentile(said, 0.1),
                        "ninetieth": percentile(said, 0.9)}
    return result


def measure(command: str, source: list[str], folder: Path, steps: int, of_frame: int) -> dict[str, Any]:
    """The numbers of one scene."""
    run, report = play(command, source, folder / "auto")
    fine, of_fine = play(command, source, folder / "fine", "--time-scheme", "sdirk2", "--substeps", str(steps))
    errors, motion = distances(run, fine), max(distances(fine, [fine[0]] * len(fine)))
    energy, fine_energy = report["ledger"]["energy"], of_fine["ledger"]["energy"]
    return {"frames": len(run) - 1, "voxels": report["voxels"], "motion": motion,
            "error_at_the_end": errors[-1] / motion, "largest_error": max(errors) / motion,
            "said": report["time_error"]["sum"], "said_over_true": report["time_error"]["sum"] / max(errors),
            "frames_over": report["time_error"]["frames_over"],
            "solves_a_frame": report["time_error"]["solves"] / (len(run) - 1),
            "rejected": report["time_error"]["rejected"],
            "energy_rise": energy["largest_rise"] / energy["largest_kinetic"],
            "fine_energy_rise": fine_energy["largest_rise"] / fine_energy["largest_kinetic"],
            "min_j": report["min_j"], "converged_share": report["converged_share"],
            "local": local_ratios(command, source, folder, of_frame)}


def header() -> dict[str, Any]:
    """Where and when it was measured."""
    def said(*words: str) -> str:
        return subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    cpu = next((line.partition(":")[2].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("model name")), "")
    return {"commit": said("git", "rev-parse", "--short=12", "HEAD"), "date": said("date", "+%Y-%m-%d"), "cpu": cpu}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--assets", type=Path)
    parser.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES))
    parser.add_argument("--steps", type=int, default=64)
    parser.add_argument("--frame-steps", type=int, default=32)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--frames-only", action="store_true")
    given = parser.parse_args()
    kept = json.loads(given.json.read_text())["scenes"] if given.json and given.json.exists() else {}
    for name in given.scenes:
        asset, options = SCENES[name]
        with tempfile.TemporaryDirectory() as folder:
            write_two_blocks(Path(folder) / "two.obj")
            places = [parent / asset for parent in (Path(folder), given.assets) if parent]
            source = [str(place) for place in places if asset and place.exists()]
            if asset and not source:
                continue
            words = [*source, *options]
            if given.frames_only:
                kept[name]["local"] = local_ratios(given.command, words, Path(folder), given.frame_steps)
            else:
                kept[name] = measure(given.command, words, Path(folder), given.steps, given.frame_steps)
        short = {key: value for key, value in kept[name].items() if key != "local"}
        print(name, short, {key: kept[name]["local"][key] for key in ("smooth", "rough")}, flush=True)
        if given.json:
            scenes = {scene: kept[scene] for scene in SCENES if scene in kept}
            result = {"header": header(), "steps": given.steps, "frame_steps": given.frame_steps, "scenes": scenes}
            given.json.write_text(json.dumps(result) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
