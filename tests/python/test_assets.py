# SPDX-License-Identifier: Apache-2.0
"""Animates every file of a folder (ELASTOGEN_ASSETS) and checks what comes out against the file.

The table is printed and, where ELASTOGEN_ASSET_TABLE names a file, written to it as Markdown."""

from __future__ import annotations

import json
import os
import tempfile
import time
import unittest
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import glb_check
import kept
from command import Run, animate
from glb_file import GlbError, frame_count, read_document

READ = {".obj", ".ply", ".stl", ".glb", ".gltf", ".off", ".xyz", ".pcd", ".las", ".splat", ".spz",
        ".fbx", ".dae", ".3ds", ".vdb"}
OPTIONS = ("--voxels", 24, "--frames", 10, "--material", "jelly", "--pin", "y<5%", "--threads", 1,
           "--max-time", "60s")
SECONDS = 120  # for one file, after which it hangs
AT_ONCE = 2


@dataclass(frozen=True)
class Row:
    """A file, what became of it, and what is wrong with that ("" for nothing)."""

    name: str
    code: int
    voxels: int
    seconds: float
    converged: float
    note: str
    fault: str

    def cells(self) -> list[str]:
        """As printed; a refused file has no numbers."""
        numbers = ["", "", ""]
        if self.code in (0, 4):
            numbers = [str(self.voxels), f"{self.seconds:.1f}", f"{100 * self.converged:.0f} %"]
        return [self.name, *numbers, str(self.code), self.fault or self.note]


HEAD = ("name", "voxels", "seconds", "converged", "exit code", "note")


def table(rows: Iterable[Row]) -> str:
    """Markdown."""
    lines = ["| " + " | ".join(cells) + " |" for cells in (
        HEAD, ["---"] * len(HEAD), *(row.cells() for row in rows))]
    return "\n".join(lines) + "\n"


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


def check_animated(source: Path, output: Path, frames: int) -> str:
    """What of the output is wrong, or ""."""
    try:
        document = read_document(output)
        glb_check.check_animation(document)
        kept.check_kept(source, document)
    except GlbError as error:
        return f"the output is wrong: {error}"
    found = frame_count(document)
    return "" if found == frames + 1 else f"{found} frames are in the output, not {frames + 1}"


def judge(source: Path, name: str) -> Row:
    """Runs one file."""
    with tempfile.TemporaryDirectory() as text:
        folder, start = Path(text), time.monotonic()
        output, report = folder / "out.glb", folder / "report.json"
        done = animate(source, output, *OPTIONS, "--report", report, timeout=SECONDS)
        seconds, note = time.monotonic() - start, last_line(done, source.name)
        if done.code == 3:
            return Row(name, 3, 0, seconds, 0, note, check_refused(source, folder, done))
        if done.code not in (0, 4) or source.suffix.lower() not in READ:
            fault = f"the exit code is {done.code}: {note}"
            return Row(name, done.code, 0, seconds, 0, note, fault)
        said = json.loads(report.read_text())
        fault = check_animated(source, output, said["frames"])
        clean = said["converged_share"] == 1 and said["min_j"] > 0
        if (done.code == 0) != clean:
            fault = fault or f"exit code {done.code}, but the report says otherwise"
        if said["converged_share"] < 1:
            note = f"worst residual {said['worst_residual']:.1e}"
        return Row(name, done.code, said["voxels"], seconds, said["converged_share"], note, fault)


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
        if target := os.environ.get("ELASTOGEN_ASSET_TABLE"):
            Path(target).write_text(table(rows))
        for row in rows:
            with self.subTest(row.name):
                self.assertEqual(row.fault, "")


if __name__ == "__main__":
    unittest.main()
