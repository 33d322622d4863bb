#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Time of the processor against total error: the command on coarse and fine voxels, with large and small time
errors and tolerances of the solver, for the network and for finite elements.

    bench/total_error.py COMMAND [--scenes NAME ...] [--json FILE] [--figures FOLDER] [--truths FOLDER]
                         [--peers FILE]

The truth of each scene is a run of the network on voxels finer than all others, in equal steps of SDIRK2 that are
shorter than all others; what a coarser truth differs by is said beside it. Error: rms over the vertices and
the frames, over the largest rms motion of a frame. Time: of the processor, user and system, of one thread, with
reading and set-up; so that other work on the machine changes it little. --peers takes what
bench/peers/skfem_total.py wrote. docs/total_error.md has the tables."""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))
from mesh_number import block, frames_of, write_obj  # noqa: E402
from motion import header  # noqa: E402
from plot import Line, figure  # noqa: E402

Floats = NDArray[np.float64]
Row = dict[str, Any]
DEFAULT = 0.5  # per cent


@dataclass
class Solver:
    """A verb with the time errors [per cent] and tolerances that are run."""

    words: tuple[str, ...]
    time_errors: tuple[float, ...]
    tolerances: tuple[float, ...]


SOLVERS = {"network": Solver(("animate", "--device", "cpu"), (4, 2, 1, 0.5, 0.25, 0.1), (1e-1, 1e-2, 1e-3, 1e-4)),
           "finite elements": Solver(("simulate",), (2, 0.5, 0.1), (1e-1, 1e-3, 1e-5))}
SOFT = ("--law", "neo-hookean", "--poisson", "0.4", "--density", "1000", "--up", "y")


@dataclass
class Scene:
    """A body with the edges of its voxels [mm], those of the truth and of what that is compared with."""

    words: tuple[str, ...]
    edges: tuple[float, ...]
    truths: tuple[float, float]
    steps: tuple[int, int]  # a frame, of the truths
    block: tuple[int, int, int] | None = None  # squares along each axis, of 1 cm
    elements: int = 2  # how many of the edges are run by finite elements, which take far longer


SCENES = {
    "bar swings": Scene(("--young", "1e5", "--pin", "x<1mm", "--frames", "24", *SOFT), (40, 20), (10, 40 / 3), (32, 16),
                        (40, 8, 8)),
    "ball bounces": Scene(("--shape", "sphere(0,0,0, 0.1)", "--young", "0.5MPa", "--floor", "y=-0.4", "--velocity",
                           "0,-3,0", "--frames", "16", *SOFT), (50, 25), (12.5, 50 / 3), (64, 32), elements=1),
}


class Bench:
    """Runs of the command in a folder."""

    def __init__(self, command: str, folder: Path) -> None:
        self.command, self.folder = command, folder

    def run(self, scene: Scene, solver: str, edge: float, *more: str) -> tuple[Floats, Row]:
        """Vertices of all frames, (frames, vertices, 3), and the row of the run without its error."""
        asset: list[str] = []
        if scene.block:
            path = self.folder / "body.obj"
            write_obj(path, block(*scene.block))
            asset = [str(path)]
        out, report = self.folder / "x.pc2", self.folder / "report"
        words = [*SOLVERS[solver].words, *asset, *scene.words, "--h", f"{edge:.9g}mm", "--threads", "1", "--quiet",
                 "-o", str(out), "--report", str(report), *more]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([self.command, *words], capture_output=True, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if not out.exists():
            raise RuntimeError(" ".join(words) + ": " + done.stderr)
        said = json.loads(report.read_text())
        row = {"solver": solver, "h": edge / 1e3, "voxels": said["voxels"], "exit": done.returncode,
               "seconds": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
               "solves": said["time_error"]["solves"], "said_time_error": said["time_error"]["sum"],
               "said_mesh_error": said.get("mesh_error", {}).get("rms"),
               "converged_share": said["converged_share"]}
        frames = frames_of(out)
        out.unlink()
        return frames, row


def size_of(difference: Floats) -> float:
    """rms over frames and vertices."""
    return float(np.sqrt((difference ** 2).sum(2).mean()))


def measure(bench: Bench, scene: Scene, kept: Path | None) -> Row:
    """All runs of a scene. @param kept  file for the truth"""
    def fixed(k: int) -> Floats:
        return bench.run(scene, "network", scene.truths[k], "--time-scheme", "sdirk2", "--substeps",
                         str(scene.steps[k]), "--mesh-error", "off")[0]
    truth, coarser = fixed(0), fixed(1)
    if kept:
        np.save(kept, truth)
    motion = float(np.sqrt(((truth - truth[0]) ** 2).sum(2).mean(1)).max())
    rows: list[Row] = []
    print(f"motion {motion:.4g} m, truth moved by {size_of(truth - coarser) / motion:.2g}", flush=True)

    def take(solver: str, edge: float, sweep: str, time_error: float, *more: str) -> None:
        frames, row = bench.run(scene, solver, edge, "--time-error", f"{time_error}%", *more)
        rows.append({"sweep": sweep, "time_error": time_error / 100, **row,
                     "error": size_of(frames - truth) / motion})
        print(json.dumps(rows[-1]), flush=True)
    for name, solver in SOLVERS.items():
        edges = scene.edges[:scene.elements] if name == "finite elements" else scene.edges
        for edge in edges:
            for time_error in solver.time_errors:
                take(name, edge, "time error", time_error)
        for tolerance in solver.tolerances:
            take(name, edges[-1], "tolerance", DEFAULT, "--tolerance", str(tolerance))
            rows[-1]["tolerance"] = tolerance
    return {"motion": motion, "truth_moved": size_of(truth - coarser) / motion, "truth_h": scene.truths[0] / 1e3,
            "truth_steps": scene.steps[0], "rows": rows}


def draw(name: str, scene: Row, head: Row) -> str:
    """Error over time: a line for each solver and edge, along it the time error falls."""
    lines = []
    for solver in SOLVERS:
        mine = [row for row in scene["rows"] if row["solver"] == solver and row["sweep"] == "time error"]
        for h in dict.fromkeys(row["h"] for row in mine):
            lines.append(Line(f"{solver}, h {1e3 * h:g} mm", [(row["seconds"], row["error"]) for row in mine
                                                              if row["h"] == h], solver != "network"))
    notes = [f"{head['cpu']}, one thread; {head['commit']}; {head['date']}",
             "along each line --time-error falls, from 4 or 2 % to 0.1 %"]
    return figure(f"Total error over time: {name}", "time of the processor [s]", "error over the motion", lines, notes)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figures", type=Path)
    parser.add_argument("--truths", type=Path)
    parser.add_argument("--peers", type=Path)
    given = parser.parse_args()
    result = json.loads(given.json.read_text()) if given.json and given.json.exists() else {"scenes": {}}
    kept = result["scenes"]
    if given.peers:
        result["peers"] = json.loads(given.peers.read_text())
    for name in given.scenes:
        print(name, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            truth = given.truths / f"{name.replace(' ', '_')}.npy" if given.truths else None
            kept[name] = measure(Bench(given.command, Path(folder)), SCENES[name], truth)
        result["header"], result["scenes"] = header(), {scene: kept[scene] for scene in SCENES if scene in kept}
        if given.json:
            given.json.write_text(json.dumps(result, indent=1) + "\n")
    if given.json and given.peers:
        given.json.write_text(json.dumps(result, indent=1) + "\n")
    for name in kept if given.figures else []:
        drawn = given.figures / f"total_error_{name.replace(' ', '_')}.svg"
        drawn.write_text(draw(name, kept[name], result["header"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
