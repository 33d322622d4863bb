# SPDX-License-Identifier: Apache-2.0
"""What the command says stays as it is: help pages, and messages of runs that it refuses.

They are compared with words/help.txt and words/messages.txt. Whoever changes them on purpose writes
them anew, and says so in CHANGELOG.md:

    cd tests/python; ELASTOGEN_BINARY=... python3 test_words.py --write
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from command import BINARY, turned_box, write_obj

WORDS = Path(__file__).resolve().parent / "words"
VERBS = ["animate", "simulate", "study", "voxelize", "doctor", "inspect", "materials", "train", "bench",
         "demo"]
REFUSED = [
    "animate",
    "animate none.obj -o a.glb",
    "animate bar.obj",
    "animate bar.obj -o a.xyz",
    "animate bar.obj -o a.glb --pin y",
    "animate bar.obj -o a.glb --pin 'q<5%'",
    "animate bar.obj -o a.glb --pin 'node:Hat'",
    "animate bar.obj -o a.glb --pin 'colour:red'",
    "animate bar.obj -o a.glb --move 'attr:w>1: shift 0:0,0,0'",
    "animate bar.obj -o a.glb --material cheese",
    "animate bar.obj -o a.glb --young -3Pa",
    "animate bar.obj -o a.glb --poisson 0.5",
    "animate bar.obj -o a.glb --law steel",
    "animate bar.obj -o a.glb --h 0",
    "animate bar.obj -o a.glb --voxels 0",
    "animate bar.obj -o a.glb --size long",
    "animate bar.obj -o a.glb --fps 0",
    "animate bar.obj -o a.glb --frames -1",
    "animate bar.obj -o a.glb --substeps 1.5",
    "animate bar.obj -o a.glb --time-scheme verlet",
    "animate bar.obj -o a.glb --solver magic",
    "animate bar.obj -o a.glb --up w",
    "animate bar.obj -o a.glb --floor w=3",
    "animate bar.obj -o a.glb --floor y=0.05",
    "animate bar.obj -o a.glb --friction -1",
    "animate bar.obj -o a.glb --gravity 1,2",
    "animate bar.obj -o a.glb --region 'y<3%'",
    "animate bar.obj -o a.glb --region 'y<3%: cheese'",
    "animate bar.obj -o a.glb --region 'node:Hat: foam'",
    "animate bar.obj -o a.glb --region 'material:Hat: foam'",
    "animate bar.obj -o a.glb --collider 'cone(1,2,3)'",
    "animate bar.obj -o a.glb --collider 'sphere(1,2,3)'",
    "animate bar.obj -o a.glb --collider 'plane(0,0,0, 0,0,0)'",
    "animate bar.obj -o a.glb --collider 'box(1,1,1, 0,0,0)'",
    "animate bar.obj -o a.glb --collider 'sphere(0,0,0, 1) friction -1'",
    "animate bar.obj -o a.glb --collider 'sphere(0,5,0, 1) path 1:0,0'",
    "animate bar.obj -o a.glb --collider 'sphere(0,5,0, 1) path 1:0,0,0; 0:0,0,0'",
    "animate bar.obj -o a.glb --collider 'sphere(0,0,0, 1)'",
    "animate bar.obj -o a.glb --solver paper --hold 'x<1%: x'",
    "animate bar.obj -o a.glb --log-json a.glb",
    "animate bar.obj -o a.glb --max-voxels 10",
    "animate bar.obj -o a.glb --max-memory 1kB",
    "animate bar.obj -o a.glb --strict",
    "animate --scene none.toml",
    "animate --scene wrong.toml",
    "animate bar.obj -o a.glb --quiet --frames 2 --voxels 4 --pin 'x>3m'",
    "animate bar.obj -o a.glb --quiet --frames 2 --voxels 4 --region 'x>3m: foam'",
    "animate bar.obj -o a.glb --quiet --frames 2 --voxels 4 --pin all",
    "animate bar.obj -o a.glb --quiet --frames 2 --voxels 4",
    "simulate bar.obj -o a.glb --element hex20",
    "simulate bar.obj -o a.glb --mass light",
    "simulate bar.obj -o a.glb --device cuda",
    "simulate bar.obj -o a.glb --energy neural",
    "simulate bar.obj -o a.glb --hold 'x<1%'",
    "simulate bar.obj -o a.glb --hold 'x<1%: q'",
    "simulate bar.obj -o a.glb --hold 'x<1%: xx'",
    "simulate bar.obj -o a.glb --traction 'x>99%: 1,2'",
    "simulate bar.obj -o a.glb --traction 'x>99%: 3 kg'",
    "simulate bar.obj -o a.glb --traction 'x>3m: 1,2,3' --voxels 4",
    "simulate bar.obj -o a.glb --move 'x>99%: jump 1:0,0,0'",
    "simulate bar.obj -o a.glb --move 'x>99%: shift 1:0,0'",
    "simulate bar.obj -o a.glb --move 'x>99%: shift 1:0,0,0; 0:0,0,0'",
    "simulate bar.obj -o a.glb --move 'x>99%: turn(0,0,0, 0,0,0) 1:3deg'",
    "simulate bar.obj -o a.glb --move 'x>99%: turn(0,0,0, 1,0,0) 1:3m'",
    "simulate bar.obj -o a.glb --pin 'x>90%' --move 'x>99%: shift 1:1,0,0' --voxels 4",
    "simulate bar.obj -o a.glb --static",
    "simulate bar.obj -o a.glb --static --pin 'x<1%' --floor",
    "simulate bar.obj -o a.glb --static --pin 'x<1%' --spin 1,0,0",
    "simulate bar.obj -o a.glb --quiet --static --pin 'x>3m' --voxels 4",
    "simulate two.obj -o a.glb --quiet --static --pin 'x<10%' --h 5cm --gravity 1,0,0",
    "simulate one.msh -o a.glb --element hex",
    "simulate one.msh -o a.glb --region 'node:a: foam'",
    "simulate one.msh -o a.glb --pin 'material:2'",
    "simulate one.msh -o a.glb --quiet --voxels 3 --pin 'x<1%' --frames 1",
    "study bar.obj --hold 'x<1%: x'",
    "voxelize bar.obj -o a.obj",
    "materials show cheese",
    "inspect none.obj",
    "bench dance",
    "dance",
]
MSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
1
1 4 2 1 1 1 2 3 4
$EndElements
"""


def write_inputs(folder: Path) -> None:
    position, faces = turned_box((0.4, 0.1, 0.1), (0, 0, 1), 0)
    write_obj(folder / "bar.obj", position, faces)
    lines = [(folder / "bar.obj").read_text()]
    lines += [f"v {x + 1!r} {y!r} {z!r}\n" for x, y, z in position.tolist()]
    lines += ["f " + " ".join(str(i + 9) for i in face) + "\n" for face in faces]
    (folder / "two.obj").write_text("".join(lines))
    (folder / "one.msh").write_text(MSH)
    (folder / "wrong.toml").write_text("[asset]\nfiel = 'bar.obj'\n")


def said(words: str, folder: Path) -> str:
    """Exit code, output and errors of the command in that folder."""
    done = subprocess.run(f"'{BINARY}' {words}", shell=True, cwd=folder, capture_output=True, text=True,
                          timeout=120, check=False, env={**os.environ, "COLUMNS": "80"})
    return f"$ elastogen {words}\n{done.stdout}{done.stderr}-> {done.returncode}\n\n"


def help_pages(folder: Path) -> str:
    return "".join(said(f"{verb} --help".strip(), folder) for verb in ["", *VERBS])


def messages(folder: Path) -> str:
    write_inputs(folder)
    return "".join(said(words, folder) for words in REFUSED)


class Words(unittest.TestCase):
    maxDiff = None

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_help_pages_are_the_stored_ones(self) -> None:
        self.assertEqual((WORDS / "help.txt").read_text(), help_pages(self.folder))

    def test_messages_are_the_stored_ones(self) -> None:
        self.assertEqual((WORDS / "messages.txt").read_text(), messages(self.folder))


def write() -> None:
    with tempfile.TemporaryDirectory() as name:
        (WORDS / "help.txt").write_text(help_pages(Path(name)))
        (WORDS / "messages.txt").write_text(messages(Path(name)))


if __name__ == "__main__":
    write() if "--write" in sys.argv else unittest.main()
