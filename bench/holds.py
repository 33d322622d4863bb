#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Parts that are held or moved where their borders cut voxels: the command against references.

    bench/holds.py COMMAND [--json FILE] [--only PART ...]

Each body stands on grids that lie at several offsets behind a border. The asset has a second box
for that, which is held as a whole: the grid has a layer of nodes in its border. Statics of `animate` are one
step of 100 s. Displacements at points are those of their voxels. docs/holds.md has the tables."""

from __future__ import annotations

import argparse
import json
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

Floats = NDArray[np.float64]
Row = dict[str, Any]
OFFSETS = (0.0, 1e-4, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.9, 0.9999)
FEW = (0.0, 0.3, 0.5, 0.7, 0.9)
YOUNG, DENSITY, GRAVITY = 1e8, 1000.0, 9.81
SAG = DENSITY * GRAVITY / YOUNG  # unit of displacements, for those of E 1 and weight 1
BODY = ("--young", f"{YOUNG}", "--poisson", "0.3", "--density", f"{DENSITY}")
SOLVERS = {"network": ("animate", "--substeps", "1", "--analytic", "--time-scheme", "euler",
                       "--damping", "0"),
           "voxel": ("simulate", "--element", "voxel", "--static"),
           "hex": ("simulate", "--element", "hex", "--static"),
           "hex-bbar": ("simulate", "--element", "hex-bbar", "--static")}
# bricks of 27 nodes, E 1, weight 1: sag at a quarter and the middle, force of a pull of 1, torque of a turn of 1
QUARTER, MIDDLE, FORCE, TORQUE = -0.64436, -1.0588, 0.041313, 8.885e-5
BAR = (0.0, 0.0, 0.0, 1.0, 0.2, 0.2)
ENDS = ("--pin", "x<0.01m", "--pin", "x>0.99m")


@dataclass
class End:
    """The end of a run."""

    rest: Floats
    moved: Floats  # displacements of nodes [m]
    corners: NDArray[np.int64]
    force: Floats  # of each holder [N]
    moment: Floats
    inner: int  # V-cycles of all steps
    report: Row

    def at(self, point: tuple[float, float, float]) -> Floats:
        """The displacement of a point."""
        low, high = self.rest[self.corners[:, 0]], self.rest[self.corners[:, 7]]
        away = np.maximum(np.maximum(low - point, point - high), 0).max(1)
        v = int(away.argmin())
        share = (np.array(point) - low[v]) / (high[v] - low[v])
        weight = [np.prod([share[d] if c >> d & 1 else 1 - share[d] for d in range(3)]) for c in range(8)]
        return np.array(weight) @ self.moved[self.corners[v]]


class Bench:
    """Runs of the command in a folder."""

    def __init__(self, command: str, folder: Path) -> None:
        self.command, self.folder = command, folder

    def boxes(self, *boxes: tuple[float, ...]) -> Path:
        """An OBJ of boxes, each its lower and its upper corner."""
        quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        lines = []
        for k, box in enumerate(boxes):
            for c in range(8):
                lines.append("v " + " ".join(f"{box[3 * (c >> d & 1) + d]:.12g}" for d in (2, 1, 0)[::-1]))
            lines += ["f " + " ".join(str(8 * k + q + 1) for q in quad[::-1]) for quad in quads]
        path = self.folder / "asset.obj"
        path.write_text("\n".join(lines) + "\n")
        return path

    def run(self, solver: str, asset: Path, h: float, *options: str, frames: int = 1, tolerance: float = 1e-7,
            fps: float = 0.01, body: tuple[str, ...] = BODY) -> End:
        """One run to its end. Raises RuntimeError where it fails."""
        state, report = self.folder / "state.h5", self.folder / "report.json"
        verb, *own = SOLVERS[solver]
        count = ["--frames", str(frames), "--fps", str(fps)] if verb == "animate" else []
        words = [self.command, verb, str(asset), *own, *count, "--h", f"{h:.12g}", *body, "--tolerance", f"{tolerance}",
                 "--state", str(state), "--report", str(report), "-o", str(self.folder / "out.pc2"), "--quiet",
                 "--mesh-error", "off", *options]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"{' '.join(words)}\n{done.stderr}")
        with h5py.File(state) as file:
            steps, grid = file["steps"], file["grid"]
            rest = grid["rest"][:]
            return End(rest, steps["x"][-1] - rest, grid["corners"][:].astype(np.int64),
                       steps["reaction_force"][-1], steps["reaction_moment"][-1], int(steps["inner"][:].sum()),
                       json.loads(report.read_text()))


def behind(place: float, h: float, offset: float, beyond: float = -0.3) -> float:
    """The place of a plane beyond another one, by so much that the latter lies an offset [h] behind nodes."""
    return place - h * (np.ceil((place - beyond) / h) + offset)


class Bar:
    """The bar held at both ends, and a box beside it in which a plane places the grid."""

    def __init__(self, bench: Bench, length: float = 1.0, thick: float = 0.2) -> None:
        self.bench = bench
        self.asset = bench.boxes((0, 0, 0, length, thick, 0.2), (-0.6, 0.6, 0, -0.3, 0.8, 0.2))

    def run(self, solver: str, h: float, offset: float, *options: str, **more: Any) -> End:
        return self.bench.run(solver, self.asset, h, "--pin", f"x<{behind(0.01, h, offset):.12g}m", *options, **more)


def spread(values: list[float]) -> float:
    """Largest over smallest, less 1 [%]."""
    return 100 * (max(values, key=abs) / min(values, key=abs) - 1)


def sagging(bench: Bench) -> list[Row]:
    """The bar under its weight."""
    bar, rows = Bar(bench), []
    for solver in ("network", "voxel", "hex"):
        for h in (0.1, 0.2 / 3, 0.05, 0.1 / 3):
            ends = [bar.run(solver, h, offset, *ENDS) for offset in OFFSETS]
            sags = [[e.at((x, 0.1, 0.1))[1] / SAG for x in (0.25, 0.5, 0.75)] for e in ends]
            error = [100 * abs(sag / truth - 1) for three in sags for sag, truth in
                     zip(three, (QUARTER, MIDDLE, QUARTER), strict=True)]
            faces = [np.abs(e.at((x, y, 0.13))).max() for e in ends for x in (0.01, 0.99) for y in (0.03, 0.19)]
            weight = [abs(e.force[:, 1].sum() / (DENSITY * 0.98 * 0.04 * GRAVITY) - 1) for e in ends]
            rows.append({"solver": solver, "voxels": round(0.2 / h), "error_mean": float(np.mean(error)), "error_worst": max(error),
                         "left_right": max(100 * abs((three[0] - three[2]) / three[1]) for three in sags),
                         "spread": spread([three[1] for three in sags]),
                         "face": float(max(faces) / abs(SAG * MIDDLE)), "weight": max(weight)})
    return rows


def pulled(bench: Bench) -> list[Row]:
    """The bar pulled and turned by little and by much."""
    bar, rows, still = Bar(bench), [], ("--gravity", "0,0,0", "--pin", "x<0.01m")
    pull, turn = "--move x>0.99m: shift 0:0,0,0; {t}:{by},0,0", "--move x>0.99m: turn(0,0.1,0.1, 1,0,0) 0:0; {t}:{by}"
    for solver in ("network", "voxel", "hex"):
        for h in (0.1, 0.05):
            row: Row = {"solver": solver, "voxels": round(0.2 / h)}
            for name, text, by, law in (("force", pull, 1e-5, "fixed-corotated"), ("torque", turn, 1e-4, "fixed-corotated"),
                                        ("far_force", pull, 0.3, "neo-hookean"), ("far_torque", turn, np.pi / 2, "neo-hookean")):
                far, frames = name.startswith("far"), 12 if name.startswith("far") else 1
                move = text.format(t=100 * frames, by=by).split(" ", 1)
                found, off = [], 0.0
                for offset in FEW if far else OFFSETS:
                    end = bar.run(solver, h, offset, *still, *move, "--law", law, frames=frames)
                    found.append(float((end.moment if "torque" in name else end.force)[-1, 0] / YOUNG / (1 if far else by)))
                    wanted = np.array([by, 0, 0]) if "force" in name else turned(by)
                    off = max(off, float(np.abs(end.at((0.99, 0.13, 0.13)) - wanted).max() / by))
                row |= {name: found, f"{name}_face": off}
            rows.append(row)
    return rows


def turned(angle: float) -> Floats:
    """Displacement of the point (0.13, 0.13) of the cross-section in a turn about its middle."""
    y, z = 0.03, 0.03
    return np.array([0, y * np.cos(angle) - z * np.sin(angle) - y, y * np.sin(angle) + z * np.cos(angle) - z])


PROBES = [(0.02, 0.3, 0.3), (0.58, 0.3, 0.3), (0.3, 0.02, 0.3), (0.3, 0.58, 0.3), (0.02, 0.02, 0.02), (0.58, 0.58, 0.02)]
SHAPES: dict[str, tuple[tuple[float, ...], str, list[tuple[float, float, float]], tuple[float, ...]]] = {
    "ball of radius 0.17 in a block": ((0, 0, 0, 0.6, 0.6, 0.6), "sphere(0.3m,0.3m,0.3m, 0.17m)", PROBES, (0.1, 0.06, 0.04)),
    "ball of radius 0.06 in a block": ((0, 0, 0, 0.6, 0.6, 0.6), "sphere(0.3m,0.3m,0.3m, 0.06m)", PROBES, (0.06, 0.04, 0.03)),
    "edge of a box in a block": ((0, 0, 0, 0.6, 0.4, 0.4), "box(0.3m,-1m,-1m, 1m,0.2m,1m)",
                                 [(0.02, 0.38, 0.2), (0.02, 0.02, 0.2), (0.58, 0.38, 0.2), (0.28, 0.38, 0.02)], (0.1, 1 / 15, 0.05))}


def shaped(bench: Bench) -> list[Row]:
    """Blocks held at curved borders and edges, against a grid of 0.02 (boxes: that fits)."""
    rows = []
    for name, (block, pin, probes, edges) in SHAPES.items():
        asset = bench.boxes(block, (-0.7, -0.7, -0.7, -0.5, -0.5, -0.5))
        for solver in ("network", "voxel"):
            def probe(h: float, offset: float) -> Floats:
                planes = [word for d, axis in enumerate("xyz") for word in
                          ("--pin", f"{axis}<{behind(0, h, offset * (1, 0.6, 0.3)[d], -0.5):.12g}m")]
                end = bench.run(solver, asset, h, *planes, "--pin", pin)
                return np.array([end.at(point) for point in probes])
            truth = probe(0.02, 0)
            for h in edges:
                off = [100 * np.abs(probe(h, offset) - truth).max() / np.abs(truth).max() for offset in FEW]
                rows.append({"body": name, "solver": solver, "h": h, "mean": float(np.mean(off)), "worst": float(max(off))})
    return rows


def special(bench: Bench) -> list[Row]:
    """Thin bodies, gaps, thick holds of one axis."""
    rows: list[Row] = []
    h = 0.05
    for solver in ("network", "voxel"):
        # a strip 0.4 voxels thick that is held at one end
        strip = Bar(bench, thick=0.4 * h)
        tips = [strip.run(solver, h, offset, "--pin", "x<0.01m").at((0.99, 0.01, 0.1))[1] for offset in OFFSETS]
        rows.append({"body": "strip 0.4 voxels thick, held at one end: spread of the tip [%]", "solver": solver,
                     "values": [spread(tips)]})
        # two pins with a gap between them
        bar = Bar(bench)
        for gap in (0.5, 1.0, 1.5, 2.2, 4.0):
            ends = ("--pin", "x<0.3m", "--pin", f"x>{0.3 + gap * h:.12g}m")
            sags = [-bar.run(solver, h, offset, *ends).at((0.3 + gap * h / 2, 0.1, 0.1))[1] / SAG for offset in FEW]
            shear = (gap * h) ** 2 / 8 / (1 / 2.6)
            rows.append({"body": f"gap of {gap} voxels between pins: sag over that of shear alone, least and most",
                         "solver": solver, "values": [min(sags) / shear, max(sags) / shear]})
    # material that moves along x only within a tenth of the bar
    for h in (0.1, 0.05, 0.025):
        sags = []
        for offset in FEW:
            end = Bar(bench).run("network", h, offset, "--pin", "x>0.99m", "--hold", "x<0.1m: yz")
            sags.append(end.at((0.5, 0.1, 0.1))[1] / SAG)
        rows.append({"body": f"bar held along y and z within a tenth of it, h {h}: sag in the middle, least and most",
                     "solver": "network", "values": [min(sags), max(sags)]})
    return rows


def mirrored(bench: Bench) -> list[Row]:
    """A soft bar held at both ends and its mirror image, 60 frames of `auto`."""
    soft = ("--young", "2e5", "--poisson", "0.3", "--density", "1000")
    rows = []
    for tolerance in ("1e-3", "1e-6"):
        clips = []
        for sign in (1, -1):
            asset, out = bench.boxes((-0.5, 0, 0, 0.5, 0.2, 0.2), (-0.9, 0.6, 0, -0.7, 0.8, 0.2)), bench.folder / "clip.pc2"
            place = behind(sign * behind(-0.49, 0.05, 0.7, -0.7), 0.05, 0, -0.7)  # nodes of one grid mirror the other's
            pins = ("--pin", f"x<{place:.12g}m", "--pin", "x<-0.49m", "--pin", "x>0.49m")
            done = subprocess.run([bench.command, "animate", str(asset), "--h", "0.05", *soft, "--damping", "0", "--analytic",
                                   "--fps", "60", "--frames", "60", "--tolerance", tolerance, *pins, "--quiet", "-o", str(out),
                                   "--state", str(bench.folder / "state.h5")], capture_output=True, text=True, check=False)
            if done.returncode:
                raise RuntimeError(done.stderr)
            with h5py.File(bench.folder / "state.h5") as file:
                end = End(file["grid/rest"][:], file["steps/x"][-1] - file["grid/rest"][:], file["grid/corners"][:].astype(np.int64),
                          np.zeros(0), np.zeros(0), 0, {})
            clips.append([end.at((sign * x, 0.07, 0.12)) * (sign, 1, 1) for x in (-0.4, -0.25, -0.1, 0.2, 0.4, 0.49)])
        a, b = np.array(clips)
        rows.append({"tolerance": tolerance, "off": float(np.abs(a - b).max() / np.abs(a).max()), "motion": float(np.abs(a).max())})
    return rows


def iterations(bench: Bench) -> list[Row]:
    """V-cycles of a swinging bar on grids that cut its borders, and on one that fits them."""
    soft, rows = ("--young", "2e5", "--poisson", "0.3", "--density", "1000"), []
    for mode in ("quasi", "newton"):
        counts = {}
        for offset in FEW:
            counts[offset] = Bar(bench).run("network", 0.05, offset, *ENDS,
                                            "--solver", mode, frames=24, fps=60, tolerance=1e-3, body=soft).inner
        fit = Bar(bench, 1.02).run("network", 0.05, 0, "--pin", "x<0.01m", "--pin", "x>1.01m", "--solver", mode,
                                   frames=24, fps=60, tolerance=1e-3, body=soft).inner
        rows.append({"solver": mode, "fit": fit, "cut": [counts[o] for o in FEW if o]})
    return rows


PARTS: dict[str, Callable[[Bench], list[Row]]] = {"sagging": sagging, "pulled": pulled, "shaped": shaped, "special": special,
                                                  "mirrored": mirrored, "iterations": iterations}


def header() -> Row:
    """Where and when it was measured."""
    def said(*words: str) -> str:
        return subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    cpu = next((line.partition(":")[2].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("model name")), "")
    return {"commit": said("git", "rev-parse", "--short=12", "HEAD"), "date": said("date", "+%Y-%m-%d"), "cpu": cpu}


def main() -> int:
    """Prints the rows, and writes them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    given = parser.parse_args()
    kept = json.loads(given.json.read_text())["parts"] if given.json and given.json.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(given.command, Path(folder))
        for name in given.only:
            kept[name] = PARTS[name](bench)
            print(name, *kept[name], sep="\n  ", flush=True)
    if given.json:
        given.json.write_text(json.dumps({"header": header(), "parts": kept}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
