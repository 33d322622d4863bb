# SPDX-License-Identifier: Apache-2.0
"""A band over a round obstacle: the tensions on both sides differ by exp(mu phi) while it slips."""

import tempfile
import unittest
from pathlib import Path

import command
import numpy as np
from command import Floats
from point_cache import read_pc2

RADIUS, THICK, WIDE, TAIL = 0.5, 0.05, 0.1, 0.5  # of the obstacle and the band [m]
YOUNG, FRICTION = 2e6, 0.3
LOADED, LOAD = 0.2, 20.0  # length of the loaded end [m] and its mass [kg]


def centre_line() -> tuple[Floats, Floats]:
    """Points along the band from its held to its moved end, and the directions out of it."""
    tail = np.arange(-TAIL, -1e-9, THICK / 2)
    angle = np.linspace(np.pi, 0, 1 + round(np.pi * RADIUS / (THICK / 2)))
    arc = np.stack([np.cos(angle), np.sin(angle)], 1)
    left = np.stack([np.full(len(tail), -1.0), np.zeros(len(tail))], 1)
    out = np.concatenate([left, arc, -left])
    height = np.concatenate([tail, np.zeros(len(arc)), tail[::-1]])
    inner = RADIUS * out + np.stack([np.zeros(len(height)), height], 1)
    return inner, out


def write_band(path: Path) -> None:
    """The band as a closed mesh of quads, four vertices for each point of its line."""
    inner, out = centre_line()
    lines, count = [], len(inner)
    for p, n in zip(inner, out):
        for depth, z in ((0, -WIDE / 2), (THICK, -WIDE / 2), (THICK, WIDE / 2), (0, WIDE / 2)):
            x, y = p + depth * n
            lines.append(f"v {x:.9g} {y:.9g} {z:.9g}")
    faces = [[4 * k + a, 4 * k + (a + 1) % 4, 4 * k + 4 + (a + 1) % 4, 4 * k + 4 + a]
             for k in range(count - 1) for a in range(4)]
    faces += [[3, 2, 1, 0], [4 * count - 4 + a for a in range(4)]]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def strains(frames: Floats) -> tuple[float, float]:
    """Of both tails at the end, between 5 and 25 cm below the axis."""
    rest, end = (frame.reshape(-1, 4, 3).mean(axis=1) for frame in (frames[0], frames[-1]))
    result = []
    for side in (-1, 1):
        rows = [np.abs(rest[:, :2] - (side * (RADIUS + THICK / 2), y)).sum(axis=1).argmin()
                for y in (-0.05, -0.25)]
        before, after = (np.linalg.norm(x[rows[0]] - x[rows[1]]) for x in (rest, end))
        result.append(float(after / before - 1))
    return result[0], result[1]


class Band(unittest.TestCase):
    """One end of a light band is held, the other one has a load, which damping lets down slowly."""

    def tension_ratio(self, verb: str, *steps: object) -> float:
        """Of the loaded side over the held one."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_band(folder / "band.obj")
            density = LOAD / (THICK * WIDE * LOADED)
            law = f"law=neo-hookean,young={YOUNG:g},poisson=0.3"
            done = command.run(
                verb, folder / "band.obj", "-o", folder / "o.pc2", "--quiet", "--up", "y", "--h",
                THICK / 2, "--young", YOUNG, "--poisson", 0.3, "--density", 20, "--law",
                "neo-hookean", "--region",
                f"box(0.49,-0.51,-0.06, 0.56,{LOADED - 0.5:g},0.06): rubber,{law},density={density:g}",
                "--damping", 2, "--damping-frequency", "2Hz", "--pin",
                "box(-0.56,-0.51,-0.06, -0.49,-0.46,0.06)",
                "--collider", f"sphere(0,0,0, {RADIUS})", "--friction", FRICTION, "--no-strict-time",
                "--fps", 30, "--frames", 90, *steps, timeout=500)
            self.assertEqual(done.code, 0, done.err)
            held, loaded = strains(read_pc2(folder / "o.pc2"))
        self.assertAlmostEqual(loaded, LOAD * 9.81 / (THICK * WIDE * YOUNG), delta=0.002)
        return loaded / held

    def assert_capstan(self, *steps: object) -> None:
        ratio, exact = self.tension_ratio("animate", *steps), np.exp(FRICTION * np.pi)
        print(f"{steps}: {ratio:.4f}, exact {exact:.4f}")
        self.assertLess(abs(ratio / exact - 1), 0.05)


class Capstan(Band):
    """At defaults."""

    def test_the_tensions_differ_by_the_exponential_of_friction_and_angle(self) -> None:
        self.assert_capstan()


class FineCapstan(Band):
    """At 16 steps a frame, which takes two minutes: not among the tests of ctest."""

    def test_so_they_do_in_short_steps(self) -> None:
        self.assert_capstan("--substeps", 16)


if __name__ == "__main__":
    unittest.main()
