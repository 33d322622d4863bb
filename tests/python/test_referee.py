# SPDX-License-Identifier: Apache-2.0
"""Self-tests of the referee on synthetic state files whose residual is known in closed form."""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import collision
import equations
import referee
from synthetic import (GRAVITY, H, add_contact, make_state, ragged_grid, roll_out, stage_records,
                       step_arrays, write_state)

SEVEN = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1), (2, 1, 1), (0, 1, 0), (0, 0, 1)]


class Tool(unittest.TestCase):
    """The command on files whose residual is known in closed form.

    The steps are solved exactly under one gravity and recorded with another: the gradient is then
    -m dg on every free node, and the residual |dg|/g_ref for both time schemes.
    """

    state = make_state(cells=SEVEN)
    schemes = [0, 1, 1, 0]
    change = np.array([0.0, 3e-3, 4e-3])
    residual = 5e-3 / 9.81

    @classmethod
    def setUpClass(cls) -> None:
        cls.x, cls.v = roll_out(cls.state, cls.schemes)
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name) / "state.h5"

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def write(self, **options: Any) -> None:
        steps = step_arrays(self.state, self.x, self.v, self.schemes, self.residual)
        write_state(self.path, self.state, steps, GRAVITY + self.change, **options)

    def run_tool(self, *options: str) -> tuple[int, str]:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            status = referee.main([str(self.path), *options])
        return status, out.getvalue()

    def tampered(self, place: str, change: Any, *options: str) -> str:
        """Output after `change(array)` of one dataset; the tool must fail."""
        self.write()
        with h5py.File(self.path, "r+") as file:
            values = file[place][()]
            change(values)
            file[place][...] = values
        status, output = self.run_tool(*options)
        self.assertEqual(status, 1, output)
        return output

    def broken(self, change: Any) -> str:
        """Output after `change(file)` of the layout; the tool must fail."""
        self.write()
        with h5py.File(self.path, "r+") as file:
            change(file)
        status, output = self.run_tool()
        self.assertEqual(status, 1, output)
        return output

    def test_steps_of_known_residual_agree(self) -> None:
        for compound in (True, False):
            self.write(compound=compound)
            status, output = self.run_tool("--energy-check")
            self.assertEqual(status, 0, output)
            self.assertEqual(len(output.splitlines()), 1)
            self.assertIn("4 of 4 steps", output)

    def test_own_residual_is_exact_for_both_schemes(self) -> None:
        self.write()
        with h5py.File(self.path) as file:
            verdict = referee.judge(referee.read_state(file), False)
        own = [c.own for c in verdict.checks if c.quantity == "residual"]
        np.testing.assert_allclose(own, self.residual, rtol=1e-6)
        for factor in verdict.factors.values():
            self.assertAlmostEqual(factor, 1, 9)

    def test_json_says_the_same(self) -> None:
        self.write()
        verdict = json.loads(self.run_tool("--json")[1])
        self.assertTrue(verdict["agrees"])
        self.assertEqual(verdict["steps"], 4)
        self.assertEqual({row["quantity"] for row in verdict["worst"]},
                         {"mass", "residual", "converged", "velocity"})

    def test_tampered_values_are_caught(self) -> None:
        def add(index: Any, value: float) -> Any:
            return lambda a: a.__setitem__(index, a[index] + value)

        def scale(index: Any, value: float) -> Any:
            return lambda a: a.__setitem__(index, a[index] * value)

        free = int(np.flatnonzero(self.state.grid["pinned"] == 0)[0])
        for place, change, word in (
                ("steps/x", add((2, free, 1), 1e-4 * H), "residual"),
                ("steps/v", add((0, free, 1), 0.02), "residual"),
                ("steps/v", add((4, free, 0), 0.001), "velocity"),
                ("steps/residual", scale(3, 0.9), "residual"),
                ("steps/converged", add(1, -1), "converged"),
                ("steps/scheme", lambda a: a.__setitem__(2, 0), "residual"),
                ("grid/hourglass", scale(slice(None), 1.2), "residual"),
                ("grid/mass", scale(free, 1.01), "mass"),
                ("steps/energy_kinetic", scale(1, 1.1), "energy_kinetic")):
            self.assertIn(word, self.tampered(place, change, "--energy-check"), place)

    def test_without_torsion_the_full_steps_disagree(self) -> None:
        output = self.broken(lambda f: f.attrs.modify("hourglass", "variance"))
        self.assertIn("residual", output.splitlines()[2])

    def test_wrong_layout_is_named(self) -> None:
        def retype(name: str, kind: str) -> Any:
            def change(file: h5py.File) -> None:
                values = file[name][()].astype(kind)
                del file[name]
                file[name] = values
            return change

        for change, word in (
                (lambda f: f.attrs.pop("g_ref"), "g_ref"),
                (lambda f: f.attrs.modify("version", 1), "version"),
                (lambda f: f.attrs.modify("solver", "magic"), "solver"),
                (lambda f: f.pop("grid/fill"), "fill"),
                (lambda f: f.create_group("collider"), "collider"),
                (lambda f: f["steps"].create_dataset("extra", data=[1.0]), "extra"),
                (retype("steps/x", "f4"), "/steps/x"),
                (retype("grid/corners", "i8"), "/grid/corners"),
                (lambda f: f["grid/corners"].write_direct(np.full((7, 8), 99, "i4")), "corners"),
                (lambda f: f["grid/shape_mean"].write_direct(np.full((7, 8), 0.1)), "shape_mean"),
                (lambda f: f["steps/scheme"].write_direct(np.ones(4, np.uint8)), "scheme"),
                (lambda f: f["steps/x"].write_direct(np.full(self.x.shape, np.nan)), "finite")):
            self.assertIn(word, self.broken(change))

    def test_contact_is_part_of_the_residual_and_its_layout_is_checked(self) -> None:
        """At rest the residual is that of the contact forces alone."""
        state = make_state(cells=SEVEN)
        rest = np.repeat(state.grid["rest"][None], 3, axis=0)
        offsets = np.zeros((3, 3, 3))
        offsets[2, 1] = [1e-3 * H, 0, 0]
        add_contact(state, state.grid["rest"], offsets)
        own = []
        for step in (0, 1):
            energy, gradient = collision.contact(state, step, rest[0], rest[0])
            self.assertGreater(energy, 0)
            own.append(equations.residual(equations.make_body(state), gradient, state.g_ref))
        steps = step_arrays(state, rest, np.zeros_like(rest), [0, 1], 1.0)
        steps["residual"] = np.array(own)
        steps["converged"][:] = 0
        write_state(self.path, state, steps, np.zeros(3))
        status, output = self.run_tool()
        self.assertEqual(status, 0, output)

        def change(name: str, index: Any, value: float) -> Any:
            def write(file: h5py.File) -> None:
                values = file[f"contact/{name}"][()]
                values[index] = value
                file[f"contact/{name}"][...] = values
            return write

        for edit, word in (
                (lambda f: f["contact"].attrs.pop("layer"), "layer"),
                (lambda f: f["contact"].pop("half"), "half"),
                (change("shape", 0, 3), "shape"), (change("voxel", 0, 7), "voxel"),
                (change("normal", (0, 0), 0.5), "normal"), (change("area", 0, -1), "area"),
                (change("offset", (1, 2, 0), np.nan), "offset"),
                (change("radius", 1, 1.005), "residual"),
                (change("offset", (2, 1, 1), 0.1 * H), "residual"),
                (change("centre", (0, 0), 9.0), "residual")):
            write_state(self.path, state, steps, np.zeros(3))
            with h5py.File(self.path, "r+") as file:
                edit(file)
            status, output = self.run_tool()
            self.assertEqual(status, 1, word)
            self.assertIn(word, output)

    def test_truncated_file_is_refused(self) -> None:
        self.write()
        self.path.write_bytes(self.path.read_bytes()[:5000])
        status, output = self.run_tool()
        self.assertEqual(status, 1)
        self.assertIn("DISAGREES", output)

    def test_rest_state_without_gravity_has_residual_zero(self) -> None:
        rest = np.repeat(self.state.grid["rest"][None], 3, axis=0)
        steps = step_arrays(self.state, rest, np.zeros_like(rest), [0, 1], 0.0)
        write_state(self.path, self.state, steps, np.zeros(3))
        status, output = self.run_tool("--json")
        self.assertEqual(status, 0, output)
        worst = {row["quantity"]: row for row in json.loads(output)["worst"]}
        self.assertLess(worst["residual"]["own"], 1e-10)

    def test_density_factor_of_each_material_is_found(self) -> None:
        state = make_state(cells=SEVEN, laws=("stvk", "hencky"))
        grid = ragged_grid(1, SEVEN, state.materials)
        true = [1.25, 0.8]
        share = np.zeros((2, len(grid["mass"])))
        for k in range(2):
            mine = grid["material"] == k
            part = state.materials[k].density * H**3 * grid["fill"][mine, None]
            np.add.at(share[k], grid["corners"][mine], part * grid["shape_mean"][mine])
        state.grid["mass"][:] = true @ share
        factors, error = equations.mass_factors(state)
        np.testing.assert_allclose(factors, true, rtol=1e-10)
        self.assertLess(error, 1e-10)


class Records(unittest.TestCase):
    """The command on a file that is changed."""

    records = staticmethod(stage_records)

    @classmethod
    def setUpClass(cls) -> None:
        cls.state, cls.steps = cls.records()
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name) / "state.h5"

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def run_tool(self, change: Any = None) -> tuple[int, str]:
        """Status and output after `change(file)`."""
        write_state(self.path, self.state, self.steps, GRAVITY)
        if change:
            with h5py.File(self.path, "r+") as file:
                change(file)
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            status = referee.main([str(self.path)])
        return status, out.getvalue()

    def assert_says(self, word: str, change: Any) -> None:
        """The command fails on the changed file and names what is wrong."""
        status, output = self.run_tool(change)
        self.assertEqual(status, 1, word)
        self.assertIn(word, output)


def add(place: str, index: Any, by: Any, factor: float = 1) -> Any:
    """A change of some numbers of a dataset."""
    def write(file: h5py.File) -> None:
        values = file[place][()]
        values[index] = values[index] * factor + by
        file[place][...] = values
    return write


class Stages(Records):
    """Steps made by stages."""

    def test_what_it_finds_itself_agrees(self) -> None:
        status, output = self.run_tool()
        self.assertEqual(status, 0, output)
        self.assertIn("4 of 4 steps", output)

    def test_a_wrong_number_of_each_field_is_caught(self) -> None:
        free = len(self.state.grid["mass"]) - 1  # a node of the free piece
        held = int(np.flatnonzero(self.state.grid["pinned"] == 0)[0])  # of the other one
        rubs = np.unravel_index(np.abs(self.steps_bonds(1)).argmax(), self.steps_bonds(1).shape)
        for place, index, by, factor, word in (
                ("steps/x", (1, free, 0), 1e-4 * H, 1, "residual"),
                ("steps/x_stage", (2, free, 1), 1e-4 * H, 1, "residual"),
                ("steps/v", (1, held, 1), 0.05, 1, "residual"),
                ("steps/v", (4, free, 1), 1e-3, 1, "velocity"),
                ("steps/scheme", 3, 1, 1, "residual"),
                ("steps/residual", 2, 0, 1.1, "residual"),
                ("steps/tolerance", 1, 1e9, 1, "converged"),
                ("contact/bonds", (1, *rubs), 0, 1.01, "bonds"),
                ("contact/friction", 2, -0.3, 1, "residual"),
                ("contact/offset", (3, 0, 1), 0.02 * H, 1, "residual"),
                ("grid/mass", free, 0, 1.01, "mass")):
            self.assert_says(word, add(place, index, by, factor))
        for field, factor in (("loss_factor", 1.2), ("loss_frequency", 0.8)):
            status, output = self.run_tool(lambda f: f["materials"].write_direct(
                self.scaled(f["materials"][()], field, factor)))
            self.assertEqual(status, 1, field)
            self.assertIn("residual", output)

    @staticmethod
    def scaled(table: Any, field: str, factor: float) -> Any:
        table[field] *= factor
        return table

    def steps_bonds(self, record: int) -> Any:
        return self.state.contact["bonds"][record]

    def test_lengths_belong_to_the_times(self) -> None:
        def change(file: h5py.File) -> None:
            file["steps/length"][1] *= 1.001
        status, output = self.run_tool(change)
        self.assertEqual(status, 1)
        self.assertIn("/steps/time", output)

    def test_velocities_of_guarded_steps_are_left_and_said_to_be(self) -> None:
        def change(file: h5py.File) -> None:
            file["steps/guarded"][3] = 1
            file["steps/v"][4] *= 0.9
        status, output = self.run_tool(change)
        self.assertEqual(status, 0, output)
        self.assertIn("velocities of 1 guarded steps", output)

    def test_moved_nodes_leave_a_held_piece_without_reference(self) -> None:
        status, output = self.run_tool(lambda f: f.attrs.modify("moved", 1))
        self.assertEqual(status, 1)
        self.assertIn("residual", output)

    def test_wrong_layout_is_named(self) -> None:
        for change, word in ((lambda f: f["steps"].pop("x_stage"), "x_stage"),
                             (lambda f: f["contact"].pop("bonds"), "bonds"),
                             (lambda f: f["steps"].pop("guarded"), "guarded"),
                             (lambda f: f["steps/scheme"].write_direct(np.full(4, 3, np.uint8)),
                              "scheme"),
                             (lambda f: f["steps/scheme"].write_direct(np.ones(4, np.uint8)),
                              "BDF2")):
            status, output = self.run_tool(change)
            self.assertEqual(status, 1, word)
            self.assertIn(word, output)


if __name__ == "__main__":
    unittest.main()
