#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Whether two builds of the command give the same bits, and how their step times compare.

    bench/compare_builds.py BEFORE AFTER [--device cuda] [--clips NAME ...] [--steps 5] [--json FILE]

Runs the clips below with both: states, steps of the log and animations must be equal to the bit, the
times and the commit that they carry aside, and what only the second one writes. With --steps N the medians of `bench step`, taken N times
in turn, stand beside. Ends with 1 where a bit differs."""

from __future__ import annotations

import argparse
import json
import statistics
import struct
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np

MEASURED = {"ms", "seconds"}  # of a step in the log
Clip = tuple[str, str, list[str]]  # verb, input, options



def small(frames: int) -> list[str]:
    """Options of a clip that takes a second or a few."""
    return ["--voxels", "16", "--frames", str(frames)]


CLIPS: dict[str, Clip] = {
    "pinned": ("animate", "ball.obj", [*small(12), "--pin", "y<5%", "--material", "jelly"]),
    "floor": ("animate", "ball.obj", [*small(16), "--floor", "y=-0.62", "--material", "jelly"]),
    "collider": ("animate", "bar.obj", [*small(10), "--pin", "x<2%", "--collider",
                                        "sphere(1,-0.4,0.1, 0.3) path 0:0,0,0; 0.4:0,0.3,0"]),
    "newton": ("animate", "bar.obj", [*small(8), "--pin", "x<2%", "--solver", "newton",
                                      "--poisson", "0.49"]),
    "paper": ("animate", "bar.obj", [*small(4), "--pin", "x<2%", "--solver", "paper"]),
    "bdf2": ("animate", "ball.obj", [*small(8), "--time-scheme", "bdf2", "--analytic",
                                     "--spin", "0,3,0", "--gravity", "0,0,0",
                                     "--glb-profile", "keyframe"]),
    "regions": ("animate", "bar.obj", [*small(10), "--pin", "x<2%",
                                       "--region", "x>60%: jelly,young=30kPa"]),
    "cloud": ("animate", "cloud.xyz", [*small(8), "--pin", "y<10%", "--material", "foam"]),
    "voxels": ("simulate", "bar.obj", [*small(4), "--pin", "x<2%"]),
    "bbar": ("simulate", "bar.obj", ["--voxels", "10", "--frames", "3", "--pin", "x<2%",
                                     "--element", "hex-bbar", "--time-scheme", "newmark",
                                     "--mass", "consistent"]),
    "tets": ("simulate", "bar.obj", ["--voxels", "8", "--frames", "4", "--element", "tet10",
                                     "--pin", "x<2%", "--hold", "x<50%: y",
                                     "--traction", "z>99%: 0,0,-20", "--move",
                                     "x>99%: turn(0,0,0, 1,0,0) 0:0; 0.2:20deg"]),
    "simulated-floor": ("simulate", "ball.obj", ["--voxels", "10", "--frames", "8",
                                                 "--floor", "y=-0.52", "--velocity", "1,0,0",
                                                 "--time-scheme", "bdf2"]),
    "static": ("simulate", "bar.obj", ["--voxels", "12", "--pin", "x<2%", "--static"]),
}


def bar() -> str:
    """A box of 1 x 0.25 x 0.2 m, its longest edge from x = 0."""
    corners = [(x, y, z) for z in (0, 0.2) for y in (0, 0.25) for x in (0, 1)]
    faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {f}\n" for f in faces)


def ball(rings: int = 12, sides: int = 20) -> str:
    """A ball of 1 m about the origin."""
    lines = ["v 0 0.5 0"]
    for r in range(1, rings):
        polar = np.pi * r / rings
        for s in range(sides):
            turn = 2 * np.pi * s / sides
            x, z = 0.5 * np.sin(polar) * np.cos(turn), 0.5 * np.sin(polar) * np.sin(turn)
            lines.append(f"v {x:.9f} {0.5 * np.cos(polar):.9f} {z:.9f}")
    lines.append("v 0 -0.5 0")
    at = lambda r, s: 2 + (r - 1) * sides + s % sides  # noqa: E731
    last = 2 + (rings - 1) * sides
    for s in range(sides):
        lines.append(f"f 1 {at(1, s + 1)} {at(1, s)}")
        lines.append(f"f {last} {at(rings - 1, s)} {at(rings - 1, s + 1)}")
        for r in range(1, rings - 1):
            lines.append(f"f {at(r, s)} {at(r, s + 1)} {at(r + 1, s + 1)} {at(r + 1, s)}")
    return "\n".join(lines) + "\n"


def cloud(count: int = 4000) -> str:
    """Points of the ball's surface."""
    points = np.random.default_rng(1).normal(size=(count, 3))
    points *= 0.5 / np.linalg.norm(points, axis=1, keepdims=True)
    return "".join("{:.9f} {:.9f} {:.9f}\n".format(*p) for p in points)


def write_inputs(folder: Path) -> None:
    (folder / "bar.obj").write_text(bar())
    (folder / "ball.obj").write_text(ball())
    (folder / "cloud.xyz").write_text(cloud())


def run_clip(binary: Path, clip: Clip, inputs: Path, folder: Path, device: str) -> int:
    """Exit code; the outputs lie in the folder."""
    verb, source, options = clip
    folder.mkdir()
    words = [binary, verb, inputs / source, *options, "--quiet", "--state", "s.h5", "--log-json",
             "log.json", "-o", "a.glb" if source.endswith(".obj") else "a.pc2"]
    if verb == "animate" and "paper" not in options:
        words += ["--device", device]
    if "--time-scheme" not in options:
        words += ["--time-scheme", "euler"]
    return subprocess.run(words, cwd=folder, check=False, stdout=subprocess.DEVNULL).returncode


def data_sets(file: h5py.File) -> list[str]:
    names: list[str] = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return names


def state_differs(a: Path, b: Path) -> list[str]:
    """Names of data sets whose bits differ."""
    different: list[str] = []
    with h5py.File(a) as one, h5py.File(b) as two:
        names = set(data_sets(two))
        for name in data_sets(one):
            if name not in names:
                different.append(f"lacks {name}")
            elif name.rsplit("/")[-1] not in MEASURED and not same_values(one[name][()], two[name][()]):
                different.append(name)
    return different


def same_values(a: Any, b: Any) -> bool:
    """Equal to the bit; of records the fields that the first one has."""
    if a.dtype.names is None:
        return a.tobytes() == b.tobytes()
    return all(name in b.dtype.names and np.array_equal(a[name], b[name]) for name in a.dtype.names)


def steps_of(path: Path) -> list[dict[str, Any]]:
    steps = [json.loads(line) for line in path.read_text().splitlines()]
    return [{k: v for k, v in step.items() if k not in MEASURED} for step in steps]


def glb_of(path: Path) -> tuple[dict[str, Any], bytes]:
    """The document without what says by whom it was made, and the binary chunk."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + length])
    document["asset"].pop("generator", None)
    for extras in (document.get("extras", {}), document["asset"].get("extras", {})):
        for key in ("commit", "command", "generator"):
            extras.pop(key, None)
        for inner in extras.values():
            if isinstance(inner, dict):
                for key in ("commit", "command", "generator", "frames"):  # frames: as the log
                    inner.pop(key, None)
    return document, data[20 + length:]


def differences(a: Path, b: Path) -> list[str]:
    """What differs between the outputs of a clip in two folders."""
    found = [f"state {name}" for name in state_differs(a / "s.h5", b / "s.h5")]
    one, two = steps_of(a / "log.json"), steps_of(b / "log.json")
    keys = sorted({k for s, t in zip(one, two) for k in s if s[k] != t.get(k)})
    if len(one) != len(two) or keys:
        found.append(f"log ({len(one)} and {len(two)} steps; {', '.join(keys)})")
    if (a / "a.pc2").exists():
        same = (a / "a.pc2").read_bytes() == (b / "a.pc2").read_bytes()
        return found + ([] if same else ["PC2"])
    one, two = glb_of(a / "a.glb"), glb_of(b / "a.glb")
    if one[0] != two[0]:
        found.append("GLB document")
    if one[1] != two[1]:
        found.append("GLB data")
    return found


def compare_clips(before: Path, after: Path, names: list[str], device: str) -> dict[str, list[str]]:
    results: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_inputs(folder)
        for clip in names:
            codes = [run_clip(binary, CLIPS[clip], folder, folder / f"{clip}-{k}", device)
                     for k, binary in enumerate((before, after))]
            found = [f"exit codes {codes}"] if codes[0] != codes[1] or codes[0] not in (0, 4) else []
            if not found:
                found = differences(folder / f"{clip}-0", folder / f"{clip}-1")
            results[clip] = found
            print(f"{clip:16} {'same bits' if not found else 'DIFFERS: ' + ', '.join(found)}", flush=True)
    return results


def step_times(binary: Path, device: str, sizes: str) -> dict[str, float]:
    """Median milliseconds of a step by scene."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "bench.json"
        subprocess.run([binary, "bench", "step", "--device", device, "--sizes", sizes, "--json", path],
                       check=True, stdout=subprocess.DEVNULL)
        rows = json.loads(path.read_text())["step"]
    return {f"{r['scene']} {r['voxels']}": r["ms"] for r in rows}


def compare_steps(before: Path, after: Path, runs: int, device: str, sizes: str) -> dict[str, Any]:
    """Medians of both builds, taken in turn (the first one by turns too), and their ratio. On a
    busy machine single runs scatter by 15 %: it takes 60 of them to see 1 %."""
    times: list[list[dict[str, float]]] = [[], []]
    for n in range(runs):
        for k in ((0, 1) if n % 2 == 0 else (1, 0)):
            times[k].append(step_times((before, after)[k], device, sizes))
    result = {}
    for key in times[0][0]:
        a, b = (statistics.median(run[key] for run in side) for side in times)
        result[key] = {"before_ms": a, "after_ms": b, "ratio": b / a}
        print(f"{key:16} {a:.3f} ms before, {b:.3f} ms after, ratio {b / a:.3f}", flush=True)
    return result


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--clips", nargs="*", choices=CLIPS)
    parser.add_argument("--steps", type=int, default=0)
    parser.add_argument("--sizes", default="3.2e4")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    before, after = options.before.resolve(), options.after.resolve()
    names = list(CLIPS) if options.clips is None else options.clips
    result: dict[str, Any] = {"clips": compare_clips(before, after, names, options.device)}
    if options.steps:
        result["steps"] = compare_steps(before, after, options.steps, options.device, options.sizes)
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")
    return int(any(result["clips"].values()))


if __name__ == "__main__":
    sys.exit(main())
