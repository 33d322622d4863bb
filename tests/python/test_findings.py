# SPDX-License-Identifier: Apache-2.0
"""The findings that the sources make are the rows of io/finding.cpp."""

from __future__ import annotations

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).parents[2]
MAKERS = (r'add_finding\(\w+, "([a-z-]+)"', r'findings\.push_back\(\s*\{"([a-z-]+)"',
          r'\b(?:note|add)\("([a-z-]+)",')
NAMED = r'(?:check_attribute|reset_bad_rows|good_rows)\([^;"]*"([a-z]+)"'


def ids_of(text: str) -> set[str]:
    """Ids of the findings that a source makes: spelt, and bad-NAME of the shared checks."""
    bad = {f"bad-{name}" for name in re.findall(NAMED, text)}
    return bad.union(*(re.findall(pattern, text) for pattern in MAKERS))


def table_rows() -> list[tuple[str, str, str, str]]:
    """Id, severity, what is done and how to change that, of each row of io/finding.cpp."""
    source = (ROOT / "io" / "finding.cpp").read_text()
    table = re.sub(r'"\s+"', "", source.split("kKinds[] = {")[1].split("\n};")[0])
    text = r'"([^"]*)"'
    return re.findall(rf'\{{{text},\s*k(Note|Warning),\s*{text},\s*{text}\}}', table)


class Findings(unittest.TestCase):
    def test_the_table_has_a_row_for_every_finding_and_no_other(self) -> None:
        made = set().union(*(ids_of(path.read_text()) for folder in ("io", "voxelize", "reader")
                             for path in (ROOT / folder).glob("*.cpp")
                             if not path.name.startswith("study_")))  # tables of another kind
        for name in ("tet_asset.cpp", "piece_names.cpp"):
            made |= ids_of((ROOT / "scene" / name).read_text())
        rows = [row[0] for row in table_rows()]
        self.assertEqual(len(rows), len(set(rows)))
        self.assertEqual(set(rows), made)
        self.assertGreater(len(made), 30)

    def test_the_page_has_the_same_table(self) -> None:
        page = (ROOT / "docs" / "findings.md").read_text().splitlines()
        lines = [line for line in page if line.startswith("| `")]
        self.assertEqual(lines, [f"| `{what}` | {severity.lower()} | {done} | {change} |"
                                 for what, severity, done, change in table_rows()])


if __name__ == "__main__":
    unittest.main()
