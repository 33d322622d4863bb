# SPDX-License-Identifier: Apache-2.0
"""Our own reader of GLB (tests/python/glb_file.py): is it the file or the client that is wrong?"""

from __future__ import annotations

import sys
from pathlib import Path

from client_job import Answer, load_job

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
from glb_file import read_document, world_positions  # noqa: E402


def main() -> None:
    """Evaluates each frame by the weights at its key and answers."""
    job, _ = load_job()
    document, answer = read_document(Path(job.glb)), Answer("(ours)")
    for frame in job.frames:
        for positions in world_positions(document, frame).values():
            answer.show(frame, positions)
    answer.save(job)


if __name__ == "__main__":
    main()
