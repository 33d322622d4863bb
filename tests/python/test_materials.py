# SPDX-License-Identifier: Apache-2.0
"""`elastogen materials`: pages and weight files of nets, and materials of tests."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

from command import BINARY, Run, turned_box, write_obj
from laws import lame, law_of
from nets import law_in_logs, net_energy
from state_file import Floats, Net
from weight_file import read_weights

SOURCE_WEIGHTS = Path(__file__).resolve().parents[2] / "network/weights"
SVG = "{http://www.w3.org/2000/svg}"
UNFITTABLE = ("gent=0.1", "--poisson", "0.3")  # hardens without bound well inside the box


def stress_errors(weights: Floats, law: Any, poisson: float) -> Floats:
    """Errors of the stress over the local one at strains of the box, from the definitions."""
    random = np.random.default_rng(3)
    e = random.uniform(-0.9, 0.9, (3000, 3))
    e = e[np.abs(e.sum(1)) <= np.log(2)]
    exact = law(e)[1] / np.exp(e)
    made = net_energy(Net("", weights, 0), poisson, e)[1] / np.exp(e)
    mu, lam = lame(1, poisson)
    floor = 1e-4 * (2 * mu + lam)
    return np.linalg.norm(made - exact, axis=1) / (np.linalg.norm(exact, axis=1) + floor)


class Materials(unittest.TestCase):
    """A folder of its own, with an empty cache."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_verb(self, *words: object, **variables: str) -> Run:
        """The command with a cache in the folder."""
        environment = os.environ | {"XDG_CACHE_HOME": str(self.folder / "cache")} | variables
        done = subprocess.run([BINARY, *(str(word) for word in words)], capture_output=True,
                              text=True, check=False, timeout=120, env=environment)
        return Run(done.returncode, done.stdout, done.stderr)

    def refused(self, done: Run, code: int, *words: str) -> None:
        """The code, and a message with these words."""
        self.assertEqual(done.code, code, done.out + done.err)
        for word in words:
            self.assertIn(word, done.err)

    def own_weights(self, source: str, name: str, *, scale: float = 1) -> str:
        """A folder with a shipped file under another name, its last layer scaled, sealed anew."""
        own = self.folder / "own"
        own.mkdir(exist_ok=True)
        data = (SOURCE_WEIGHTS / source).read_bytes()[:-32]
        last = (np.frombuffer(data[-4 * 129:], "<f4") * np.float32(scale)).tobytes()
        data = data[:-4 * 129] + last
        (own / name).write_bytes(data + hashlib.sha256(data).digest())
        return str(own)


class Presets(Materials):
    def test_are_listed_with_and_without_the_word(self) -> None:
        names = [m["name"] for m in json.loads(self.run_verb("materials", "--json").out)]
        self.assertIn("rubber", names)
        plain = self.run_verb("materials")
        self.assertEqual(self.run_verb("materials", "list").out, plain.out)
        for name in names:
            self.assertIn(name, plain.out)
            shown = json.loads(self.run_verb("materials", "show", name, "--json").out)
            self.assertEqual(shown["name"], name)

    def test_one_subcommand_at_a_time(self) -> None:
        self.refused(self.run_verb("materials", "rubber"), 2, "rubber")
        self.refused(self.run_verb("materials", "show"), 2, "NAME")
        self.refused(self.run_verb("materials", "show", "jam"), 2, "unknown material 'jam'")
        self.refused(self.run_verb("materials", "list", "show", "rubber"), 2)


class Report(Materials):
    def page(self, *words: str, code: int = 0, **variables: str) -> ET.Element:
        """The page as XML."""
        path = self.folder / "page.html"
        done = self.run_verb("materials", "report", *words, "-o", path, **variables)
        self.assertEqual(done.code, code, done.err)
        text = path.read_text()
        for part in ("<script", "<link", "<img", "src=", "href="):
            self.assertNotIn(part, text)
        return ET.fromstring(text.removeprefix("<!DOCTYPE html>"))

    def rows(self, page: ET.Element) -> dict[str, list[str]]:
        """Cells of all tables by their row's head."""
        rows = [["".join(cell.itertext()) for cell in row] for row in page.iter("tr")]
        return {row[0]: row[1:] for row in rows}

    def test_holds_errors_card_and_curves_of_a_shipped_net(self) -> None:
        page = self.page("rubber")
        rows = self.rows(page)
        path = SOURCE_WEIGHTS / "neo-hookean-0.48.weights"
        card, _ = read_weights(path)
        self.assertEqual(rows["SHA-256 of the file"],
                         [hashlib.sha256(path.read_bytes()).hexdigest()])
        self.assertEqual(rows["file"], [str(path)])
        for key, value in card.items():
            self.assertEqual(rows[key], [value])
        for name, key, limit in (("stress, median", "error.stress.median", "0.1 %"),
                                 ("stress, 99 of 100 strains", "error.stress.p99", "0.5 %"),
                                 ("stress, all strains", "error.stress.max", "2 %"),
                                 ("tangent, 99 of 100 strains", "error.tangent.p99", "2 %")):
            of_card, measured, stated, verdict = rows[name]
            self.assertAlmostEqual(float(of_card.rstrip(" %")) / (100 * float(card[key])), 1, 3)
            self.assertEqual((stated, verdict), (limit, "passes"))
            if "all" not in name:  # the largest of other strains may be another one
                ratio = float(measured.rstrip(" %")) / (100 * float(card[key]))
                self.assertTrue(0.8 < ratio < 1.25, (name, ratio))
        # stress, energy and errors of four loads, two histograms
        titles = [svg.find(f"{SVG}title").text or "" for svg in page.iter(f"{SVG}svg")]
        self.assertEqual(len(titles), 14)
        for load in ("Uniaxial", "Equibiaxial", "Pure shear", "Change of volume"):
            self.assertEqual(sum(title.startswith(load) for title in titles), 3)
        self.assertIn("elastogen materials report rubber", "".join(page.itertext()))

    def test_measures_a_net_that_was_made_for_it(self) -> None:
        rows = self.rows(self.page("0.5*ogden=3+0.5*stvk", "--poisson", "0.37"))
        self.assertEqual(rows["law"], ["0.5*ogden=3+0.5*stvk"])
        self.assertEqual(rows["poisson"], ["0.37"])
        self.assertIn("made for this page", rows["file"][0])
        again = self.rows(self.page("0.5*ogden=3+0.5*stvk", "--poisson", "0.37"))
        self.assertIn("cache/elastogen/weights", again["file"][0])
        self.assertEqual(again["SHA-256 of the file"], rows["SHA-256 of the file"])

    def test_a_net_beyond_its_limits_ends_with_4(self) -> None:
        page = self.page(*UNFITTABLE, code=4)
        self.assertIn("misses its limits", "".join(page.itertext()))
        self.assertIn("MISSES", self.rows(page)["stress, median"])
        self.assertFalse((self.folder / "cache").exists())

    def test_believes_no_card(self) -> None:
        own = self.own_weights("stvk-0.3.weights", "stvk-0.3.weights", scale=1.05)
        rows = self.rows(self.page("stvk", "--poisson", "0.3", code=4, ELASTOGEN_WEIGHTS=own))
        self.assertEqual(rows["error.passes"], ["yes"])
        self.assertIn("MISSES", rows["stress, median"])

    def test_refuses_what_it_cannot_show(self) -> None:
        out = self.folder / "page.html"
        for code, words, told in (
                (2, ("jam", "-o", out), "'jam' is none of the presets rubber"),
                (2, ("stvk", "--poisson", 0.5, "-o", out), "[0, 0.499]"),
                (2, ("stvk", "--poisson", "nan", "-o", out), "[0, 0.499]"),
                (2, ("stvk", "-o", self.folder / "page.txt"), ".html"),
                (2, ("stvk", "-o", out, "--json"), "--json"),
                (2, ("stvk",), "--output"),
                (6, ("stvk", "-o", self.folder / "no/page.html"), "page.html")):
            with self.subTest(words=words):
                self.refused(self.run_verb("materials", "report", *words), code, told)
        own = self.own_weights("stvk-0.3.weights", "hencky-0.3.weights")
        self.refused(self.run_verb("materials", "report", "hencky", "--poisson", 0.3, "-o", out,
                                   ELASTOGEN_WEIGHTS=own), 3, "hencky-0.3.weights", "not the weights")
        (self.folder / "own/hencky-0.3.weights").write_bytes(b"elastogen-tensor and no more")
        self.refused(self.run_verb("materials", "report", "hencky", "--poisson", 0.3, "-o", out,
                                   ELASTOGEN_WEIGHTS=own), 3, "hencky-0.3.weights")
        self.assertFalse(out.exists())


class Generate(Materials):
    def test_makes_the_net_of_a_mixture(self) -> None:
        out = self.folder / "mix.weights"
        done = self.run_verb("materials", "generate", "0.3*ogden=4+0.7*stvk", "--poisson", 0.4,
                             "-o", out, "--json")
        self.assertEqual(done.code, 0, done.err)
        told, (card, weights) = json.loads(done.out), read_weights(out)
        self.assertEqual(told["sha256"], hashlib.sha256(out.read_bytes()).hexdigest())
        self.assertEqual((card["law"], card["poisson"]), ("0.3*ogden=4+0.7*stvk", "0.4"))
        self.assertEqual(told["law"], card["law"])
        self.assertEqual(told["errors"]["stress_p99"], float(card["error.stress.p99"]))
        self.assertTrue(told["errors"]["passes"])
        self.assertGreater(told["seconds"], 0)

        def mixture(e: Floats) -> tuple[Floats, Floats]:
            parts = [law_in_logs(law_of(name), 0.4, e) for name in ("ogden=4", "stvk")]
            return (0.3 * parts[0][0] + 0.7 * parts[1][0], 0.3 * parts[0][1] + 0.7 * parts[1][1])

        errors = stress_errors(weights, mixture, 0.4)
        self.assertLess(float(np.median(errors)), 1e-3)
        self.assertLess(float(errors.max()), 2e-2)
        self.assertGreater(float(np.median(stress_errors(weights, lambda e: law_in_logs(
            law_of("stvk"), 0.4, e), 0.4))), 1e-2)  # the check tells laws apart

    def test_makes_what_animate_takes(self) -> None:
        own = self.folder / "own"
        own.mkdir()
        done = self.run_verb("materials", "generate", "gent=40", "--poisson", 0.41, "-o",
                             own / "gent=40-0.41.weights")
        self.assertEqual(done.code, 0, done.err)
        self.assertRegex(done.out, r"gent=40-0\.41: stress median .*: passes\n\d+ iterations, ")
        bar = write_obj(self.folder / "bar.obj", *turned_box((1, 0.25, 0.25), (0, 0, 1), 0))
        clip = self.run_verb("animate", bar, "-o", self.folder / "a.glb", "--energy", "neural",
                             "--law", "gent=40", "--poisson", "0.41", "--young", "1e5", "--voxels",
                             "8", "--frames", "2", "--pin", "x<5%", "--quiet",
                             ELASTOGEN_WEIGHTS=str(own))
        self.assertEqual(clip.code, 0, clip.err)
        self.assertFalse((self.folder / "cache").exists())

    def test_fits_gent_to_nine_tenths_of_its_limit(self) -> None:
        weights = self.folder / "g.weights"
        done = self.run_verb("materials", "generate", "gent=7.5", "--poisson", 0.2, "-o", weights)
        self.assertEqual(done.code, 0, done.err)
        random = np.random.default_rng(4)
        e = random.uniform(-0.9, 0.9, (100000, 3))
        excess = np.exp(2 * (e - e.mean(1, keepdims=True))).sum(1) - 3
        e = e[(np.abs(e.sum(1)) <= np.log(2)) & (excess <= 0.9 * 7.5) & (excess > 0.7 * 7.5)]
        self.assertGreater(len(e), 200)
        _, stress = law_in_logs(law_of("gent=7.5"), 0.2, e)
        _, by_net = net_energy(Net("", read_weights(weights)[1], 0), 0.2, e)
        error = np.linalg.norm((by_net - stress) / np.exp(e), axis=1)
        self.assertLess(float((error / np.linalg.norm(stress / np.exp(e), axis=1)).max()), 2e-2)
        below = self.run_verb("animate", write_obj(self.folder / "bar.obj", *turned_box(
            (1, 0.25, 0.25), (0, 0, 1), 0)), "-o", self.folder / "a.glb", "--energy", "neural",
            "--law", "gent=7.4", "--poisson", "0.2", "--voxels", "8", "--frames", "1")
        self.assertEqual(below.code, 2, below.err)
        self.assertIn("nets are made from 7.5 on", below.err)

    def test_writes_what_misses_its_limits_with_code_4(self) -> None:
        out = self.folder / "a.weights"
        done = self.run_verb("materials", "generate", *UNFITTABLE, "-o", out)
        self.assertEqual(done.code, 4, done.err)
        self.assertIn("MISSES its limits", done.out)
        self.assertEqual(read_weights(out)[0]["error.passes"], "no")

    def test_refuses_what_it_cannot_make(self) -> None:
        out = self.folder / "a.weights"
        for code, words, told in (
                (2, ("jam", "--poisson", 0.3, "-o", out), "unknown law 'jam'"),
                (2, ("0.5*stvk", "--poisson", 0.3, "-o", out), "sum to 1"),
                (2, ("ogden=99", "--poisson", 0.3, "-o", out), "-20 to 20"),
                (2, ("stvk", "--poisson", 0.4995, "-o", out), "[0, 0.499]"),
                (2, ("stvk", "-o", out), "--poisson"),
                (2, ("stvk", "--poisson", 0.3), "--output"),
                (2, ("stvk", "--poisson", 0.3, "-o", self.folder / "a.txt"), ".weights"),
                (6, ("stvk", "--poisson", 0.3, "-o", self.folder / "no/a.weights"), "a.weights")):
            with self.subTest(words=words):
                self.refused(self.run_verb("materials", "generate", *words), code, told)
                self.assertFalse(out.exists())
        own = self.folder / "own"
        own.mkdir()
        (own / "hidden.tensors").write_bytes(b"elastogen-tensor but no more")
        self.refused(self.run_verb("materials", "generate", "stvk", "--poisson", 0.3, "-o", out,
                                   ELASTOGEN_WEIGHTS=str(own)), 3, "hidden.tensors")


def uniaxial_stress(name: str, young: float, poisson: float, stretch: float) -> float:
    """Nominal stress of a law [Pa], its free sides by bisection."""
    law, (mu, lam) = law_of(name), lame(young, poisson)
    low, high = 0.3, 2.0
    P = np.zeros((1, 3, 3))
    for _ in range(100):
        side = (low + high) / 2
        P = law(np.diag([stretch, side, side])[None], mu, lam)[1]
        low, high = (low, side) if P[0, 1, 1] > 0 else (side, high)
    return float(P[0, 0, 0])


class Fit(Materials):
    def csv(self, text: str) -> Path:
        """A file of a test."""
        path = self.folder / "test.csv"
        path.write_text(text)
        return path

    def hencky(self, poisson: float, head: str = "mode,stretch,stress [kPa]") -> Path:
        """Points of a body of Hencky's law of E = 0.9 MPa, in closed form."""
        lines = [head, "# a comment"]
        for stretch in (0.8, 1.1, 1.3, 1.6, 2.0):
            stress = 900 * np.log(stretch) / stretch
            lines += [f"uniaxial,{stretch},{stress:.17g}",
                      f"shear,{stretch},{stress / (1 - poisson**2):.17g}",
                      f"biaxial,{stretch**0.5},"
                      f"{900 * np.log(stretch**0.5) / stretch**0.5 / (1 - poisson):.17g}"]
        return self.csv("\n".join(lines) + "\n")

    def test_finds_law_and_modulus(self) -> None:
        test, scene = self.hencky(0.4), self.folder / "m.toml"
        done = self.run_verb("materials", "fit", test, "--poisson", 0.4, "-o", scene)
        self.assertEqual(done.code, 0, done.err)
        table = [line.split() for line in done.out.splitlines()]
        laws = [row[0] for row in table if row and row[0].partition("=")[0] in {
            "hencky", "neo-hookean", "stable-neo-hookean", "stvk", "fixed-corotated", "ogden",
            "gent", "mooney-rivlin"}]
        self.assertEqual(len(laws), 8)
        self.assertEqual(laws[0], "hencky")
        self.assertIn("its net: stress median", done.out)
        self.assertEqual(done.err, "")
        text = scene.read_text()
        self.assertIn('[material]\nlaw = "hencky"\nyoung = 900000\npoisson = 0.4\n', text)
        self.assertIn(text, done.out)

    def test_writes_a_scene_that_animate_accepts(self) -> None:
        scene = self.folder / "m.toml"
        lines = [f"{s},{uniaxial_stress('ogden=3.7', 2e5, 0.48, s)!r}" for s in
                 (0.7, 0.9, 1.2, 1.5, 1.9, 2.3)]
        test = self.csv("stretch,stress\n" + "\n".join(lines))
        done = self.run_verb("materials", "fit", test, "-o", scene, "--json")
        self.assertEqual(done.code, 0, done.err)
        told = json.loads(done.out)
        best = told["laws"][0]
        self.assertRegex(best["law"], "^ogden=")
        self.assertAlmostEqual(float(best["law"].partition("=")[2]), 3.7, 4)
        self.assertAlmostEqual(best["young"] / 2e5, 1, 6)
        self.assertEqual((told["points"], told["poisson"], told["warnings"]), (6, 0.48, []))
        self.assertEqual(told["material"], {"law": "ogden=3.7", "young": 2e5, "poisson": 0.48})
        self.assertTrue(told["net"]["passes"])
        errors = [fit.get("error", np.inf) for fit in told["laws"]]
        self.assertEqual(errors, sorted(errors))
        bar = write_obj(self.folder / "bar.obj", *turned_box((1, 0.25, 0.25), (0, 0, 1), 0))
        shown = self.run_verb("animate", bar, "--scene", scene, "--print-resolved")
        self.assertEqual(shown.code, 0, shown.err)
        material = json.loads(shown.out)["material"]
        self.assertEqual({key: material[key] for key in told["material"]}, told["material"])
        clip = self.run_verb("animate", bar, "--scene", scene, "--energy", "neural", "-o",
                             self.folder / "a.glb", "--voxels", 8, "--frames", 2, "--pin", "x<5%",
                             "--quiet")
        self.assertEqual(clip.code, 0, clip.err)

    def test_fits_named_laws_only(self) -> None:
        done = self.run_verb("materials", "fit", self.hencky(0.3), "--law", "ogden", "--law",
                             "gent=30", "--poisson", 0.3, "--json")
        self.assertEqual(done.code, 0, done.err)
        told = json.loads(done.out)
        self.assertEqual([fit["law"].partition("=")[0] for fit in told["laws"]], ["ogden", "gent"])
        self.assertEqual(told["laws"][1]["law"], "gent=30")
        # the exponent of Ogden's law that is Hencky's is 0
        self.assertAlmostEqual(float(told["laws"][0]["law"].partition("=")[2]), 0, 4)
        self.assertAlmostEqual(told["laws"][0]["young"] / 9e5, 1, 6)
        worst = told["laws"][1]["worst"]
        self.assertIn(worst["mode"], ("uniaxial", "shear", "biaxial"))
        self.assertGreaterEqual(worst["error"], told["laws"][1]["error"])

    def test_says_what_lies_beyond_the_net(self) -> None:
        stress = [0.3e6 * (s - s**-2) * 70 / (73 - s * s - 2 / s) for s in (1.5, 2, 3, 4, 5)]
        test = self.csv("stretch,stress\n" + "\n".join(
            f"{s},{p}" for s, p in zip((1.5, 2, 3, 4, 5), stress)))
        done = self.run_verb("materials", "fit", test, "--poisson", 0.499)
        self.assertEqual(done.code, 0, done.err)
        self.assertIn("warning: 3 of 5 points lie beyond log stretches of 0.9", done.err)
        self.assertIn("stvk                       without equilibrium", done.out)
        self.assertRegex(done.out, r'law = "gent=(6|7)\d')

    def test_refuses_bad_files_by_line_and_column(self) -> None:
        scene = self.folder / "m.toml"
        for code, text, told in (
                (3, "stretch,stress\n1.5,x\n", "test.csv, line 2, column 2 (stress): 'x'"),
                (3, "mode,stretch,stress\nbend,1,2\n", "line 2, column 1 (mode)"),
                (3, "strain,stress\n130,2\n", "line 2, column 1 (strain)"),
                (3, "length,stress\n1,2\n", "line 1, column 1: unknown column 'length'"),
                (3, "stretch,stress [N]\n1,2\n", "line 1, column 2"),
                (3, "stretch,stress\n1.2,1\n1.3\n", "line 3: expected 2 columns"),
                (3, "", "at least two points"),
                (3, "stretch,stress\n1.2,-1\n1.3,-2\n", "positive in tension")):
            with self.subTest(text=text):
                done = self.run_verb("materials", "fit", self.csv(text), "-o", scene)
                self.refused(done, code, told)
                self.assertFalse(scene.exists())
        self.refused(self.run_verb("materials", "fit", self.folder / "none.csv"), 3, "none.csv")
        self.refused(self.run_verb("materials", "fit", self.folder), 3)
        good = self.hencky(0.3)
        for words, told in ((("--law", "jam"), "unknown law 'jam'"), (("--poisson", 0.5), "0.499"),
                            (("-o", self.folder / "m.txt"), ".toml"),
                            (("--law", "0.5*stvk+0.5*hencky"), "unknown law")):
            with self.subTest(words=words):
                self.refused(self.run_verb("materials", "fit", good, *words), 2, told)
        self.refused(self.run_verb("materials", "fit", good, "--law", "hencky", "-o",
                                   self.folder / "no/m.toml"), 6, "m.toml")
        same = self.folder / "same.toml"
        same.write_text(good.read_text())
        self.refused(self.run_verb("materials", "fit", same, "-o", same), 2, "same.toml")
        self.assertEqual(same.read_text(), good.read_text())
        stretched = self.csv("stretch,stress\n2,1\n3,2\n")
        self.refused(self.run_verb("materials", "fit", stretched, "--law", "stvk"), 3,
                     "stvk has none at uniaxial 2 (line 2)")


if __name__ == "__main__":
    unittest.main()
