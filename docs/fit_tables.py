# SPDX-License-Identifier: Apache-2.0
"""Tables of nets: fits, read from the model cards of network/weights (docs/formats.md, weights), and
how soon fits of new materials pass, read from docs/results/generation.json (bench_generation) and
fine_tuning.json (bench_fine_tuning)."""

from __future__ import annotations

import hashlib
import json
import struct
from pathlib import Path

WEIGHTS = Path(__file__).resolve().parents[1] / "network" / "weights"
RESULTS = Path(__file__).resolve().parent / "results"


def model_card(path: Path) -> dict[str, str]:
    """The texts of a file of tensors, whose seal is checked."""
    data = path.read_bytes()
    if data[:16] != b"elastogen-tensor" or hashlib.sha256(data[:-32]).digest() != data[-32:]:
        raise SystemExit(f"{path}: not a file of tensors, or changed")
    at, card = 24, {}

    def text() -> str:
        nonlocal at
        size = struct.unpack_from("<I", data, at)[0]
        at += 4 + size
        return data[at - size:at].decode()

    for _ in range(struct.unpack_from("<I", data, 20)[0]):
        name = text()
        card[name] = text()
    return card


def fits() -> tuple[list[str], list[list[str]]]:
    """Head and rows: a law and Poisson ratio each, errors in per cent."""
    cards = [model_card(path) for path in WEIGHTS.glob("*.weights")]
    cards.sort(key=lambda card: (card["law"], float(card["poisson"])))
    errors = ("stress.median", "stress.p99", "stress.max", "tangent.p99")
    rows = [[card["law"], card["poisson"],
             *(f"{100 * float(card['error.' + name]):.3f}" for name in errors)] for card in cards]
    return ["law", "nu", "stress, median [%]", "p99 [%]", "largest [%]", "tangent, p99 [%]"], rows


def generation() -> tuple[list[str], list[list[str]]]:
    """Head and rows: materials by Poisson ratio, and where their fits begin."""
    result = json.loads((RESULTS / "generation.json").read_text())
    rows = []
    for group in result["groups"]:
        if not group["group"].startswith("nu"):
            continue
        for start in group["starts"]:
            never = start["never"]  # their numbers, in older files how many
            rows.append([f"{group['group']} ({group['materials']})", start["start"],
                         *(f"{100 * stage['inside']:.1f}" for stage in start["stages"]),
                         f"{start['passes_after_ms']:.0f}",
                         str(len(never) if isinstance(never, list) else never)])
    iterations = [str(stage["iterations"]) for stage in result["groups"][0]["starts"][0]["stages"]]
    return ["materials", "begins at", *(f"{n} [%]" for n in iterations), "passes after [ms]",
            "never"], rows


def fine_tuning() -> tuple[list[str], list[list[str]]]:
    """Head and rows: where gradient steps begin, and shares inside all limits after them."""
    result = json.loads((RESULTS / "fine_tuning.json").read_text())
    starts = list(dict.fromkeys(row["start"] for row in result["rows"]))
    rows = []
    for start in starts:
        of_start = [row for row in result["rows"] if row["start"] == start]
        rows.append([start, *(f"{100 * row['inside_to_048']:.1f}" for row in of_start),
                     f"{100 * of_start[-1]['inside']:.1f}",
                     f"{100 * of_start[-1]['median']:.2g}", f"{of_start[-1]['seconds']:.1f}"])
    steps = list(dict.fromkeys(str(row["steps"]) for row in result["rows"]))
    return ["begins at", *(f"{n} [%]" for n in steps), "at any nu [%]",
            "stress, median of the median net [%]", f"all {result['materials']} nets [s]"], rows
