#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Figures of what `elastogen bench --json` wrote, as SVG without any library.

    bench/plot.py BENCH.json [BENCH.json ...] --out FOLDER [--peers PEERS.json]

error_time_*.svg: error of a step over its time, a figure a scene, a line a solver (parts error-time
and baseline). step.svg: time of a step over voxels, with the goals (part step). PEERS.json adds lines
to it: a list of {"name", "voxels": [...], "ms": [...]}. Below each figure: command, commit, machine
and date."""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 760, 520
LEFT, RIGHT, TOP, BOTTOM = 70, 250, 40, 90
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
GOALS = {"beam": ("goal, C 10, nu 0.4", ((1e5, 1.5), (1e6, 6), (1e7, 50))),
         "c84": ("goal of c84", ((3.2e4, 2), (2.56e5, 5), (1e6, 12)))}


@dataclass
class Line:
    """Points of one name; a dashed line has been measured elsewhere or is a goal."""

    name: str
    points: list[tuple[float, float]] = field(default_factory=list)
    dashed: bool = False


@dataclass
class Axis:
    """A logarithmic axis over whole decades."""

    label: str
    low: int
    high: int
    begin: float  # [px]
    end: float

    @classmethod
    def over(cls, label: str, values: list[float], begin: float, end: float) -> Axis:
        low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
        return cls(label, low, max(high, low + 1), begin, end)

    def place(self, value: float) -> float:
        """Of a value [px]."""
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.begin + (self.end - self.begin) * (0.02 + 0.96 * share)


def text(x: float, y: float, words: str, anchor: str = "start", size: int = 12) -> str:
    """A text element."""
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}">'
            f"{escape(words)}</text>")


def grid(x: Axis, y: Axis) -> list[str]:
    """Lines of the decades with their numbers, and the labels."""
    parts = []
    for axis, other in ((x, y), (y, x)):
        for decade in range(axis.low, axis.high + 1):
            at, (a, b) = axis.place(10.0**decade), (other.begin, other.end)
            ends = (at, a, at, b) if axis is x else (a, at, b, at)
            parts.append('<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="#ddd"/>'
                         .format(*ends))
            number = f"1e{decade}" if not -1 <= decade <= 3 else f"{10.0**decade:g}"
            parts.append(text(at, y.begin + 16, number, "middle") if axis is x
                         else text(x.begin - 6, at + 4, number, "end"))
    middle = (y.begin + y.end) / 2
    parts.append(text((x.begin + x.end) / 2, y.begin + 36, x.label, "middle"))
    parts.append(f'<g transform="rotate(-90 18 {middle:.1f})">'
                 f'{text(18, middle, y.label, "middle")}</g>')
    return parts


def draw(line: Line, x: Axis, y: Axis, index: int) -> list[str]:
    """Markers, what joins them, and the name at the right."""
    colour = COLOURS[index % len(COLOURS)]
    places = [(x.place(a), y.place(b)) for a, b in line.points]
    dash = ' stroke-dasharray="6 4"' if line.dashed else ""
    joined = " ".join(f"{a:.1f},{b:.1f}" for a, b in places)
    parts = [f'<polyline points="{joined}" fill="none" stroke="{colour}" stroke-width="1.5"{dash}/>']
    parts += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3.5" '
              f'stroke="{colour}" fill="{"white" if line.dashed else colour}"/>' for a, b in places]
    row = TOP + 12 + 18 * index
    parts.append(f'<line x1="{x.end + 12}" y1="{row}" x2="{x.end + 34}" y2="{row}" '
                 f'stroke="{colour}" stroke-width="2"{dash}/>')
    parts.append(text(x.end + 40, row + 4, line.name, size=11))
    return parts


def figure(title: str, x_label: str, y_label: str, lines: list[Line], notes: list[str]) -> str:
    """A whole figure."""
    points = [point for line in lines for point in line.points]
    x = Axis.over(x_label, [a for a, _ in points], LEFT, WIDTH - RIGHT)
    y = Axis.over(y_label, [b for _, b in points], HEIGHT - BOTTOM, TOP)
    parts = [text(LEFT, 22, title, size=14), *grid(x, y)]
    for index, line in enumerate(lines):
        parts += draw(line, x, y, index)
    parts += [text(LEFT, HEIGHT - 34 + 14 * k, note, size=10) for k, note in enumerate(notes)]
    body = "\n".join(parts)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
            f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif">\n'
            f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>\n{body}\n</svg>\n')


def collect(named: list[tuple[str, float, float | None]]) -> list[Line]:
    """Lines of points that have their name; points at 0 or without a number are left out."""
    lines: dict[str, Line] = {}
    for name, a, b in named:
        if a and b and a > 0 and b > 0:
            lines.setdefault(name, Line(name)).points.append((a, b))
    return list(lines.values())


def error_figures(results: list[dict[str, Any]]) -> dict[str, list[Line]]:
    """Error over time of each scene, by the name of its figure."""
    named: dict[str, list[tuple[str, float, float | None]]] = {}

    def add(scene: dict[str, Any], name: str, row: dict[str, Any]) -> None:
        key = "{scene}_{voxels}_c{courant:g}_nu{poisson:g}".format(**scene)
        named.setdefault(key, []).append((name, row.get("ms", 0), row.get("error")))

    for result in results:
        for row in result.get("error-time", []):
            add(row, row["solver"], row)
        for case in result.get("baseline", []):
            for row in case["rows"][2 if "error-time" in result else 0:]:  # quasi, newton are there
                add(case, row["run"], row)
    return {key: collect(points) for key, points in named.items()}


def step_lines(results: list[dict[str, Any]], peers: list[dict[str, Any]]) -> list[Line]:
    """Time over voxels, goals of the scenes that are there, peers."""
    rows = [r for result in results for r in result.get("step", [])]
    lines = collect([(r["scene"] + ("" if r["scene"] == "c84" else
                                    f", C {r['courant']:g}, nu {r['poisson']:g}, fill {r['fill']:g}"),
                      r["voxels"], r["ms"]) for r in rows])
    for scene in dict.fromkeys(r["scene"] for r in rows):
        if scene in GOALS:
            lines.append(Line(GOALS[scene][0], list(GOALS[scene][1]), dashed=True))
    return lines + [Line(p["name"], list(zip(p["voxels"], p["ms"])), dashed=True) for p in peers]


def notes(results: list[dict[str, Any]], part: str) -> list[str]:
    """Where a figure comes from."""
    return [f"{r['command']}; {r['commit']}; {r['card'] or r['machine']['cpu']}; {r['date']}"
            for r in results if part in r][:3]


def main() -> int:
    """Writes the figures for which there is something."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("files", type=Path, nargs="+")
    options.add_argument("--out", type=Path, required=True)
    options.add_argument("--peers", type=Path)
    chosen = options.parse_args()
    results = [json.loads(path.read_text()) for path in chosen.files]
    peers = json.loads(chosen.peers.read_text()) if chosen.peers else []
    chosen.out.mkdir(parents=True, exist_ok=True)
    for key, lines in error_figures(results).items():
        if lines:
            (chosen.out / f"error_time_{key}.svg").write_text(figure(
                f"Error of a step over its time: {key.replace('_', ', ')}", "time of a step [ms]",
                "error", lines, notes(results, "error-time") or notes(results, "baseline")))
    if any(result.get("step") for result in results):
        (chosen.out / "step.svg").write_text(figure(
            "Time of a converged step", "voxels", "time of a step [ms]",
            step_lines(results, peers), notes(results, "step")))
    return 0


if __name__ == "__main__":
    sys.exit(main())
