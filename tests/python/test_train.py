# SPDX-License-Identifier: Apache-2.0
"""`elastogen train`: files, exit codes, interruption, and the library it opens."""

from __future__ import annotations

import csv
import hashlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import h5py

from command import BINARY, run, turned_box, write_obj

SHORT = ("--steps", 12, "--samples", 12, "--last-layer", 0)
LIST = "# two\nsoft, neo-hookean, 0.1\nmix, 0.5*stvk+0.5*hencky, 0.4\n"


class Train(unittest.TestCase):
    """A folder of its own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_writes_weights_that_miss_the_limits_with_code_4(self) -> None:
        out = self.folder / "a.weights"
        done = run("train", "mtl", "--law", "stvk", "--poisson", 0.3, "-o", out, *SHORT)
        self.assertEqual(done.code, 4, done.err)
        self.assertIn("FAILS", done.out)
        content = out.read_bytes()
        self.assertEqual(hashlib.sha256(content[:-32]).digest(), content[-32:])
        self.assertIn(b"error.stress.p99", content)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["a.weights"])

    def test_writes_a_folder_for_a_list(self) -> None:
        names = self.folder / "list.csv"
        names.write_text(LIST)
        out = self.folder / "out"
        done = run("train", "mtl", "--list", names, "-o", out, "--quiet", *SHORT)
        self.assertEqual((done.code, done.out), (4, ""), done.err)
        self.assertEqual(sorted(path.name for path in out.iterdir()),
                         ["mix.weights", "report.csv", "soft.weights"])
        rows = list(csv.DictReader((out / "report.csv").read_text().splitlines()))
        self.assertEqual([row["name"] for row in rows], ["soft", "mix"])
        for row in rows:
            self.assertGreater(float(row["stress_p99"]), float(row["stress_median"]))
            self.assertEqual(row["passes"], "no")

    def test_shares_hidden_layers_and_fits_the_last_on_them(self) -> None:
        names = self.folder / "list.csv"
        names.write_text(LIST)
        done = run("train", "mtl", "--list", names, "-o", self.folder / "out", "--quiet",
                   "--shared-hidden", *SHORT)
        self.assertEqual(done.code, 4, done.err)
        hidden = self.folder / "out/hidden.tensors"
        self.assertIn(b"log stretches 2", hidden.read_bytes())
        mix = self.folder / "mix.weights"
        done = run("train", "mtl", "--law", "0.5*stvk+0.5*hencky", "--poisson", 0.46, "-o", mix,
                   "--start", hidden, "--steps", 0)
        self.assertEqual(done.code, 0, done.out + done.err)  # on layers hardly trained
        self.assertIn("1 of 1 inside all limits", done.out)

    def test_goes_on_after_an_interruption(self) -> None:
        whole, parts = self.folder / "whole", self.folder / "parts"
        options = ["train", "mtl", "--steps", "120", "--samples", "48", "--last-layer", "0", "-o"]
        self.assertEqual(run(*options, whole).code, 4)
        process = subprocess.Popen([BINARY, *options, str(parts)], stdout=subprocess.PIPE)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
        if process.returncode == 130:  # else it was done before the signal came
            self.assertTrue((self.folder / "parts.part").exists())
            self.assertFalse(parts.exists())
            self.assertEqual(run(*options, parts, "--resume").code, 4)
        self.assertEqual(parts.read_bytes(), whole.read_bytes())
        self.assertFalse((self.folder / "parts.part").exists())

    def test_refuses_what_it_cannot_fit(self) -> None:
        out = self.folder / "a"
        names = self.folder / "list.csv"
        names.write_text("soft, jam, 0.1\n")
        for code, words in ((2, ("--law", "jam")), (2, ("--poisson", 0.5)), (2, ("--steps", 0)), (2, ("--steps", -1)),
                            (2, ("--last-layer", -1)),
                            (2, ("--device", "tpu")), (3, ("--list", names)),
                            (3, ("--list", self.folder / "none"))):
            with self.subTest(words=words):
                done = run("train", "mtl", "-o", out, *words)
                self.assertEqual(done.code, code, done.err)
                self.assertFalse(out.exists())

    def test_names_the_places_where_its_library_is_not(self) -> None:
        alone = self.folder / "elastogen"
        shutil.copy(BINARY, alone)
        done = subprocess.run([alone, "train", "mtl", "-o", self.folder / "a"],
                              capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("libelastogen_learn.so: no such file", done.stderr)

    def test_other_verbs_open_no_libtorch(self) -> None:
        done = subprocess.run([BINARY, "materials"], capture_output=True, text=True, check=False,
                              timeout=60, env={"LD_DEBUG": "libs"})
        self.assertEqual(done.returncode, 0)
        self.assertIn("libc.so", done.stderr)
        self.assertNotIn("torch", done.stderr)


class Generator(unittest.TestCase):
    """A dataset of ten materials, made once, and what is trained on it."""

    COUNT = 10
    shared: tempfile.TemporaryDirectory[str]
    dataset: Path

    @classmethod
    def setUpClass(cls) -> None:
        cls.shared = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.shared.cleanup)
        cls.dataset = Path(cls.shared.name) / "d.h5"
        # iterations enough for the fits to end where they stay
        done = run("train", "dataset", "--count", cls.COUNT, "--seed", 5, "--iterations", 80, "-o",
                   cls.dataset)
        assert done.code == 0, done.err
        assert f"fit     {cls.COUNT} of {cls.COUNT}" in done.out, done.out

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def train(self, verb: str, out: str, *words: object, dataset: Path | None = None) -> Path:
        """Trains on the dataset; the file."""
        path = self.folder / out
        done = run("train", verb, dataset or self.dataset, "-o", path, *words)
        self.assertEqual(done.code, 0, done.out + done.err)
        content = path.read_bytes()
        self.assertEqual(hashlib.sha256(content[:-32]).digest(), content[-32:])
        self.assertFalse(path.with_name(path.name + ".part").exists())
        return path

    def test_the_dataset_has_fits_inside_their_limits_for_other_programs(self) -> None:
        with h5py.File(self.dataset, "r") as file:
            self.assertEqual(file["layers"].shape, (self.COUNT, 128))
            self.assertEqual(file["features"].shape, (self.COUNT, 15))
            self.assertEqual(file["hidden"].shape, (17153,))
            self.assertEqual(file["law"].shape, (self.COUNT,))
            inside = (file["errors"][:] <= (1e-3, 5e-3, 2e-2, 2e-2)).all(axis=1)
            self.assertGreaterEqual(inside.sum(), self.COUNT - 1)
            self.assertTrue((file["poisson"][:] <= 0.495).all())
            hidden = file["hidden"][:-129].tobytes()
            self.assertEqual(file["hidden_sha256"][0].decode(), hashlib.sha256(hidden).hexdigest())
        content = self.dataset.read_bytes()
        self.assertIn(hashlib.sha256(content[512:]).hexdigest().encode(), content[:512])

    def test_the_dataset_goes_on_after_an_interruption(self) -> None:
        out = self.folder / "d.h5"
        words = [BINARY, "train", "dataset", "--count", str(self.COUNT), "--seed", "5",
                 "--iterations", "80", "-o", str(out)]
        process = subprocess.Popen(words, stdout=subprocess.PIPE)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
        if process.returncode == 130:  # else it was done before the signal came
            self.assertFalse(out.exists())
            self.assertEqual(run(*words[1:], "--resume").code, 0)
        self.assertEqual(out.read_bytes(), self.dataset.read_bytes())
        self.assertEqual([path.name for path in self.folder.iterdir()], ["d.h5"])

    def test_trains_both_sizes(self) -> None:
        codec = self.train("autoencoder", "c.tensors", "--components", 6)
        self.assertIn(b"held_out.inside", codec.read_bytes())
        self.train("diffusion", "g.tensors", "--autoencoder", codec, "--steps", 3, "--batch", 8)
        paper = ("--size", "paper", "--steps", 3, "--batch", 4)
        whole = self.train("autoencoder", "a.tensors", *paper, "--layers", "16,4")
        self.assertIn(b"autoencoder.size0", whole.read_bytes())
        samples = self.train("diffusion", "p.tensors", *paper, "--autoencoder", whole)
        self.assertIn(b"held_out.inside.30", samples.read_bytes())

    def test_fits_begin_where_the_generator_says(self) -> None:
        weights = Path(__file__).parents[2] / "network/weights"
        own = self.folder / "own"
        own.mkdir()
        shutil.copy(weights / "hidden.tensors", own)
        generator = self.train("diffusion", "own/generator.tensors", "--steps", 0)
        bar = write_obj(self.folder / "bar.obj", *turned_box((1, 0.25, 0.25), (0, 0, 1), 0))
        with h5py.File(self.dataset, "r") as file:
            laws = [(law.decode(), nu) for law, nu in zip(file["law"][:], file["poisson"][:])
                    if b"*" not in law and law != b"hencky" and nu < 0.48]
        law, poisson = laws[0]
        iterations = []

        def animate(cache: str) -> int:
            environment = os.environ | {"ELASTOGEN_WEIGHTS": str(own),
                                        "XDG_CACHE_HOME": str(self.folder / cache)}
            done = subprocess.run(
                [BINARY, "animate", bar, "-o", self.folder / "a.glb", "--energy", "neural",
                 "--young", "1e5", "--voxels", "6", "--frames", "2", "--quiet", "--law", law,
                 "--poisson", str(poisson)],
                capture_output=True, text=True, check=False, timeout=120, env=environment)
            for path in (self.folder / cache).rglob("*.weights"):
                content = path.read_bytes()
                at = content.index(b"trainer.last_layer") + len(b"trainer.last_layer")
                size = int.from_bytes(content[at:at + 4], "little")
                iterations.append(int(content[at + 4:at + 4 + size]))
            self.message = done.stderr
            return done.returncode

        self.assertEqual(animate("with"), 0, self.message)
        content = generator.read_bytes()
        generator.unlink()
        self.assertEqual(animate("without"), 0, self.message)
        # a known material begins at its own fit
        self.assertLessEqual(iterations[0], 2)
        self.assertGreater(iterations[1], iterations[0])
        generator.write_bytes(content[:-40])
        self.assertEqual(animate("damaged"), 3)
        self.assertIn("generator.tensors", self.message)

    def test_refuses_what_it_cannot_train(self) -> None:
        out = self.folder / "o"
        broken = self.folder / "b.h5"
        content = bytearray(self.dataset.read_bytes())
        content[len(content) // 2] ^= 1
        broken.write_bytes(content)
        for code, words in ((2, ("dataset", "--count", 0)), (2, ("dataset", "--count", -4)),
                            (3, ("dataset", "--hidden", self.folder / "none")),
                            (3, ("autoencoder", broken)), (3, ("diffusion", broken)),
                            (3, ("diffusion", self.folder / "none")),
                            (2, ("diffusion", self.dataset, "--size", "huge")),
                            (2, ("diffusion", self.dataset, "--size", "paper")),
                            (2, ("diffusion", self.dataset, "--steps", -1)),
                            (2, ("diffusion", self.dataset, "--device", "tpu", "--steps", 1)),
                            (2, ("autoencoder", self.dataset, "--components", 0)),
                            (2, ("autoencoder", self.dataset, "--size", "paper", "--layers", "x")),
                            (2, ("autoencoder",))):
            with self.subTest(words=words):
                done = run("train", *words, "-o", out)
                self.assertEqual(done.code, code, done.err)
                self.assertFalse(out.exists())


if __name__ == "__main__":
    unittest.main()
