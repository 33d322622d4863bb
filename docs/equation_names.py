# SPDX-License-Identifier: Apache-2.0
"""The names in docs/equations.md: each stands in the file that the page names for it."""

from __future__ import annotations

import re
from pathlib import Path


def missing_names(root: Path) -> list[str]:
    """A message for each file that is not there and each name that its file does not have."""
    page = root / "docs" / "equations.md"
    faults = []
    for path, name in re.findall(r"`([\w/]+\.\w+)` `(\w+)`", page.read_text()):
        if not (root / path).exists():
            faults.append(f"docs/equations.md: there is no file {path}")
        elif not re.search(rf"\b{name}\b", (root / path).read_text()):
            faults.append(f"docs/equations.md: {path} has no {name}")
    return faults
