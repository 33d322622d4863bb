# SPDX-License-Identifier: Apache-2.0
"""Animates every file of a folder (ELASTOGEN_ASSETS) and checks what comes out against the file.

The table is printed and, where ELASTOGEN_ASSET_RESULTS names a file, written to it as JSON with date,
commit and machine (docs/results/assets.json, of which docs/generate.py makes the table)."""

from __future__ import annotations

import datetime
import json
import os
import re
import tempfile
import time
import unittest
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import glb_check
import kept
from command import Run, animate, round_trip
from command import run as run_command
from glb_file import Document, GlbError, frame_count, read_document, world_positions
from point_cache import compare, longest_edge, read_pc2

READ = {".obj", ".ply", ".stl", ".glb", ".gltf", ".off", ".xyz", ".pcd", ".las", ".splat", ".spz",
        ".fbx", ".dae", ".3ds", ".vdb"}
OPTIONS = ("--voxels", 24, "--frames", 10, "--material", "jelly", "--pin", "y<5%", "--threads", 1,
           "--max-time", "60s")
SECONDS = 120  # for one file, after which it hangs
LARGEST_ERROR = 1.01e-3  # of a vertex, as a share of the longest edge: the promise, and rounding
AT_ONCE = 2


@dataclass(frozen=True)
class Row:
    """A file, what became of it, and what is wrong with that ("" for nothing)."""

    name: str
    code: int
    voxels: int
    seconds: float
    converged: float
    findings: str
    note: str
    fault: str

    def cells(self) -> list[str]:
        """As printed; a refused file has no numbers."""
        numbers = ["", f"{self.seconds:.1f}", "", ""]
        if self.code in (0, 4):
            numbers = [str(self.voxels), f"{self.seconds:.1f}", f"{100 * self.converged:.0f} %",
                       self.findings]
        return [self.name, *numbers, str(self.code), self.fault or self.note]


HEAD = ("name", "voxels", "seconds", "converged", "found and repaired", "exit code", "note")


def table(rows: Iterable[Row]) -> str:
    """Markdown."""
    lines = ["| " + " | ".join(cells) + " |" for cells in (
        HEAD, ["---"] * len(HEAD), *(row.cells() for row in rows))]
    return "\n".join(lines) + "\n"


def as_json(rows: list[Row], commit: str) -> str:
    """What the table is made of, and of what run it is."""
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    header = {"commit": commit, "date": datetime.date.today().isoformat(),
              "cpu": cpu[1] if cpu else "unknown", "at_once": AT_ONCE,
              "options": " ".join(map(str, OPTIONS))}
    return json.dumps({"header": header, "head": HEAD, "rows": [row.cells() for row in rows]},
                      indent=1, ensure_ascii=False) + "\n"


def last_line(done: Run, name: str) -> str:
    """The last line on standard error, without the program and the file."""
    lines = done.err.strip().splitlines() or [""]
    return lines[-1].removeprefix("elastogen: ").split(f"{name}: ", 1)[-1].replace("|", "/")


def check_refused(source: Path, folder: Path, done: Run) -> str:
    """Why a refusal is not as it should be, or ""."""
    if str(source) not in done.err:
        return f"the message does not name the file: {done.err!r}"
    if source.suffix.lower() not in READ and ".obj .ply .stl .glb .gltf" not in done.err:
        return f"the message does not name what is read: {done.err!r}"
    left = [path.name for path in folder.iterdir()]
    return f"left in the folder: {left}" if left else ""


def under_root(document: Document) -> Document:
    """The document without the scale and turn of a root node, as point caches have it."""
    for node in document.items("nodes"):
        if node.get("name") == "elastogen_root":
            del node["matrix"]
    return document


def check_played(document: Document, cache: Path) -> str:
    """What of the frames that a client shows is not as in the point cache of the run, or ""."""
    positions, document = read_pc2(cache), under_root(document)
    count = len(positions)
    shown = {frame: list(world_positions(document, frame).values())
             for frame in sorted({0, 1, count // 2, count - 1})}
    result = compare(shown, positions)
    # far from the origin the float32 of the cache are coarser than the promise
    coarse = float(np.spacing(np.float32(np.abs(positions[0]).max()))) / longest_edge(positions[0])
    if result.faults:
        return f"a client {result.faults[0]}"
    return "" if result.largest() <= LARGEST_ERROR + 2 * coarse else f"a client is off by {result.errors}"


def check_animated(source: Path, output: Path, frames: int) -> str:
    """What of the output is wrong, or ""."""
    try:
        document = read_document(output)
        glb_check.check_animation(document)
        kept.check_kept(source, document)
    except GlbError as error:
        return f"the output is wrong: {error}"
    if seen := round_trip(output):
        return f"others read the output otherwise: {seen}"
    found = frame_count(document)
    if found != frames + 1:
        return f"{found} frames are in the output, not {frames + 1}"
    return check_played(document, output.with_name("out.pc2"))


def check_sequence(folder: Path, said: dict[str, Any]) -> str:
    """What is wrong with the PLY files of a cloud, or "": finite numbers, one file a frame."""
    files = sorted(folder.glob("out_*.ply"))
    if len(files) != said["frames"] + 1:
        return f"{len(files)} PLY files, not {said['frames'] + 1}"
    for file in files:
        head, body = file.read_bytes().split(b"end_header\n", 1)
        names = re.findall(rb"property (\w+) (\w+)\n", head)
        kinds = {b"float": "<f4", b"double": "<f8", b"char": "i1", b"uchar": "u1", b"short": "<i2",
                 b"ushort": "<u2", b"int": "<i4", b"uint": "<u4"}
        rows = np.frombuffer(body, np.dtype([(n.decode(), kinds[k]) for k, n in names]))
        if len(rows) != said["asset"]["vertices"] or f"element vertex {len(rows)}\n".encode() not in head:
            return f"{file.name} has {len(rows)} points of {said['asset']['vertices']}"
        if not all(np.isfinite(rows[n]).all() for n in rows.dtype.names or ()):
            return f"{file.name} has a number that is not finite"
    return ""


def profiles(source: Path) -> list[str]:
    """Of the GLB: one a file, both over all files; with ELASTOGEN_ALL_PROFILES both of each."""
    both = ["modal", "keyframe"]
    return both if os.environ.get("ELASTOGEN_ALL_PROFILES") else [both[len(source.name) % 2]]


def run(source: Path, folder: Path, profile: str) -> Run:
    """To GLB; a cloud is refused that and told to be written as PLY."""
    report = folder / "report.json"
    done = animate(source, folder / "out.glb", *OPTIONS, "-o", folder / "out.pc2", "--glb-profile",
                   profile, "--report", report, timeout=SECONDS)
    if done.code == 2 and ".ply" in done.err:
        done = animate(source, folder / "out.ply", *OPTIONS, "--report", report, timeout=SECONDS)
    return done


def judge(source: Path, name: str) -> Row:
    """Runs one file; with several profiles the row is that of the first one with a fault."""
    rows = [judge_as(source, name, profile) for profile in profiles(source)]
    return next((row for row in rows if row.fault), rows[0])


def judge_as(source: Path, name: str, profile: str) -> Row:
    """Runs one file with a profile."""
    with tempfile.TemporaryDirectory() as text:
        folder, start = Path(text), time.monotonic()
        done = run(source, folder, profile)
        seconds, note = time.monotonic() - start, last_line(done, source.name)
        if done.code == 3:
            return Row(name, 3, 0, seconds, 0, "", note, check_refused(source, folder, done))
        if done.code not in (0, 4) or source.suffix.lower() not in READ:
            fault = f"the exit code is {done.code}: {note}"
            return Row(name, done.code, 0, seconds, 0, "", note, fault)
        said = json.loads((folder / "report.json").read_text())
        output = folder / "out.glb"
        fault = (check_animated(source, output, said["frames"]) if output.exists()
                 else check_sequence(folder, said))
        findings = ", ".join(f"{f['what']} {f['count']}" for f in said["asset"]["findings"])
        clean = said["converged_share"] == 1 and said["min_j"] > 0
        if (done.code == 0) != clean:
            fault = fault or f"exit code {done.code}, but the report says otherwise"
        if said["converged_share"] < 1:
            note = f"worst residual {said['worst_residual']:.1e}"
        return Row(name, done.code, said["voxels"], seconds, said["converged_share"], findings, note,
                   fault)


class Assets(unittest.TestCase):
    """One row a file."""

    def test_every_asset_is_animated_or_refused_with_a_reason(self) -> None:
        place = os.environ.get("ELASTOGEN_ASSETS", "")
        if not place:
            print("left out: ELASTOGEN_ASSETS names no folder")
            return
        root = Path(place)
        sources = sorted(path for path in root.rglob("*") if path.is_file())
        self.assertTrue(any(path.suffix.lower() in READ for path in sources), f"nothing in {root}")
        with ThreadPoolExecutor(AT_ONCE) as pool:
            rows = list(pool.map(judge, sources, [str(p.relative_to(root)) for p in sources]))
        print(table(rows))
        if target := os.environ.get("ELASTOGEN_ASSET_RESULTS"):
            commit = run_command("--version").out.split()[-1].strip("()")
            Path(target).write_text(as_json(rows, commit))
        for row in rows:
            with self.subTest(row.name):
                self.assertEqual(row.fault, "")


if __name__ == "__main__":
    unittest.main()
