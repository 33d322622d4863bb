# SPDX-License-Identifier: Apache-2.0
"""Broken scene files. They are wrong usage: exit code 2."""

from __future__ import annotations

import json
from collections.abc import Iterator

from command import write_obj
from corpus import Case, cuts, written
from corpus_mesh import FACES, POSITION

DEEP = 100_000
TOML = (b"pins = [\"y<5%\"]\n[asset]\nfile = \"box.obj\"\n[material]\nyoung = \"2 MPa\"\n"
        b"[[collider]]\nshape = \"sphere\"\ncentre = [0, \"30 cm\", 0]\nradius = 0.05\n"
        b"[time]\nframes = 1\n")
JSON = json.dumps({
    "pins": ["y<5%"], "asset": {"file": "box.obj"}, "material": {"young": "2 MPa"},
    "time": {"frames": 1}}, indent=1).encode()
ENDLESS = ["inf", "-inf", "nan"]


def scene_cases() -> Iterator[Case]:
    box = {"box.obj": written(write_obj, "a.obj", POSITION, FACES)}
    for ending, whole in (("toml", TOML), ("json", JSON)):
        for case in cuts("whole", ending, whole, codes=(2,)):
            # a shorter scene can be whole: it lacks its asset then, or has one that is not there
            yield Case(case.name, case.content, "", (2, 3))
        for old, new, words in (
                (b"frames", b"farmes", "farmes"),
                (b"2 MPa", b"2 MPaa", "young"), (b"2 MPa", b"-2 MPa", "young"),
                (b"2 MPa", b"nan Pa", "young"), (b"box.obj", b"box\\u0000.obj", "")):
            yield Case(f"{new[:6].decode().strip()}.{ending}".replace("\\", "_"),
                       whole.replace(old, new), words, (2, 3), beside=box)
        yield Case(f"binary.{ending}", whole + bytes(50), "", (2,), beside=box)
        yield Case(f"line.{ending}", b"", "100", (2,), b"0.25 ")
    for number in ("2147483648", "9223372036854775808", "-1", "1e999", "0.5", "[]"):
        for ending, text in (("toml", f"[time]\nframes = {number}\n"),
                             ("json", f'{{"time": {{"frames": {number}}}}}')):
            name = "".join(c for c in number if c.isalnum())
            yield Case(f"frames_{name}_{ending}.{ending}", text.encode(), "", (2,))
    for number in ENDLESS:
        yield Case(f"{number}.toml", f"[collider]\nradius = {number}\n".encode(), "", (2,))
    yield Case("twice.json", b'{"pins": [], "pins": []}', "twice", (2,))
    yield Case("twice.toml", b"pins = []\npins = []\n", "pins", (2,))
    for name, text in (("lists.toml", b"pins = " + b"[" * DEEP),
                       ("tables.toml", b"pins = " + b"{a=" * DEEP),
                       ("dots.toml", b"[" + b"a." * DEEP + b"a]\n"),
                       ("lists.json", b'{"pins": ' + b"[" * DEEP),
                       ("tables.json", b'{"pins": ' + b'{"a": ' * DEEP)):
        yield Case(name, text, "64 levels", (2,))
    million = 1 << 20
    yield Case("long.toml", b"pins = [" + b"1," * million + b"]\n", "write", (2,))
    yield Case("wide.toml", b"pins = [" + b"1," * 5000 + b"]\n", "2048", (2,))
    yield Case("keys.toml", b"".join(b"k%d = 1\n" % k for k in range(90_000)), "unknown", (2,))
    yield Case("numbers.json", b'{"pins": [' + b"1," * 7_000_000 + b"1]}", "pins", (2,))
