# SPDX-License-Identifier: Apache-2.0
"""A cube that hangs by its top: what is pinned stays, and the bottom swings about its sag.

    check_clip.py CLIP.glb

The sag of a bar under its weight is rho g L^2 / 2E; one that is let go swings to twice that, less
what the time scheme damps."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
from glb_file import frame_count, read_document, world_positions  # noqa: E402

LENGTH, YOUNG, DENSITY = 0.3, 2e4, 1050.0  # of clip.cpp, its jelly
SAG = DENSITY * 9.81 * LENGTH**2 / (2 * YOUNG)

document = read_document(Path(sys.argv[1]))
frames = [np.concatenate(list(world_positions(document, f).values()))
          for f in range(frame_count(document))]
height = frames[0][:, 1]
top, bottom = height > height.max() - 1e-6, height < height.min() + 1e-6
held = max(np.abs(x[top] - frames[0][top]).max() for x in frames)
deepest = max((height - x[:, 1])[bottom].max() for x in frames)
print(f"{len(frames)} frames, the top moves {held:.1e} m, the bottom {deepest / SAG:.2f} of its sag")
if len(frames) != 11 or held > 1e-6 or not 1 < deepest / SAG < 2.1:
    sys.exit(1)
