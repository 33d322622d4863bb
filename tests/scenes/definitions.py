# SPDX-License-Identifier: Apache-2.0
"""The hash of what a result was computed from: results older than their definitions are found."""

from __future__ import annotations

import datetime
import hashlib
import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def definitions_hash(paths: Sequence[str]) -> str:
    """SHA-256 over the names and contents of files, paths from the repository's root.

    Includes and lines of comment are left out: a header that moves and a sentence that is put better
    change no result."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        left_out = (b"#",) if path.endswith((".py", ".toml")) else (b"#include", b"//")
        lines = (ROOT / path).read_bytes().split(b"\n")
        content = b"\n".join(line for line in lines if not line.lstrip().startswith(left_out))
        digest.update(path.encode() + b"\0" + content + b"\0")
    return digest.hexdigest()


def scene_files(stems: Sequence[str]) -> list[str]:
    """The scene files of tests/scenes/verification and the shapes that they name."""
    folder = "tests/scenes/verification"
    paths = []
    for stem in stems:
        text = (ROOT / folder / f"{stem}.toml").read_text()
        paths.append(f"{folder}/{stem}.toml")
        if shape := text.partition('file = "')[2].partition('"')[0]:
            paths.append(f"{folder}/{shape}")
    return sorted(set(paths))


def run_header() -> dict[str, str]:
    """Commit, day and processor of a run that begins now."""
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], capture_output=True,
                            text=True, check=True, cwd=ROOT).stdout.strip()
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return {"commit": commit, "date": datetime.date.today().isoformat(),
            "cpu": cpu[1] if cpu else "unknown"}
