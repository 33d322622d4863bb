# SPDX-License-Identifier: Apache-2.0
"""What a client is asked to open and what it answers; used inside the client's own interpreter.

A client runs as `PYTHON CLIENT.py JOB.json`. Its answer, `result.json` and `positions.npz` in the
job's folder, holds the positions of each object that it shows in each frame, in the axes of glTF
(y up) and the numbers of the file, or, of clients that only draw, the differences of pictures.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[Any]


@dataclass(frozen=True)
class Job:
    """One output to open."""

    glb: str  # animated GLB
    pc2: str  # point cache of the same run
    source: str  # the asset that was animated
    fps: int
    frames: list[int]  # to be compared
    baked: dict[str, str]  # by frame: a GLB without animation in the pose of that frame
    bounds: list[float]  # x y z of the centre and the radius of a ball about all frames
    folder: str  # for the answer

    def seconds(self, frame: int) -> float:
        """The time of a frame as the float32 key has it."""
        return float(np.float32(frame / self.fps))


def load_job() -> tuple[Job, list[str]]:
    """The job that the last words of the command line name, and the words after it."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    return Job(**json.loads(Path(words[0]).read_text())), words[1:]


@dataclass
class Answer:
    """What a client shows; written by save()."""

    version: str
    notes: list[str] = field(default_factory=list)
    pictures: dict[str, dict[str, float]] = field(default_factory=dict)  # by frame
    _arrays: dict[str, Values] = field(default_factory=dict)

    def show(self, frame: int, positions: Sequence[float] | Values) -> None:
        """One object of a frame, positions (vertices, 3) in world space."""
        array = np.asarray(positions, np.float64).reshape(-1, 3)
        self._arrays[f"{frame}:{len(self._arrays)}"] = array

    def save(self, job: Job) -> None:
        """Writes the answer into the job's folder."""
        np.savez(Path(job.folder) / "positions.npz", **self._arrays)
        text = json.dumps({"version": self.version, "notes": self.notes,
                           "pictures": self.pictures})
        (Path(job.folder) / "result.json").write_text(text)
