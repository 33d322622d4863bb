#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Drops every closed mesh of a folder as sand, snow and clay on a floor, and looks at what is left.

    tests/scenes/particle_assets.py --binary build/cpu/elastogen [--assets FOLDER] [--short]
                                    [--jobs 1] [--json docs/results/particle_assets.json]

Without a folder (default: ELASTOGEN_ASSETS) or with --short a cube of its own takes the place of the
assets. A row is wrong if the command ends by a signal or a code that is not documented for it, a
number of the last frame is not finite, or the particles' mass is not that of the filled voxels, as an
elastic run on the same voxels has it. Drafts are counted, not wrong. Exit status 1 if a row is wrong."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from definitions import definitions_hash, run_header

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
from particle_files import read_vtu  # noqa: E402

FILES = ["tests/scenes/particle_assets.py"]
MESHES = {".obj", ".ply", ".stl", ".glb", ".gltf", ".off", ".fbx", ".dae", ".3ds", ".vdb"}
MATERIALS = ("sand", "snow", "clay")
BODY = ("--size", "20cm", "--up", "y")
DROP = ("--method", "mpm", "--floor", "--velocity", "0,-1,0", "--quiet")
CUBE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n" + "".join(
    f"f {face}\n" for face in ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"))


def is_closed(binary: Path, asset: Path) -> bool:
    """What doctor says of a file."""
    done = subprocess.run([binary, "doctor", asset, "--json", "--voxels", "16"], capture_output=True,
                          text=True, check=False)
    said = json.loads(done.stdout) if done.stdout.startswith("{") else {}
    return bool(said.get("usable") and said.get("closed"))


def filled_volume(options: argparse.Namespace, asset: Path, state: Path) -> float:
    """Volume of the filled voxels [m^3], by the nodes' masses of an elastic run that does not move; the
    floor has the voxels lie as in the other runs."""
    subprocess.run([options.binary, "animate", asset, *BODY, "--voxels", str(options.voxels), "--frames",
                    "1", "--density", "1", "--gravity", "0,0,0", "--floor", "--quiet", "--state", state,
                    "-o", state.with_suffix(".pc2")], capture_output=True, check=True)
    with h5py.File(state) as file:
        return float(file["grid/mass"][()].sum())


def row_of(asset: Path, name: str, material: str, options: argparse.Namespace,
           volume: float) -> dict[str, Any]:
    """One run and what it left."""
    with tempfile.TemporaryDirectory() as text:
        folder, start = Path(text), time.monotonic()
        done = subprocess.run(
            [options.binary, "animate", asset, *BODY, *DROP, "--voxels", str(options.voxels), "--frames",
             str(options.frames), "--material", material, "--max-time", f"{options.max_time}s",
             *(("--threads", "1") if options.jobs > 1 else ()), "-o", folder / "p.pvd", "--report", folder / "report.json"],
            capture_output=True, text=True, check=False)
        row: dict[str, Any] = {"asset": name, "material": material, "code": done.returncode,
                               "seconds": round(time.monotonic() - start, 2)}
        if done.returncode not in (0, 4, 5):
            return row | {"fault": done.stderr.strip().splitlines()[-1] if done.stderr else "no message"}
        said = json.loads((folder / "report.json").read_text())
        last = read_vtu(sorted(folder.glob("p_*.vtu"))[-1])
        density = said["materials"][0]["density"]
        finite = all(np.isfinite(values).all() for values in last.values())
        mass = float(last["mass"].sum(dtype=float)) / (density * volume)
        row |= {"particles": len(last["mass"]), "frames": said["frames"], "steps": said["steps"],
                "certified": round(said["converged_share"] * said["steps"]),
                "residual": said["worst_residual"], "finite": finite, "mass": mass,
                "least_j": float(last["J"].min()),
                "fastest": float(np.linalg.norm(last["velocity"], axis=1).max())}
        # masses are floats in the file
        wrong = [] if finite else ["a number is not finite"]
        wrong += [] if abs(mass - 1) < 1e-5 else [f"mass is {mass:.6f} of the fill"]
        return row | {"fault": "; ".join(wrong)}


def assets_of(options: argparse.Namespace, folder: Path) -> list[tuple[Path, str]]:
    """Files and their names."""
    if options.short or not options.assets:
        cube = folder / "cube.obj"
        cube.write_text(CUBE)
        return [(cube, "cube.obj")]
    files = sorted(path for path in options.assets.rglob("*") if path.suffix.lower() in MESHES)
    return [(path, str(path.relative_to(options.assets))) for path in files
            if is_closed(options.binary, path)]


def rows_of(options: argparse.Namespace, folder: Path) -> list[dict[str, Any]]:
    """All runs, --jobs at a time; the file has those that have ended."""
    version = subprocess.run([options.binary, "--version"], capture_output=True, text=True,
                             check=True).stdout
    assets = assets_of(options, folder)
    ended: dict[tuple[str, str], dict[str, Any]] = {}
    rows: list[dict[str, Any]] = []
    with ThreadPoolExecutor(options.jobs) as pool:
        volumes = {name: pool.submit(filled_volume, options, asset, folder / f"{k}.h5")
                   for k, (asset, name) in enumerate(assets)}
        runs = [pool.submit(row_of, asset, name, material, options, volumes[name].result())
                for asset, name in assets for material in MATERIALS]
        for run in as_completed(runs):
            row = run.result()
            ended[row["asset"], row["material"]] = row
            print(json.dumps(row), flush=True)
            rows = [ended[name, material] for _, name in assets for material in MATERIALS
                    if (name, material) in ended]
            if options.json:  # what there is, should the run be ended
                result = {"header": run_header() | {
                    "commit": version.split()[-1].strip("()"), "voxels": options.voxels,
                    "frames": options.frames, "max_time": options.max_time, "jobs": options.jobs,
                    "run": " ".join(BODY + DROP)}, "rows": rows,
                    "definitions": {"files": FILES, "sha256": definitions_hash(FILES)}}
                options.json.write_text(json.dumps(result, indent=1) + "\n")
    return rows


def main() -> int:
    """Runs all, prints a line each."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--binary", type=Path, required=True)
    parser.add_argument("--assets", type=Path, default=os.environ.get("ELASTOGEN_ASSETS") or None)
    parser.add_argument("--voxels", type=int, default=32)
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--max-time", type=float, default=300)
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time, of one thread each if many")
    parser.add_argument("--short", action="store_true", help="a cube at 6 voxels, 3 frames")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    if options.short:
        options.voxels, options.frames = 6, 3
    with tempfile.TemporaryDirectory() as text:
        rows = rows_of(options, Path(text))
    return int(not rows or any(row["fault"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
