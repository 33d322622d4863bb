#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Five motions by one step of implicit Euler a frame, by default, and by many steps of SDIRK2 a frame.

    bench/before_after.py COMMAND [--only NAME ...] [--json FILE] [--pictures FOLDER]

Materials are not damped. Two seconds at 30 frames a second unless said. docs/how_right.md has the table and the
pictures: twelve moments of a clip, by implicit Euler and by default."""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))
from motion import header  # noqa: E402

Floats = NDArray[np.float64]
FPS = 30
EULER, FINE = ("--time-scheme", "euler", "--substeps", "1"), 32
SOLID = ("--law", "neo-hookean", "--poisson", "0.4", "--density", "1000", "--damping", "0", "--up", "y", "--fps", f"{FPS}")
GRAVITY, SLOPE = 9.81, math.radians(20)


@dataclass
class Clip:
    """A run at its frames, the start first."""

    rest: Floats
    mass: Floats
    x: Floats  # (frames, nodes, 3)
    v: Floats

    def centre(self) -> Floats:
        """Of mass, (frames, 3)."""
        return np.einsum("n,fnd->fd", self.mass, self.x) / self.mass.sum()


class Bench:
    """Runs of the command in a folder."""

    def __init__(self, command: str, folder: Path) -> None:
        self.command, self.folder = command, folder

    def play(self, scene: tuple[str, ...], scheme: tuple[str, ...]) -> Clip:
        state = self.folder / "state.h5"
        done = subprocess.run([self.command, "animate", *scene, *scheme, "--mesh-error", "off", "--quiet", "-o",
                               str(self.folder / "x.pc2"), "--state", str(state)], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 4):
            raise RuntimeError(done.stderr)
        with h5py.File(state) as file:
            time = file["steps/time"][:]
            at = np.searchsorted(time, np.arange(round(time[-1] * FPS) + 1) / FPS - 1e-9)
            return Clip(file["grid/rest"][:], file["grid/mass"][:], file["steps/x"][:][at], file["steps/v"][:][at])

    def three(self, scene: tuple[str, ...]) -> tuple[Clip, Clip, Clip]:
        """By implicit Euler, by default, and in fine steps."""
        fine = ("--time-scheme", "sdirk2", "--substeps", str(FINE))
        return self.play(scene, EULER), self.play(scene, ()), self.play(scene, fine)


def spin(bench: Bench) -> list[float]:
    """Angular momentum about z that is left."""
    def left(clip: Clip) -> float:
        about = clip.x - clip.centre()[:, None]
        momentum = np.einsum("n,fn->f", clip.mass, about[..., 0] * clip.v[..., 1] - about[..., 1] * clip.v[..., 0])
        return float(momentum[-1] / momentum[0])
    return [left(clip) for clip in bench.three(("--shape", "sphere(0,0,0, 0.2)", "--h", "5cm", "--young", "5.6MPa", "--spin",
                                                "0,0,10", "--gravity", "0,0,0", "--frames", "60", *SOLID))]


def pendulum(bench: Bench) -> list[float]:
    """Largest error of the centre over the range of its way; let go 1.2 rad from where it hangs."""
    gravity = f"{GRAVITY * math.sin(1.2):.9g},{-GRAVITY * math.cos(1.2):.9g},0"
    clips = bench.three(("--shape", "box(0,0,0, 0.2,0.4,0.15)", "--h", "5cm", "--young", "5.6MPa", "--gravity", gravity,
                         "--pin", "box(-0.1mm,39.99cm,-1m, 0.1mm,40.01cm,1m)", "--frames", "60", *SOLID))
    truth = clips[2].centre()
    size = float(np.linalg.norm(np.ptp(truth, axis=0)))
    return [float(np.linalg.norm(clip.centre() - truth, axis=1).max()) / size for clip in clips]


def ringing(bench: Bench) -> list[float]:
    """Amplitude of the first mode of a bar that is held at an end, after 60 frames over that at the start: a period is 16 frames."""
    length, rate = 0.8, 2 * math.pi * FPS / 16
    young = 1000 * (4 * length * FPS / 16) ** 2

    def left(clip: Clip) -> float:
        mode = clip.mass * np.sin(math.pi / 2 * clip.rest[:, 0] / length)
        place, speed = (clip.x[..., 0] - clip.rest[:, 0]) @ mode, clip.v[..., 0] @ mode
        amplitude = np.hypot(place, speed / rate)
        return float(amplitude[-1] / amplitude[0])
    return [left(clip) for clip in bench.three(("--shape", "box(0,0,0, 0.8,0.15,0.15)", "--h", "5cm", "--young", f"{young:.9g}",
                                                "--pin", "x<1mm", "--velocity", "0.3,0,0", "--gravity", "0,0,0", "--frames", "60",
                                                *SOLID[:2], "--poisson", "0", *SOLID[4:]))]


def hop(bench: Bench) -> list[float]:
    """How high the centre of a ball rises after it has fallen 1 m."""
    def height(clip: Clip) -> float:
        y = clip.centre()[:, 1]
        low = next(k for k in range(1, len(y)) if y[k + 1] > y[k]) if (np.diff(y) > 0).any() else len(y) - 1
        return float(y[low:].max() - (y[0] - 1))
    return [height(clip) for clip in bench.three(("--shape", "sphere(0,0,0, 0.1)", "--h", "2.5cm", "--young", "0.5MPa", "--floor",
                                                  "y=-1.1", "--frames", "40", *SOLID))]


def slide(bench: Bench, degrees: float = 20) -> list[float]:
    """How far a block of rubber slides down a slope that friction holds it on, in 1.5 s, and in the last half second."""
    angle = math.radians(degrees)
    gravity = f"{GRAVITY * math.sin(angle):.9g},{-GRAVITY * math.cos(angle):.9g},0"
    ways = []
    for clip in bench.three(("--shape", "box(0,0,0, 0.25,0.2,0.3)", "--h", "5cm", "--material", "rubber", "--damping", "0", "--up",
                             "y", "--floor", "y=0", "--gravity", gravity, "--frames", "45")):
        x = clip.centre()[:, 0]
        ways += [float(x[-1] - x[0]), float(x[-1] - x[-1 - FPS // 2])]
    return ways


PARTS: dict[str, Callable[[Bench], list[float]]] = {"spin": spin, "pendulum": pendulum, "ringing": ringing, "hop": hop, "slide": slide}
BAR = "box(0,0,0, 0.4,0.1,0.1)"
SLOPE_GRAVITY = f"{GRAVITY * math.sin(SLOPE):.4g},{-GRAVITY * math.cos(SLOPE):.4g},0"
ROOT = Path(__file__).resolve().parents[1]
# of pictures: a minute on the slope, so that creeping is seen
PICTURES: dict[str, tuple[str, ...]] = {
    "spin": ("--shape", BAR, "--h", "2.5cm", "--material", "soft-rubber", "--spin", "0,0,6", "--gravity", "0,0,0", "--frames",
             "44", "--up", "y", "--image-size", "160x160"),
    "hop": ("--scene", str(ROOT / "examples/scenes/bouncing_ball.toml"), "--image-size", "160x160"),
    "slope": ("--scene", str(ROOT / "examples/scenes/block_on_a_slope.toml"), "--gravity", SLOPE_GRAVITY, "--frames", "1800",
              "--camera", "front")}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--only", nargs="*", choices=PARTS, default=list(PARTS))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--pictures", type=Path)
    given = parser.parse_args()
    kept = json.loads(given.json.read_text())["rows"] if given.json and given.json.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        for name in given.only:
            kept[name] = PARTS[name](Bench(given.command, Path(folder)))
            print(name, kept[name], flush=True)
    if given.json:
        given.json.write_text(json.dumps({"header": header(), "fine": FINE, "rows": kept}, indent=1) + "\n")
    for name, words in PICTURES.items() if given.pictures else ():
        for scheme, more in (("euler", EULER), ("auto", ())):
            subprocess.run([given.command, "animate", *words, *more, "--quiet", "-o",
                            str(given.pictures / f"{name}_{scheme}.png")], check=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
