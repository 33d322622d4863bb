# SPDX-License-Identifier: Apache-2.0
"""Opens outputs of `elastogen animate` in programs of others and compares what they show with the
point cache of the same run. How to install the programs: README.md.

    python3 run.py --binary build/cpu/elastogen --out /tmp/clients \\
        --program blender=venv/bin/python --program three=three/index.js
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "python"))
from bake import Baker  # noqa: E402
from client_job import Job, Values  # noqa: E402
from point_cache import Result, compare, in_gltf_axes, read_pc2  # noqa: E402
from glb_file import read_document, record  # noqa: E402
from inputs import INPUTS, PROFILES, Input, animate  # noqa: E402

TOLERANCE = 1e-3  # of positions, as a share of the longest edge
SHADING = 5.0  # of pictures: the difference in 0..255 that 99 % of the pixels do not exceed
OUTLINE = 5e-3  # share of pixels: half a pixel around a body, the tolerance there
LIMITS = {"f3d": 4, "filament": 256, "three r111": 4}  # targets that a client plays
SECONDS = 240  # for one client and one output


@dataclass(frozen=True)
class Client:
    """A program of others, its script, the module by which an interpreter is found to have it."""

    name: str
    script: str
    module: str
    pictures: bool = False  # pictures are compared, not positions
    source: str = ""  # only inputs whose file ends so are opened


CLIENTS = (
    Client("reader", "own_reader.py", "numpy"),
    Client("blender", "blender_glb.py", "bpy"),
    Client("blender-pc2", "blender_pc2.py", "bpy", source=".obj"),
    Client("vtk", "vtk_glb.py", "vtk"),
    Client("f3d", "f3d_glb.py", "f3d", pictures=True),
    Client("trimesh", "trimesh_glb.py", "trimesh"),
    Client("filament", "filament_glb.py", "filly", pictures=True),
    Client("three", "three_glb.py", ""),
)


@dataclass(frozen=True)
class Column:
    """A client and one installation of it."""

    client: Client
    program: str
    number: int  # of the installation

    def command(self, job: Path) -> list[str]:
        """That opens a job."""
        script = str(HERE / self.client.script)
        if self.client.name == "three":
            return [sys.executable, script, str(job), self.program]
        if Path(self.program).name.startswith("blender"):
            return [self.program, "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                    script, "--", str(job)]
        return [self.program, script, str(job)]

    def missing(self) -> str:
        """Why it cannot run, or an empty text."""
        if self.client.name == "three":
            found = Path(self.program).exists() and (shutil.which("chromium")
                                                     or shutil.which("chromium-browser"))
            return "" if found else f"no chromium or no {self.program}"
        if Path(self.program).name.startswith("blender"):
            return "" if shutil.which(self.program) else f"there is no {self.program}"
        try:
            done = subprocess.run([self.program, "-c", f"import {self.client.module}"],
                                  capture_output=True, check=False)
        except OSError:
            return f"there is no {self.program}"
        return "" if done.returncode == 0 else f"{self.program} has no {self.client.module}"


@dataclass
class Cell:
    """What became of an output in a client."""

    output: str
    client: str
    verdict: str  # ok, FAIL, error, skipped; limit: the client's own, as docs/formats.md has it
    text: str
    version: str = "?"
    notes: list[str] = field(default_factory=list)
    frames: dict[str, Any] = field(default_factory=dict)


def columns_of(options: argparse.Namespace) -> list[Column]:
    """The clients asked for; those that cannot run are named in a line."""
    given: dict[str, list[str]] = {}
    for word in options.program:
        name, _, program = word.partition("=")
        given.setdefault(name, []).append(program)
    result = []
    for client in CLIENTS:
        if options.clients and client.name not in options.clients:
            continue
        programs = given.get(client.name.removesuffix("-pc2"))
        if not programs:
            programs = ["/usr/share/javascript/three"] if client.name == "three" else [
                sys.executable]
            if client.module == "bpy" and shutil.which("blender"):
                programs.append("blender")
        for column in (Column(client, program, k) for k, program in enumerate(programs)):
            why = column.missing()
            if why:
                print(f"{client.name}: not installed ({why})", file=sys.stderr)
            else:
                result.append(column)
    return result


@dataclass
class Output:
    """A GLB and a point cache of one run."""

    name: str
    source: Path
    stem: Path
    job: Job
    cache: Values  # in the axes and numbers of the GLB
    own_cache: Values  # as the file has it
    first: bool  # of the profiles: the point cache is opened once


def make_output(options: argparse.Namespace, item: Input, source: Path, profile: str,
                bake: bool) -> Output:
    """Runs the animation unless its files are there and may be reused. @throws RuntimeError."""
    name = f"{item.name}.{profile}"
    stem = options.out / name
    if not (options.reuse and stem.with_name(name + ".glb").exists()):
        print(f"{name}: animating", file=sys.stderr, flush=True)
        fault = animate(options.binary, item, source, profile, stem)
        if fault:
            raise RuntimeError(fault)
    own = read_pc2(Path(f"{stem}.pc2"))
    cache = in_gltf_axes(own, 1.0, item.up)
    frames = np.unique(np.linspace(0, len(cache) - 1, options.frames).astype(int)).tolist()
    baked = {}
    if bake:
        baker = Baker(read_document(Path(f"{stem}.glb")), cache)
        for frame in frames:
            path = Path(f"{stem}.{frame}.glb")
            path.write_bytes(baker.glb(frame))
            baked[str(frame)] = str(path)
    low, high = cache[frames].min((0, 1)), cache[frames].max((0, 1))
    bounds = [*((low + high) / 2).tolist(), float(np.linalg.norm(high - low) / 2)]
    job = Job(f"{stem}.glb", f"{stem}.pc2", str(source), item.fps, frames, baked, bounds, "")
    return Output(name, source, stem, job, cache, own, profile == options.profiles[0])


def positions_cell(cell: Cell, folder: Path, output: Output, client: Client) -> None:
    """Judges a client that shows positions."""
    shown: dict[int, list[Values]] = {}
    with np.load(folder / "positions.npz") as arrays:
        for key in arrays.files:
            shown.setdefault(int(key.split(":")[0]), []).append(arrays[key])
    cache = output.own_cache if client.source else output.cache
    result: Result = compare(shown, cache)
    cell.frames = {str(frame): error for frame, error in result.errors.items()}
    cell.notes += result.faults
    good = result.largest() <= TOLERANCE and not result.faults
    cell.verdict = "ok" if good else "FAIL"
    alone = " (rest)" if set(result.errors) == {0} else ""
    cell.text = f"{result.largest():.1e}{alone}"
    if result.faults and result.largest() <= TOLERANCE:
        cell.text = result.faults[0]


def pictures_cell(cell: Cell, pictures: dict[str, dict[str, float]]) -> None:
    """Judges a client that draws."""
    cell.frames = pictures
    mean, most, outline = (max(p[key] for p in pictures.values())
                           for key in ("mean", "most", "outline"))
    cell.verdict = "ok" if most <= SHADING and outline <= OUTLINE else "FAIL"
    cell.text = f"{mean:.1f}, {most:.0f}; {100 * outline:.2f} %"


def limit_of(cell: Cell, output: Output) -> str:
    """A known limit of the client that this output exceeds (docs/formats.md), or an empty text."""
    document = read_document(Path(output.job.glb))
    primitives = [p for mesh in document.items("meshes") for p in mesh["primitives"]]
    targets = max(len(p.get("targets", [])) for p in primitives)
    version = f" {cell.version}" if cell.client == "three" else ""
    most = LIMITS.get(cell.client + version, targets)
    if targets > most:
        return f"{targets} targets, it plays {most}"
    bare = any("NORMAL" not in p["attributes"] for p in primitives if "targets" in p)
    if cell.client == "filament" and bare and record(document)["profile"] == "modal":
        return "no normals: it makes its own for each target"
    return ""


def open_in(column: Column, output: Output) -> Cell:
    """Runs a client on an output in a process of its own and judges its answer."""
    client = column.client
    cell = Cell(output.name, client.name, "skipped", "–")
    if client.source and not (output.source.suffix == client.source and output.first):
        return cell
    folder = output.stem.with_name(f"{output.name}.{client.name}.{column.number}")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "result.json").unlink(missing_ok=True)
    job = folder / "job.json"
    job.write_text(json.dumps({**asdict(output.job), "folder": str(folder)}))
    try:
        done = subprocess.run(column.command(job), capture_output=True, text=True, check=False,
                              timeout=SECONDS, cwd=folder)
        log = done.stdout + done.stderr
    except subprocess.TimeoutExpired:
        log = f"no answer within {SECONDS} s"
    (folder / "log.txt").write_text(log)
    if not (folder / "result.json").exists():
        cell.verdict, cell.text = "error", "error"
        cell.notes = [line for line in log.strip().splitlines() if line.strip()][-1:]
        return cell
    answer = json.loads((folder / "result.json").read_text())
    cell.version, cell.notes = answer["version"], answer["notes"]
    if client.pictures:
        pictures_cell(cell, answer["pictures"])
    else:
        positions_cell(cell, folder, output, client)
    limit = limit_of(cell, output) if cell.verdict == "FAIL" else ""
    if limit:
        cell.verdict, cell.notes = "limit", [*cell.notes, limit]
    return cell


def table(columns: list[Column], rows: dict[str, list[Cell]]) -> str:
    """Markdown: a row for each output, a column for each client with its version."""
    heads = []
    for k, column in enumerate(columns):
        versions = [cells[k].version for cells in rows.values() if cells[k].version != "?"]
        heads.append(f"{column.client.name} {versions[0] if versions else '?'}")
    lines = ["| output | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    for name, cells in rows.items():
        marks = {"FAIL": "**", "error": "**", "limit": "*"}
        shown = [marks.get(c.verdict, "") + c.text + marks.get(c.verdict, "") for c in cells]
        lines.append(f"| {name} | " + " | ".join(shown) + " |")
    lines += ["", "Positions: largest error as a share of the longest edge. f3d, filament: mean"
              " difference of shading in 0..255", "and what 99 % of the pixels do not exceed; pixels"
              " that differ at the outline.", "Bold: beyond the tolerance, or no answer. Italic:"
              " beyond it for a limit of the client."]
    return "\n".join(lines)


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", type=Path, required=True, help="the program elastogen")
    parser.add_argument("--out", type=Path, required=True, help="folder for outputs and answers")
    parser.add_argument("--clients", nargs="+", choices=[c.name for c in CLIENTS])
    parser.add_argument("--program", action="append", default=[], metavar="CLIENT=PROGRAM",
                        help="interpreter that has a client, or blender, or three.js; repeatable")
    parser.add_argument("--assets", nargs="+", choices=[item.name for item in INPUTS])
    parser.add_argument("--profiles", nargs="+", choices=PROFILES, default=PROFILES)
    parser.add_argument("--frames", type=int, default=3, help="frames that are compared")
    parser.add_argument("--reuse", action="store_true", help="keep outputs that are there")
    return parser.parse_args()


def outputs_of(options: argparse.Namespace, bake: bool) -> list[Output]:
    """All runs; what is missing or fails is named in a line."""
    result = []
    for item in INPUTS:
        if options.assets and item.name not in options.assets:
            continue
        source = item.source(options.out)
        if source is None:
            print(f"{item.name}: {item.path} is not in ELASTOGEN_ASSETS", file=sys.stderr)
            continue
        for profile in options.profiles:
            try:
                result.append(make_output(options, item, source, profile, bake))
            except (RuntimeError, OSError, ValueError) as error:
                print(f"{item.name}.{profile}: {error}", file=sys.stderr)
    return result


def main() -> int:
    """Exit code 1 if a cell fails, 2 if nothing could be opened."""
    options = parse()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    columns = columns_of(options)
    outputs = outputs_of(options, any(column.client.pictures for column in columns))
    if not columns or not outputs:
        print("nothing to open, or nothing to open it in", file=sys.stderr)
        return 2
    rows: dict[str, list[Cell]] = {}
    for output in outputs:
        print(f"{output.name}: opening", file=sys.stderr, flush=True)
        rows[output.name] = [open_in(column, output) for column in columns]
    cells = [cell for row in rows.values() for cell in row]
    text = table(columns, rows)
    print(text)
    (options.out / "table.md").write_text(text + "\n")
    (options.out / "results.json").write_text(json.dumps([asdict(c) for c in cells], indent=1))
    for cell in cells:
        if cell.verdict in ("FAIL", "error"):
            print(f"{cell.verdict}: {cell.output} in {cell.client} {cell.version}: "
                  f"{'; '.join([cell.text, *cell.notes])}", file=sys.stderr)
    return int(any(cell.verdict in ("FAIL", "error") for cell in cells))


if __name__ == "__main__":
    sys.exit(main())
