# SPDX-License-Identifier: Apache-2.0
"""Runs the command on a scene file and reads what it wrote: exit code, time, memory, state file."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
HERE = Path(__file__).resolve().parent
# runs the words in a process whose memory before them is small, and writes "exit code, peak kB"
LAUNCHER = ("import os, sys; child = os.fork(); child or os.execv(sys.argv[2], sys.argv[2:]); "
            "_, status, usage = os.wait4(child, 0); open(sys.argv[1], 'w').write("
            "f'{os.waitstatus_to_exitcode(status)} {usage.ru_maxrss}')")
KILLED = -999  # exit code of what ran past its time


@dataclass(frozen=True)
class Finished:
    """A run: exit code (negative: a signal), wall time [s], peak memory [bytes], its folder."""

    words: tuple[str, ...]
    code: int
    seconds: float
    peak: int
    out: str
    err: str
    folder: Path

    @cached_property
    def state(self) -> dict[str, Any]:
        """Every dataset by its place in the state file, and the attributes of the root."""
        found: dict[str, Any] = {}
        with h5py.File(self.folder / "state.h5") as file:
            file.visititems(lambda name, node: found.update({name: node[()]})
                            if isinstance(node, h5py.Dataset) else None)
            return found | dict(file.attrs)

    @property
    def rest(self) -> Floats:
        """Rest positions [m], (nodes, 3)."""
        return self.state["grid/rest"]

    @property
    def mass(self) -> Floats:
        """[kg], (nodes,)."""
        return self.state["grid/mass"]

    @property
    def u(self) -> Floats:
        """Displacements [m], (records, nodes, 3)."""
        return self.state["steps/x"] - self.rest

    @property
    def v(self) -> Floats:
        """Velocities [m/s], (records, nodes, 3)."""
        return self.state["steps/v"]


def launch(words: Sequence[str], folder: Path, timeout: float) -> Finished:
    """Runs words in a folder; a run that takes longer than `timeout` seconds is killed."""
    note = folder / "launch.txt"
    start = time.monotonic()
    with subprocess.Popen([sys.executable, "-I", "-S", "-c", LAUNCHER, str(note), *words],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          errors="replace", start_new_session=True) as process:
        try:
            out, err = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return Finished(tuple(words), KILLED, timeout, 0, "", f"killed after {timeout} s",
                            folder)
    code, kilobytes = note.read_text().split()
    return Finished(tuple(words), int(code), time.monotonic() - start, 1024 * int(kilobytes), out,
                    err, folder)


def run_scene(binary: Path, verb: str, scene: Path, options: Sequence[str], folder: Path,
              timeout: float = 600) -> Finished:
    """`elastogen VERB --scene SCENE OPTIONS`, animation, state, log and report in a folder.

    A study writes its own files there instead.
    """
    folder.mkdir(parents=True, exist_ok=True)
    words = [str(binary.resolve()), verb, "--scene", str(scene), *options, "--quiet"]
    outputs = {"-o": "out.pc2", "--state": "state.h5", "--log-json": "log.json",
               "--report": "report.json"}
    for option, name in ({"--folder": "."} if verb == "study" else outputs).items():
        words += [option, str(folder / name)]
    return launch(words, folder, timeout)
