# SPDX-License-Identifier: Apache-2.0
"""The findings that the sources make are those that doctor knows a remedy for."""

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


class Findings(unittest.TestCase):
    def test_doctor_has_a_row_for_every_finding_and_no_other(self) -> None:
        made = set().union(*(ids_of(path.read_text()) for folder in ("io", "voxelize", "reader")
                             for path in (ROOT / folder).glob("*.cpp")
                             if not path.name.startswith("study_")))  # tables of another kind
        doctor = (ROOT / "cli" / "doctor.cpp").read_text()
        table = doctor.split("kRemedies[] = {")[1].split("};")[0]
        rows = re.findall(r'\{"([a-z-]+)",', table)
        self.assertEqual(len(rows), len(set(rows)))
        self.assertEqual(set(rows), made)
        self.assertGreater(len(made), 30)


if __name__ == "__main__":
    unittest.main()
