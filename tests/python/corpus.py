# SPDX-License-Identifier: Apache-2.0
"""Files that lie or end early: what a case is, and how one is run and measured."""

from __future__ import annotations

import os
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from command import BINARY

LONG = 100_000_000  # bytes that `fill` is repeated to
CUTS = 32  # of a file, evenly over its bytes
# Limits of a file's cost. Seconds of CPU: the worst, 100 MB of base64, takes 8 to 14 by the
# machine; a cost that grows faster than the file takes minutes.
SECONDS, MEBIBYTES = 60.0, 1024.0


@dataclass(frozen=True)
class Case:
    """A file and what must come of it."""

    name: str
    content: bytes  # @FOLDER@ in it becomes the folder above that of the file
    words: str = ""  # in the message, or in the output for a file that is read
    codes: tuple[int, ...] = (3,)
    fill: bytes = b""  # repeated behind the content up to LONG bytes
    tail: bytes = b""  # behind that
    beside: dict[str, bytes] = field(default_factory=dict)  # further files, from the file's folder

    def write(self, folder: Path) -> Path:
        """The file in folder/in."""
        path = folder / "in" / self.name
        path.parent.mkdir()
        for name, content in self.beside.items():
            (path.parent / name).write_bytes(content)
        block = self.fill * (1 + (1 << 20) // max(len(self.fill), 1))
        with path.open("wb") as file:
            file.write(self.content.replace(b"@FOLDER@", str(folder).encode()))
            for _ in range(LONG // len(block) if self.fill else 0):
                file.write(block)
            file.write(self.tail)
        return path


@dataclass(frozen=True)
class Outcome:
    """How the command ended; the memory is that of the process or of the reader, if that had more."""

    code: int
    out: str
    err: str
    seconds: float
    mebibytes: float


def measured(words: list[object]) -> Outcome:
    """Runs a command, which is killed after two minutes."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen([str(word) for word in words], stdout=out, stderr=err,
                                   stdin=subprocess.DEVNULL)
        clock = threading.Timer(120, process.kill)
        clock.start()
        _, status, usage = os.wait4(process.pid, 0)
        clock.cancel()
        seconds = usage.ru_utime + usage.ru_stime
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
    return Outcome(process.returncode, texts[0], texts[1], seconds, usage.ru_maxrss / 1024)


def command_for(path: Path) -> list[object]:
    """The cheapest command that reads all of a file."""
    if path.suffix in (".toml", ".json"):
        return [BINARY, "animate", "--scene", path, "-o", path.with_suffix(".glb"), "--quiet"]
    return [BINARY, "doctor", path, "--voxels", 4]


def complaints(case: Case) -> tuple[Outcome, list[str]]:
    """Runs a case. Gives what came and what of it is wrong."""
    with tempfile.TemporaryDirectory() as name:
        path = case.write(Path(name))
        before = sorted(Path(name).rglob("*"))
        done = measured(command_for(path))
        wrong = []
        if done.code not in case.codes:
            wrong.append(f"exit code {done.code}, expected {case.codes}")
        if done.code == 0:
            text = done.out
        else:
            text = done.err.replace(str(path), "FILE", 1)
            # a scene may be well and the asset that it names missing beside it
            scene = path.suffix in (".toml", ".json") and done.code == 3
            begins = f"elastogen: {path.parent}/" if scene else "elastogen: FILE"
            if not text.startswith(begins) or text.count("\n") != 1:
                wrong.append("no sentence that begins with the file's name")
        if case.words not in text:
            wrong.append(f"lacks {case.words!r}")
        if done.seconds > SECONDS or done.mebibytes > MEBIBYTES:
            wrong.append("is too expensive")
        if sorted(Path(name).rglob("*")) != before:
            wrong.append("wrote files")
    if wrong:
        wrong.append(f"{done.seconds:.1f} s, {done.mebibytes:.0f} MiB: {done.err or done.out}")
    return done, wrong


def written(write: Callable[..., Path], name: str, *arguments: Any) -> bytes:
    """What a writer of command.py writes."""
    with tempfile.TemporaryDirectory() as folder:
        return write(Path(folder) / name, *arguments).read_bytes()


def cuts(stem: str, ending: str, whole: bytes, *, codes: tuple[int, ...] = (3,),
         may_lack: int = 0) -> Iterator[Case]:
    """The file cut at every byte, or at CUTS of them. @param may_lack  bytes of no meaning at its
    end."""
    last = len(whole) - 1 - may_lack
    for k in sorted({1 + (last - 1) * k // (CUTS - 1) for k in range(CUTS)}):
        yield Case(f"{stem}_cut_{k}.{ending}", whole[:k], "", codes)


def read_anyhow(stem: str, ending: str, text: bytes) -> Iterator[Case]:
    """A text with a byte order mark and CRLF, which are read."""
    yield Case(f"{stem}_mark.{ending}", b"\xef\xbb\xbf" + text, "usable", (0,))
    yield Case(f"{stem}_crlf.{ending}", text.replace(b"\n", b"\r\n"), "usable", (0,))


def with_bytes(whole: bytes, offset: int, part: bytes) -> bytes:
    """The file with other bytes at an offset."""
    return whole[:offset] + part + whole[offset + len(part):]
