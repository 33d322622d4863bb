# SPDX-License-Identifier: Apache-2.0
"""What `doctor --json` lists is what `animate` says before the first step, and what its report holds.

Of every file of a folder (ELASTOGEN_ASSETS) and of a few that are made here: the same findings in the
same words, but for those that only outputs can know (docs/findings.md); a file that one refuses the
other refuses with the same reason."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import tempfile
import unittest
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from command import Run, run, turned_box, write_obj, write_stl

# of the grid, which planes of pins and of the floor shift
OF_GRID = {"sheet", "overlaps", "winding-number", "joined-pieces", "loose-pieces", "hinges"}
OF_OUTPUTS = {"own-columns", "corner-normals", "rounded-positions"}
FINDING = re.compile(r"(note|warning): (([a-z-]+) \(\d+\): .*)")
FIRST_STEP = "converged, worst residual"  # of the summary, which stands behind the steps
AT_ONCE = 2
PAGE = Path(__file__).parents[2] / "docs" / "findings.md"

Finding = tuple[str, str]  # severity and line


@dataclass(frozen=True)
class Said:
    """Exit code, findings in their order, other warnings, why the file was refused."""

    code: int
    findings: list[Finding]
    warnings: list[str]
    refused: str


def line_of(finding: dict[str, Any]) -> str:
    """As it is printed."""
    line = f"{finding['what']} ({finding['count']}): {finding['text']}; {finding['done']}"
    return line + (f"; to change that: {finding['change']}" if finding["change"] else "")


def by_severity(findings: list[Finding]) -> list[Finding]:
    """Notes, then warnings, which go to different places; each in its order."""
    return sorted(findings, key=lambda finding: finding[0])


def doctor(source: Path, *options: object) -> Said:
    """What `doctor --json` lists."""
    done = run("doctor", "--json", source, *options)
    said = json.loads(done.out)
    findings = [(f["severity"], line_of(f)) for f in said["findings"]]
    return Said(done.code, by_severity(findings), said["warnings"], said["error"])


def printed(done: Run) -> list[Finding]:
    """Findings that a run prints: notes on standard output, warnings on standard error."""
    before = done.out.split(FIRST_STEP)[0]
    lines = [line for line in before.splitlines() if line.startswith("note: ")]
    lines += [line for line in done.err.splitlines() if line.startswith("warning: ")]
    return [(m[1], m[2]) for line in lines if (m := FINDING.fullmatch(line))]


def animate(source: Path, folder: Path, *options: object, output: str = "out.pc2") -> Said:
    """What `animate` says, and its report holds besides."""
    report = folder / "report.json"
    done = run("animate", source, *options, "--frames", 1, "--substeps", 1, "--analytic", "-o",
               folder / output, "--report", report)
    findings = by_severity(printed(done))
    if report.exists():
        held = json.loads(report.read_text())["asset"]["findings"]
        found = by_severity([(f["severity"], f"{f['what']} ({f['count']}): {f['text']}") for f in held])
        assert len(found) == len(findings), f"the report holds {found}, {findings} were printed"
        for (severity, text), said in zip(found, findings):
            assert severity == said[0] and said[1].startswith(text), f"{said} and not {text} is said"
    warnings = [line.removeprefix("warning: ") for line in done.err.splitlines()
                if line.startswith("warning: ") and not FINDING.fullmatch(line)]
    last = (done.err.splitlines() or [""])[-1]
    return Said(done.code, findings, warnings,
                last.removeprefix("elastogen: ") if done.code not in (0, 4) else "")


def id_of(finding: Finding) -> str:
    """Of a line."""
    return finding[1].split(" ", 1)[0]


def without_outputs(findings: list[Finding]) -> list[Finding]:
    """Those that `doctor` can know."""
    return [finding for finding in findings if id_of(finding) not in OF_OUTPUTS]


def difference(listed: Said, said: Said) -> str:
    """How doctor (first) and animate differ about a file, or ""."""
    if (said.code == 3) != (listed.code == 3) or said.refused != listed.refused:
        return f"doctor: {listed.code} {listed.refused!r}, animate: {said.code} {said.refused!r}"
    if any(id_of(finding) in OF_OUTPUTS for finding in listed.findings):
        return f"doctor lists what it cannot know: {listed.findings}"
    if without_outputs(said.findings) != listed.findings:
        return f"doctor lists {listed.findings}, animate says {said.findings}"
    missing = [text for text in listed.warnings if text not in said.warnings]
    return f"animate does not warn: {missing}" if missing else ""


def fault(source: Path, *options: object) -> str:
    """How they differ with the same options."""
    with tempfile.TemporaryDirectory() as folder:
        return difference(doctor(source, *options), animate(source, Path(folder), *options))


class Assets(unittest.TestCase):
    def test_doctor_lists_what_animate_says_of_every_asset(self) -> None:
        place = os.environ.get("ELASTOGEN_ASSETS", "")
        if not place:
            self.skipTest("ELASTOGEN_ASSETS names no folder")
        root = Path(place)
        sources = sorted(path for path in root.rglob("*") if path.is_file())
        self.assertTrue(sources, f"nothing in {root}")
        with ThreadPoolExecutor(AT_ONCE) as pool:
            faults = list(pool.map(lambda source: fault(source, "--voxels", 16, "--threads", 1),
                                   sources))
        for source, text in zip(sources, faults):
            with self.subTest(str(source.relative_to(root))):
                self.assertEqual(text, "")


def two_boxes(path: Path) -> Path:
    """Apart from each other."""
    x, faces = turned_box((1, 1, 1), (0, 0, 1), 0)
    return write_obj(path, np.concatenate([x, x + np.array([2, 0, 0])]),
                     faces + [[k + 8 for k in face] for face in faces])


def open_box(path: Path) -> Path:
    """Without one side, with one that is there twice, and one that is turned."""
    x, faces = turned_box((1, 1, 1), (0, 0, 1), 0)
    return write_obj(path, x, faces[1:5] + faces[2:3] + [faces[5][::-1]])


def flag(path: Path) -> Path:
    """One rectangle."""
    return write_obj(path, np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0.0]]), [[0, 1, 2, 3]])


def cloud(path: Path) -> Path:
    """Points of a sphere and two far from it, with a column more."""
    n = np.arange(3000) + 0.5
    z, turn = 1 - 2 * n / 3000, n * np.pi * (3 - 5 ** 0.5)
    ring = np.sqrt(1 - z * z)
    x = np.concatenate([np.column_stack([ring * np.cos(turn), ring * np.sin(turn), z]),
                        [[9, 0, 0], [0, 9, 0]]])
    head = (f"ply\nformat ascii 1.0\nelement vertex {len(x)}\nproperty float x\nproperty float y\n"
            "property float z\nproperty float heat\nend_header\n")
    path.write_text(head + "".join(f"{a:.6f} {b:.6f} {c:.6f} 1\n" for a, b, c in x.tolist()))
    return path


def mesh_with_column(path: Path) -> Path:
    """A cube with a number at each vertex."""
    x, faces = turned_box((1, 1, 1), (0, 0, 1), 0)
    head = (f"ply\nformat ascii 1.0\nelement vertex {len(x)}\nproperty float x\nproperty float y\n"
            f"property float z\nproperty float heat\nelement face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n")
    rows = ["{} {} {} 1".format(*p) for p in x.tolist()]
    path.write_text(head + "\n".join(rows + [" ".join(map(str, [4, *face])) for face in faces]) + "\n")
    return path


def without_material_file(path: Path) -> Path:
    """A cube whose .mtl is not there."""
    write_obj(path, *turned_box((1, 1, 1), (0, 0, 1), 0))
    path.write_text("mtllib crate.mtl\nusemtl wood\n" + path.read_text())
    return path


def with_split_normals(path: Path) -> Path:
    """A cube whose corners have the normal of each side."""
    x, faces = turned_box((1, 1, 1), (0, 0, 1), 0)
    lines = ["v {} {} {}".format(*p) for p in x.tolist()]
    for face in faces:
        lines.append("vn {} {} {}".format(*np.sign(x[face].sum(axis=0)).tolist()))
    lines += ["f " + " ".join(f"{k + 1}//{n + 1}" for k in face) for n, face in enumerate(faces)]
    path.write_text("\n".join(lines) + "\n")
    return path


MADE: dict[str, tuple[Callable[[Path], Path], set[str]]] = {
    "two_boxes.obj": (two_boxes, {"pieces", "loose-pieces"}),
    "open.obj": (open_box, {"open", "duplicate-faces", "turned-faces"}),
    "flag.obj": (flag, {"open", "sheet"}),
    "scan.ply": (cloud, {"floaters", "carried-columns"}),
    "crate.obj": (without_material_file, {"missing-material-file"}),
    "normals.obj": (with_split_normals, set()),
}


class Made(unittest.TestCase):
    """Files that are made here."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_doctor_lists_what_animate_says(self) -> None:
        for name, (make, wanted) in MADE.items():
            with self.subTest(name):
                source = make(self.folder / name)
                self.assertEqual(fault(source, "--voxels", 12), "")
                found = {id_of(finding) for finding in doctor(source, "--voxels", 12).findings}
                self.assertLessEqual(wanted, found)

    def test_a_refused_file_is_refused_by_both_with_one_reason(self) -> None:
        short = write_stl(self.folder / "short.stl", *turned_box((1, 1, 1), (0, 0, 1), 0), text=False)
        short.write_bytes(short.read_bytes()[:300])
        (self.folder / "empty.obj").write_text("v 0 0 0\n")
        (self.folder / "note.txt").write_text("no asset\n")
        for name in ("short.stl", "empty.obj", "note.txt", "missing.obj"):
            with self.subTest(name):
                self.assertEqual(fault(self.folder / name), "")
                listed = doctor(self.folder / name)
                self.assertEqual(listed.code, 3)
                self.assertIn(name, listed.refused)

    def test_what_an_output_cannot_hold_is_said_by_the_run_alone(self) -> None:
        far = turned_box((1, 1, 1), (0, 0, 1), 0)
        cases = {"own-columns": (mesh_with_column(self.folder / "c.ply"), "out.pc2"),
                 "corner-normals": (with_split_normals(self.folder / "n.obj"), "out.ply"),
                 "rounded-positions": (write_obj(self.folder / "f.obj", far[0] + 1e7, far[1]), "out.pc2")}
        self.assertEqual(set(cases), OF_OUTPUTS)
        for what, (source, output) in cases.items():
            with self.subTest(what):
                listed = doctor(source, "--voxels", 12)
                said = animate(source, self.folder, "--voxels", 12, output=output)
                self.assertNotIn(what, [id_of(finding) for finding in listed.findings])
                self.assertIn(what, [id_of(finding) for finding in said.findings])
                self.assertEqual(without_outputs(said.findings), listed.findings)

    def test_pins_and_a_floor_change_what_belongs_to_the_grid_alone(self) -> None:
        for name, (make, _) in MADE.items():
            source = make(self.folder / name)
            listed = doctor(source, "--voxels", 12).findings
            for options in (("--pin", "y<30%"), ("--floor",)):
                with self.subTest(name, options=options):
                    said = animate(source, self.folder, "--voxels", 12, *options)
                    self.assertEqual(said.code, 0)
                    self.assertEqual(*([finding for finding in findings if id_of(finding) not in OF_GRID]
                                       for findings in (without_outputs(said.findings), listed)))

    def test_voxels_count_in_both(self) -> None:
        source = two_boxes(self.folder / "two.obj")
        coarse = doctor(source, "--h", "2.5").findings
        self.assertNotEqual(coarse, doctor(source, "--voxels", 24).findings)
        self.assertEqual(fault(source, "--h", "2.5"), "")

    def test_a_lie_is_found(self) -> None:
        source = open_box(self.folder / "open.obj")
        listed = doctor(source, "--voxels", 12)
        severity, line = listed.findings[0]
        lies = {"missing": listed.findings[1:], "new": [*listed.findings, ("note", "hinges (1): a; b")],
                "counted": [(severity, line.replace("(", "(1", 1)), *listed.findings[1:]],
                "severity": [("warning" if severity == "note" else "note", line), *listed.findings[1:]]}
        self.assertEqual(difference(listed, listed), "")
        for name, findings in lies.items():
            with self.subTest(name):
                self.assertNotEqual(difference(listed, replace(listed, findings=findings)), "")
        self.assertNotEqual(difference(listed, replace(listed, code=3, refused="no")), "")


def page_examples() -> list[tuple[str, list[str]]]:
    """Commands of the page's section of examples, each with the lines below it."""
    section = PAGE.read_text().split("## As a user sees them\n")[1]
    blocks = re.findall(r"((?:    .*\n)+)", section)
    lines = [[line[4:] for line in block.splitlines()] for block in blocks]
    return [(block[0].removeprefix("$ "), block[1:]) for block in lines if block[0].startswith("$ ")]


class Page(unittest.TestCase):
    """The examples of docs/findings.md are what the program prints."""

    def test_the_examples_are_printed(self) -> None:
        with tempfile.TemporaryDirectory() as text:
            folder, place = Path(text), os.environ.get("ELASTOGEN_ASSETS", "")
            for name, (make, _) in MADE.items():
                make(folder / name)
            if place:
                shutil.copy(Path(place) / "gltf" / "Fox.glb", folder)
            examples = page_examples()
            self.assertEqual(len(examples), 5)
            for command, lines in examples:
                program, verb, source, *options = shlex.split(command)
                if not (folder / source).exists():
                    continue
                with self.subTest(command):
                    words = [folder / word if previous == "-o" else word
                             for previous, word in zip([source, *options], options)]
                    done = run(verb, folder / source, *words, "--frames", 1)
                    self.assertEqual((program, done.code), ("elastogen", 0))
                    self.assertEqual([": ".join(finding) for finding in printed(done)], lines)


if __name__ == "__main__":
    unittest.main()
