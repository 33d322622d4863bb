# SPDX-License-Identifier: Apache-2.0
"""The tables of metal frames in docs/papers.md, from docs/results/metal_frame.json: under `scenes`
what `bench_metal_frame SCENE.toml --json FILE` wrote for each, without times where others worked on the
machine."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results"
Lines = tuple[list[str], list[list[str]]]  # head and rows of a table


def scenes() -> list[dict[str, Any]]:
    """What each run of the program wrote."""
    found: list[dict[str, Any]] = json.loads((RESULTS / "metal_frame.json").read_text())["scenes"]
    return found


def runs() -> Lines:
    """Each run against the fine one, and its step in explicit ones of its scene."""
    lines = []
    for scene in scenes():
        full = [r for r in scene["rows"] if r["name"].startswith("explicit")]
        unit = full[-1].get("seconds_a_step") if full and full[-1]["young"] == scene["rows"][0]["young"] else None
        frames = len(scene["rows"][0]["distance"])
        for r in scene["rows"]:
            is_fine = r["dt"] == scene["fine"]
            played = len(r["distance"])
            few = "" if played == frames else f", {played} frames" if played > 1 else ", 1 frame"
            lines.append([scene["scene"].removesuffix(".toml"), r["name"] + few, f"{r['young']:.0e}",
                          f"{1e3 * r['seconds_a_step']:.3g}" if "seconds_a_step" in r else "",
                          f"{r['solves'] / r['steps']:.1f}" if r["solves"] else "",
                          str(r["drafts"]) if r["solves"] else "",
                          "reference" if is_fine else f"{r['worst']:.1e}",
                          "" if is_fine else f"{r['mean']:.1e}",
                          f"{r['seconds_a_step'] / unit:.0f}" if unit and "seconds_a_step" in r else ""])
    return ["scene", "run", "E [Pa]", "ms a step", "solves a step", "drafts",
            "distance, worst frame", "mean", "explicit steps"], lines


def pushes() -> Lines:
    """The plate's force over its way, by the frame of triangles: every fifth frame."""
    scene = scenes()[0]
    rows = [r for r in scene["rows"] if r["name"].startswith("implicit")]
    lines = [[f"{(f + 1) * scene['frame']:.2f}", " / ".join(f"{-r['push'][f] / 1e3:.2f}" for r in rows)]
             for f in range(4, len(rows[0]["push"]), 5)]
    names = " / ".join(f"{r['dt']:g}" for r in rows)
    return ["time [s]", f"force down [kN], by steps of {names} s"], lines


TABLES: dict[str, Callable[[], Lines]] = {"metal runs": runs, "metal pushes": pushes}
