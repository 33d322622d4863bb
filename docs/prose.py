# SPDX-License-Identifier: Apache-2.0
"""The lines of prose in the documents: at most 120 characters, so that a change shows in a diff as the
sentence that it is. Tables, code, headings and what cannot be broken (a link, a word) are excepted."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

LONGEST = 120
# a generated table with its markers, or a fenced block of code
BLOCK = re.compile(r"^<!-- table .*?^<!-- end -->$|^( *)```.*?^\1```$", re.S | re.M)
EXCEPTED = re.compile(r"\s*\||#|\s*(?:[-*] )?(?:!?\[[^]]*\]\([^)]*\)[.,]?|\S+)$")


def prose_lines(text: str) -> Iterator[tuple[int, str]]:
    """Number and text of each line of prose."""
    text = BLOCK.sub(lambda block: "\n" * block[0].count("\n"), text)
    is_code, before = False, ""  # an indented block of code begins behind an empty line
    for number, line in enumerate(text.split("\n"), 1):
        is_code = line.startswith("    ") and (is_code or not before.strip())
        if not is_code and not EXCEPTED.match(line):
            yield number, line
        before = line


def long_lines(root: Path) -> list[str]:
    """A message for each line of prose that is too long."""
    pages = sorted([*root.glob("*.md"), *(root / "docs").glob("*.md")])
    return [f"{page.relative_to(root)}:{number}: a line of {len(line)} characters, {LONGEST} are allowed"
            for page in pages for number, line in prose_lines(page.read_text())
            if len(line) > LONGEST]
