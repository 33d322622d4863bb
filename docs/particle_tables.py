# SPDX-License-Identifier: Apache-2.0
"""Tables of the integrators of particles, from docs/results/particles.json."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results" / "particles.json"
COLLAPSE = RESULTS.with_name("collapse.json")
CONTACT = RESULTS.with_name("particle_contact.json")
Lines = tuple[list[str], list[list[str]]]
# Li et al. 2022, table 1: dt of both, seconds a frame of the implicit and of the explicit run
PUBLISHED = {"sand": (1e-3, 1e-5, 12.58, 6.20), "snow": (1e-3, 1e-5, 35.56, 6.78)}


def studies() -> list[dict[str, Any]]:
    return json.loads(RESULTS.read_text())["studies"]


def run_of(row: dict[str, Any], integrator: str) -> dict[str, Any] | None:
    """Its implicit run, or the explicit one with the smallest dt and a transfer after each step."""
    runs = [r for r in row["runs"] if r["integrator"] == integrator and r["substeps"] == 1]
    return min(runs, key=lambda r: r["dt"]) if runs else None


def pair(values: dict[str, float]) -> str:
    return f"{values['worst']:.3f} / {values['mean']:.3f}"


def machine(row: dict[str, Any]) -> str:
    """What a study ran on."""
    beside = ", beside other work" if row.get("at_once", 1) > 1 else ""
    return f"{row['cpu']}, one thread{beside}"


def machines() -> Lines:
    """Which studies ran on what."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for row in studies():
        found.setdefault((machine(row), row["commit"], row["date"][:10]), []).append(row["name"])
    return ["studies", "processor", "commit", "day"], [["; ".join(names), *of] for of, names in found.items()]


def comparison() -> Lines:
    """Every run against the substeps between the same transfers."""
    lines = []
    for row in studies():
        for k, run in enumerate(row["runs"]):
            to = run["to_sub"]
            is_reference = run["name"] == row["sub_reference"]
            implicit = run["integrator"] == "implicit"
            lines.append([row["name"] if k == 0 else "", run["name"], f"{1e3 * run['step_seconds']:.3g}",
                          f"{run['solves_a_step']:.1f}" if implicit else "",
                          f"{run['iterations_a_step']:.0f}" if implicit else "",
                          f"{run['not_converged']} of {run['steps']}" if implicit else "",
                          *(["reference", "", ""] if is_reference else
                            [pair(to["iou_w"]), pair(to["iou_b"]), pair(to["iou_soft_scaled"])]),
                          "" if is_reference else f"{100 * run['front_apart']:.1f} %" if "front_apart" in run else "",
                          f"{run['last']['half_width']:.3f}", f"{run['last']['top']:.3f}"])
    return ["study", "run", "ms from transfer to transfer", "solves", "iterations", "not converged",
            "`iou_w` worst / mean", "`iou_b`", "`iou_soft_scaled`", "front apart", "half width [m]", "top [m]"], lines


def against_explicit() -> Lines:
    """Time and likeness of implicit steps against explicit ones, beside the published numbers."""
    lines = []
    for row in studies():
        implicit, plain = run_of(row, "implicit"), run_of(row, "explicit")
        if not implicit or not plain:
            continue
        equivalents = implicit["step_seconds"] / plain["step_seconds"]
        ratio = implicit["dt"] / plain["dt"]
        published = ["", "", ""]
        if row["name"] in PUBLISHED:
            dt, fine, ours, theirs = PUBLISHED[row["name"]]
            published = [f"{dt:g} / {fine:g}", f"{ours / theirs * dt / fine:.0f}",
                         f"{theirs / ours:.2f}"]
        lines.append([row["name"], f"{implicit['dt']:.3g}", f"{implicit['step_seconds']:.3g}",
                      f"{implicit['solves_a_step']:.1f}", f"{plain['dt']:.3g}",
                      f"{plain['step_seconds']:.3g}", f"{equivalents:.0f}", f"{ratio / equivalents:.2f}",
                      pair(implicit["to_explicit"]["iou_w"]), *published])
    return ["study", "dt implicit [s]", "s a step", "solves a step", "dt explicit [s]", "s a step",
            "explicit steps an implicit one costs", "faster by", "`iou_w` to explicit",
            "published: dt", "explicit steps", "faster by"], lines


def collapse() -> Lines:
    """Columns of sand that collapse: run-out and slope."""
    return ["aspect a", "angle of friction, in the plane [degrees]", "h [mm]", "particles",
            "run-out (L - l)/l", "over 1.2 a", "top/l", "slope [degrees]", "volume", "drafts"], [
        [f"{r['aspect']:g}", f"{r['angle']:g}, {r['plane_angle']:.1f}", f"{1e3 * r['h']:g}",
         str(r["particles"]), f"{r['run_out']:.2f}", f"{r['run_out'] / (1.2 * r['aspect']):.2f}",
         f"{r['top']:.2f}", f"{r['slope']:.1f}", f"{r['volume']:.4f}", str(r["drafts"])]
        for r in json.loads(COLLAPSE.read_text())["rows"]]


def contact_rows(member: str) -> list[dict[str, Any]]:
    """Rows that have a member."""
    return [r for r in json.loads(CONTACT.read_text())["rows"] if member in r]


def plates() -> Lines:
    """A plate on a bar: where the force begins, and by how much the bar is too short."""
    return ["h [mm]", "top above a line of nodes [h]", "gap where the force begins [h]", "of the highest nodes [h]",
            "too short where the plate meets the top [h]", "2.1 mm later [h]", "drafts"], [
        [f"{1e3 * r['h']:g}", f"{r['above']:g}", f"{r['begins'] / r['h']:.2f}", f"{r['expected'] / r['h']:.2f}",
         f"{(r['shorter_at_touch'] + r['gap']) / r['h']:.2f}",
         f"{(r['shorter_at_end'] + r['gap_at_end']) / r['h']:.2f}", str(r["drafts"])]
        for r in contact_rows("begins")]


def balls() -> Lines:
    """A ball pressed into metal, of particles and of finite elements."""
    return ["h [mm]", "method", "points", "depth of the surface [mm]", "missing to 4 mm [h]", "drafts"], [
        [f"{1e3 * r['h']:g}", {"mpm": "particles", "fem": "`hex-bbar`"}[r["method"]], str(r["points"]),
         f"{1e3 * r['depth']:.2f}", f"{(r['pressed'] - r['depth']) / r['h']:.2f}", str(r["drafts"])]
        for r in contact_rows("depth")]


TABLES = {"column collapse": collapse, "particles": comparison, "particles against explicit": against_explicit,
          "particle machines": machines, "particle plates": plates, "particle balls": balls}
