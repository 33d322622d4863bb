# SPDX-License-Identifier: Apache-2.0
"""Tables of motion: ten scenes against fine steps (docs/results/motion.json, bench/motion.py), five before and after
(before_after.json, bench/before_after.py), total error over time (total_error.json, bench/total_error.py), what an impact
costs by steps a frame (impact_cost.json, bench/impact_cost.py)."""

from __future__ import annotations

import json
from pathlib import Path
from statistics import median
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results"
Lines = tuple[list[str], list[list[str]]]


def read(name: str) -> dict[str, Any]:
    return json.loads((RESULTS / f"{name}.json").read_text())


def measured_on(name: str) -> str:
    """Commit, day and machine of a result."""
    head = read(name)["header"]
    return f"Commit {head['commit']}, {head['date']}, {head['cpu']}."


def share(value: float) -> str:
    """In per cent."""
    return f"{100 * value:.3g} %" if abs(value) > 0.995 else f"{100 * value:.2g} %"


def scenes() -> Lines:
    lines = []
    for name, r in read("motion")["scenes"].items():
        lines.append([name, str(r["voxels"]), f"{share(r['error_at_the_end'])}, {share(r['largest_error'])}",
                      f"{r['said_over_true']:.2g}", f"{r['solves_a_frame']:.2g}", f"{r['frames_over']} of {r['frames']}",
                      f"{r['energy_rise']:.0e}", f"{r['fine_energy_rise']:.0e}"])
    return ["scene", "voxels", "error at the end, largest", "said / true", "solves a frame", "frames that missed 0.5 %",
            "rise of energy", "in fine steps"], lines


def whole(r: dict[str, Any], rough: bool) -> str:
    """The median of what is said over the whole error of frames, of which a part is left out."""
    before, ratios = False, []
    for frame in r["local"]["frames"]:
        is_rough, before = frame["touches"] or before, frame["touches"]
        kick = frame["kick"] if rough else 0
        if is_rough == rough and max(frame["estimate"], frame["shown"] + kick) > 0.1 * frame["accepted"]:
            ratios.append(frame["estimate"] / (frame["error"] + kick))
    return f"{median(ratios):.2g}" if ratios else ""


def frames() -> Lines:
    lines = []
    for name, r in read("motion")["scenes"].items():
        cells = []
        for kind in ("smooth", "rough"):
            part = r["local"][kind]
            cells += ([str(part["count"]), f"{part['median']:.2g}", f"{part['tenth']:.2g} ... {part['ninetieth']:.2g}",
                       whole(r, kind == "rough")] if part["count"] else ["0", "", "", ""])
        lines.append([name, *cells])
    columns = ["median", "10 ... 90 % of them", "whole"]
    return ["scene", "smooth frames", *columns, "frames with contact", *columns], lines


def before_after() -> Lines:
    """Implicit Euler, now, fine steps."""
    rows = read("before_after")["rows"]
    slide = [f"{1e3 * abs(rows['slide'][k]):.2g} mm, {1e3 * abs(rows['slide'][k + 1]):.1g} mm" for k in (0, 2)]
    return ["scene", "implicit Euler", "now", f"{read('before_after')['fine']} steps of SDIRK2 a frame", "exact"], [
        ["spin of 10 rad/s: angular momentum that is left", *map(share, rows["spin"]), "100 %"],
        ["pendulum, let go at 1.2 rad: error of its centre over its way", *map(share, rows["pendulum"][:2]), "0", ""],
        ["bar that vibrates in 16 frames: amplitude that is left", *map(share, rows["ringing"]), "100 %"],
        ["ball of 0.5 MPa that falls 1 m: how high it hops", *(f"{max(h, 0):.2f} m" for h in rows["hop"]), ""],
        ["block on a slope of 20 degrees, friction 0.5: slides in 1.5 s, in the last half second", *slide, "", "0"]]


def total_error() -> Lines:
    """Error and time of each run."""
    lines = []
    for name, scene in read("total_error")["scenes"].items():
        for r in scene["rows"]:
            tolerance = f"{r['tolerance']:g}" if "tolerance" in r else ""
            mesh = r["said_mesh_error"]
            lines.append([name, r["solver"], f"{1e3 * r['h']:g}", str(r["voxels"]), f"{100 * r['time_error']:g} %", tolerance,
                          share(r["error"]), share(r["said_time_error"] / scene["motion"]),
                          share(mesh / scene["motion"]) if mesh else "", str(r["solves"]), f"{r['seconds']:.2g}"])
    return ["scene", "solver", "h [mm]", "voxels", "`--time-error`", "`--tolerance`", "total error", "time error said",
            "mesh error said", "solves", "time [s]"], lines


def truths() -> Lines:
    """What the runs are held against."""
    return ["scene", "h of the truth [mm]", "steps of SDIRK2 a frame", "a coarser truth is off by", "largest motion [m]"], [
        [name, f"{1e3 * s['truth_h']:.3g}", str(s["truth_steps"]), share(s["truth_moved"]), f"{s['motion']:.2g}"]
        for name, s in read("total_error")["scenes"].items()]


def peers() -> Lines:
    """The bar that swings, by another program."""
    return ["element", "cells", "steps of implicit Euler a frame", "total error", "time of the solves [s]"], [
        [r["element"], "x".join(map(str, r["cells"])), str(r["steps_a_frame"]), share(r["error"]), f"{r['seconds']:.2g}"]
        for r in read("total_error")["peers"]]


def impact() -> Lines:
    """V-cycles of an impact by steps a frame, with friction and without."""
    rows = {(r["voxels"], r["steps"], r["friction"] > 0): r for r in read("impact_cost")["rows"]}
    lines = []
    for voxels, steps in dict.fromkeys(key[:2] for key in rows):
        with_it, without = (rows[voxels, steps, rubs] for rubs in (True, False))
        over = [f"{r['inner'] / rows[voxels, 1, rubs]['inner']:.2f}" for r, rubs in ((with_it, True), (without, False))]
        lines.append([str(voxels), str(steps) if steps else "`auto`", str(with_it["inner"]), str(without["inner"]),
                      f"{with_it['inner'] / without['inner']:.2f}", *over, str(with_it["solves"]), str(without["solves"]),
                      f"{share(with_it['converged'])}, {share(without['converged'])}"])
    return ["voxels along", "steps a frame", "V-cycles with friction", "without", "ratio", "with, over one step a frame",
            "without, over one", "minima with", "without", "steps within the tolerance"], lines


TABLES = {"motion scenes": scenes, "motion frames": frames, "before after": before_after, "total error": total_error,
          "total truths": truths, "total peers": peers, "impact cost": impact}
MACHINES = {f"{title} machine": (lambda of=name: measured_on(of)) for title, name in (
    ("motion", "motion"), ("before after", "before_after"), ("total", "total_error"),
    ("impact", "impact_cost"))}
