#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Times of clean builds of commits, without a compiler cache, one after the other.

    bench/build_time.py COMMIT [COMMIT ...] [--jobs 2] [--preset cpu]

Each commit is cloned and built as `cmake --preset cpu && ninja` does it. The CPU time is that of all
compilers and linkers; compare it rather than the wall time where other programs run."""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path


def lines_of(tree: Path) -> int:
    """Lines of C++ and CUDA."""
    names = subprocess.run(["git", "ls-files", "*.hpp", "*.cpp", "*.cu", "*.cuh"], cwd=tree, check=True,
                           capture_output=True, text=True).stdout.split()
    return sum((tree / name).read_bytes().count(b"\n") for name in names)


def build(commit: str, preset: str, jobs: int) -> None:
    """Clones, configures and builds a commit, and prints what that took."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "elastogen"
        quiet = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        subprocess.run(["git", "clone", ".", tree], cwd=Path(__file__).parent.parent, **quiet)
        subprocess.run(["git", "checkout", commit], cwd=tree, **quiet)
        subprocess.run(["cmake", "--preset", preset], cwd=tree, **quiet)
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        subprocess.run(["ninja", "-C", f"build/{preset}", f"-j{jobs}"], cwd=tree,
                       env={**os.environ, "CCACHE_DISABLE": "1"}, **quiet)
        wall, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        print(f"{commit}: {lines_of(tree)} lines, {cpu:.0f} s of CPU, {wall / 60:.1f} min", flush=True)


def main() -> None:
    """Reads the options and builds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("commits", nargs="+", metavar="COMMIT")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--preset", default="cpu")
    options = parser.parse_args()
    for commit in options.commits:
        build(commit, options.preset, options.jobs)


if __name__ == "__main__":
    main()
