# SPDX-License-Identifier: Apache-2.0
"""The cases of stress.py: a scene file, the options that make it hard, and what it must show
besides the criteria of every run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import log10

import h5py
import numpy as np

from runs import Finished, Floats
from shapes_small import Mesh, boxes
from stress_checks import bits, equations, read_state

# another run of the same verb, by scene and options
Get = Callable[..., Finished]
Extra = Callable[[Finished, Get], Iterator[str]]
BOTH, NETWORK, ELEMENTS = ("animate", "simulate"), ("animate",), ("simulate",)
DONE, STOPPED = frozenset({0}), frozenset({0, 4, 5})


def nothing(_run: Finished, _get: Get) -> Iterator[str]:
    """No more than every run must meet."""
    yield from ()


@dataclass(frozen=True)
class Case:
    """A stress: `codes` are the exit codes that are right, `mesh` a shape written for it."""

    name: str
    scene: str
    options: tuple[str, ...] = ()
    verbs: tuple[str, ...] = BOTH
    codes: frozenset[int] = DONE
    short: bool = True
    passive: bool = True
    extra: Extra = nothing
    threads: tuple[int, ...] = (1,)  # besides 2
    mesh: Mesh | None = field(default=None, compare=False)


def last(run: Finished) -> Floats:
    """Displacements at the end [m], (nodes, 3)."""
    return run.u[-1]


def apart(a: Floats, b: Floats) -> float:
    """Largest difference over the largest value of b."""
    return float(np.abs(a - b).max() / np.abs(b).max())


def below(name: str, value: float, bound: float) -> Iterator[str]:
    """A fault if the value is not at most the bound."""
    if not value <= bound:
        yield f"{name} is {value:.3g}, at most {bound:.3g} is right"


def word(run: Finished, text: str) -> Iterator[str]:
    """A fault if neither the messages nor the report say it."""
    report = run.folder / "report.json"
    if text not in run.err + (report.read_text() if report.exists() else ""):
        yield f"nothing says '{text}'"


def gradients(run: Finished) -> Floats:
    """det F - 1 of every voxel at the end, by the referee's formulas."""
    with h5py.File(run.folder / "state.h5") as file:
        state = read_state(file)
        body = equations.make_body(state)
        F = equations.deformation_gradient(body.blocks[0], state.x[-1] - body.rest)
    return np.linalg.det(F) - 1


# --- materials


def nearly(run: Finished, _get: Get) -> Iterator[str]:
    """Drafts of stiff bodies: `simulate` asks for 1e-8 of the weight, below rounding there.

    The network's default promise is kept by all but the mixed ones, which say so.
    """
    if run.state["element"] == b"voxel" and len(run.state["materials"]) == 1:
        yield from below("worst residual", float(run.state["steps/residual"].max()), 1e-3)


def volume(nu: float) -> Extra:
    """Far from the clamp the volume grows by (1-2nu) rho g z/E; drafts above 0.499 may miss it."""
    def check(run: Finished, _get: Get) -> Iterator[str]:
        middle = run.rest[run.state["grid/corners"]].mean(1)[:, 1]
        free = middle < 0.8 - 5 * 0.05
        found = gradients(run)[free].sum()
        wanted = ((1 - 2 * nu) * 1000 * 9.81 * middle[free] / 4e6).sum()
        if not (run.code == 4 and nu > 0.499):
            yield from below("volume change over the analytic one", found / wanted, 1.5)
            yield from below("analytic volume change over that found", wanted / found, 1.5)
    return check


def pressed(options: tuple[str, ...]) -> Extra:
    """A heavy block let go presses the light one by at most twice the static amount, and rests."""
    def check(run: Finished, get: Get) -> Iterator[str]:
        still = get("heavy", (*options, "--fps", "0.1", "--frames", "10"))
        middle = np.isclose(run.rest[:, 1], 0.3)
        rest = -float(last(still)[middle, 1].mean())
        way = -run.u[:, middle, 1].mean(1)
        yield from below("depth over the static one", float(way.max()) / rest, 2.1)
        yield from below("distance from rest at the end", abs(float(way[-1]) / rest - 1), 0.02)
    return check


def materials() -> list[Case]:
    """Moduli, mixed moduli, Poisson's ratios, densities."""
    cases = []
    for k in range(3, 13):
        modulus = ("--young", f"1e{k}")
        cases.append(Case(f"modulus.1e{k}", "beam", modulus, NETWORK, short=k % 3 == 0))
        cases.append(Case(f"modulus.1e{k}", "beam", modulus, ELEMENTS, extra=nearly,
                          codes=STOPPED if k > 9 else DONE, short=k % 3 == 0))
    for inner, outer in (("1e3", "1e12"), ("1e12", "1e3")):
        region = f"x>50%: rubber,law=neo-hookean,young={outer},poisson=0.3,density=1000"
        cases.append(Case(f"mixed.{inner}.{outer}", "beam", ("--young", inner, "--region", region),
                          codes=STOPPED, extra=nearly))
    for nu in (0, 0.3, 0.45, 0.49, 0.499, 0.4999):
        cases.append(Case(f"poisson.{nu}", "hanging", ("--poisson", str(nu)), extra=volume(nu),
                          codes=STOPPED if nu > 0.499 else DONE, short=nu < 0.499))
    for heavy in ("1e3", "1e6"):
        options = ("--young", f"{1e4 * float(heavy):g}", "--region",
                   f"y>50%: rubber,law=neo-hookean,young={1e4 * float(heavy):g},poisson=0.3,"
                   f"density={heavy}")
        cases.append(Case(f"density.{heavy}", "heavy", options, extra=pressed(options)))
    return cases


# --- time and loads


def settled(run: Finished, get: Get) -> Iterator[str]:
    """After a second the same state as with dt = 1 s."""
    yield from below("distance from the state at rest", apart(last(run), last(get("post"))), 1e-3)


def flat(steps: int) -> Extra:
    """Memory a step, and drift of the second half."""
    def check(run: Finished, get: Get) -> Iterator[str]:
        brief = get("post", ("--fps", "60", "--frames", str(steps // 10)))
        yield from below("bytes a step", (run.peak - brief.peak) / (0.9 * steps), 1024)
        u = run.u
        yield from below("drift", apart(u[-1], u[len(u) // 2]), 1e-3)
        late = abs(run.state["steps/time"][-1] * 60 / steps - 1)
        yield from below("error of the time", late, 1e-12)
    return check


def sinks(g: float) -> Extra:
    """The top of a column goes down by rho g L^2/(2E) where strains are small."""
    def check(run: Finished, _get: Get) -> Iterator[str]:
        strain = 1000 * g * 0.6 / 1e7
        top = np.isclose(run.rest[:, 1], 0.6)
        found = -float(last(run)[top, 1].mean()) / (strain * 0.6 / 2)
        if strain < 0.1:
            yield from below("error of the shortening", abs(found - 1), 0.02 + strain)
    return check


def rests(run: Finished, _get: Get) -> Iterator[str]:
    """The state at rest keeps its bits."""
    if last(run).any():
        yield "the rest state moved"


def lands(run: Finished, _get: Get) -> Iterator[str]:
    """No point of the surface deeper in the floor than a quarter of a voxel."""
    s, h = run.state, float(run.state["h"])
    corners = s["grid/corners"][s["contact/voxel"]]
    place = s["contact/centre"][0, 1]
    lowest = min(float(np.einsum("pk,pk->p", s["contact/weights"], x[corners, 1]).min())
                 for x in s["steps/x"])
    yield from below("depth in the floor in voxels", (place - lowest) / h, 0.25)


def alike(run: Finished, get: Get) -> Iterator[str]:
    """The same motion in lengths of the body."""
    model = get("scale", ("--tolerance", str(float(run.state["tolerance"]))))
    yield from below("difference to the model", apart(
        last(run) / float(run.state["h"]), last(model) / float(model.state["h"])), 1e-6)


def loads() -> list[Case]:
    """Time steps, long runs, gravity, impacts, scales, a far place."""
    cases = []
    for k in range(13):
        dt = 10 ** (-k / 3)
        steps = max(10, round(1 / dt))
        options = ("--fps", repr(1 / dt if k else 1.0), "--frames", str(steps))
        cases.append(Case(f"dt.{dt:.2g}", "post", options, extra=settled, short=dt > 1e-2))
    for steps in (2000, 20000):
        cases.append(Case(f"long.{steps}", "post", ("--fps", "60", "--frames", str(steps)), NETWORK,
                          extra=flat(steps), short=steps < 5000))
    cases.append(Case("gravity.0", "beam", ("--gravity", "0,0,0", "--frames", "50"), extra=rests))
    for g in ("1e-6", "9.81"):
        tolerance = f"{1e-5 * max(1e-5, min(1.0, float(g))):g}"  # not below rounding
        cases.append(Case(f"gravity.{g}", "standing", ("--gravity", f"0,-{g},0", "--tolerance",
                                                       tolerance), extra=sinks(float(g))))
    cases.append(Case("gravity.1e4", "block", ("--gravity", "0,-1e4,0", "--pin", "y<0%"),
                      codes=STOPPED))
    cases.append(Case("gravity.sideways", "beam", ("--gravity", "0,0,9.81", "--frames", "40")))
    for speed in ("1", "10", "100", "1e3", "1e4"):
        cases.append(Case(f"impact.{speed}", "drop", ("--velocity", f"0,-{speed},0"), extra=lands,
                          codes=STOPPED, short=log10(float(speed)) < 3))
    for decade in range(-6, 7):
        s = 4.0 * 10.0**decade  # the beam is a quarter of a metre long
        options = ("--size", repr(0.25 * s), "--young", repr(1e5 * s), "--fps",
                   repr(60 / float(np.sqrt(s))))
        cases.append(Case(f"scale.1e{decade}", "scale", options, extra=alike,
                          short=decade % 3 == 0))
    return [*cases, Case("offset.1e6", "offset", extra=alike)]


# --- shapes and pins


def like_solo(run: Finished, get: Get) -> Iterator[str]:
    """Each piece of two voxels moves as one alone."""
    solo = get("shape", COLUMN, mesh=pieces(1))
    key = {tuple(place): n for n, place in enumerate(np.rint(solo.rest * 10).astype(int).tolist())}
    at = np.rint(run.rest * 10).astype(int)
    at[:, [0, 2]] %= 2
    mine = last(solo)[[key[tuple(place)] for place in at.tolist()]]
    # the residual is that of the whole: a piece may have all of it
    bound = 1e-6 * 9.81 * np.sqrt(8 * len(run.rest)) * 30**2 / 60**2
    yield from below("distance from the solo run [m]", float(np.abs(last(run) - mine).max()), bound)


def pieces(count: int) -> Mesh:
    """Columns of one by two by one voxels of 0.1 m, a voxel apart."""
    side = int(np.ceil(np.sqrt(count)))
    return boxes(*((np.array([0.2 * (p % side), 0, 0.2 * (p // side)]), np.array([0.1, 0.2, 0.1]))
                   for p in range(count)))


COLUMN = ("--pin", "y<0%", "--gravity", "4,-9.81,0", "--tolerance", "1e-6")


def falls(run: Finished, _get: Get) -> Iterator[str]:
    """All nodes by g t (t + dt)/2."""
    t = float(run.state["steps/time"][-1])
    depth = 9.81 * t * (t + 1 / 60) / 2
    error = np.abs(last(run) + [0, depth, 0]).max() / depth
    yield from below("error of the fall", float(error), 1e-10)


def says(text: str) -> Extra:
    """A word in the messages or the report."""
    return lambda run, _get: word(run, text)


def keeps_pins(run: Finished, _get: Get) -> Iterator[str]:
    """What is pinned stays to the bit."""
    if run.u[:, run.state["grid/pinned"] == 1].any():
        yield "a pinned node moved"


def carries(run: Finished, _get: Get) -> Iterator[str]:
    """At rest the pins carry the weight."""
    with h5py.File(run.folder / "state.h5") as file:
        state = read_state(file)
        body, x = equations.make_body(state), state.x[-1]
    force = equations.internal_energy(body, x, equations.rotations(body, x))[2][:, 1]
    weight = 9.81 * float(body.mass[body.free].sum())
    carried = float(force[~body.free].sum())
    yield from below("error of the reaction", abs(carried / weight - 1), 1e-3)


def shapes() -> list[Case]:
    """One voxel, loose ones, sheets, needles, hinges; ways to pin."""
    hinge = says("hinges")
    cases = [
        Case("shape.single", "shape", extra=falls),
        Case("shape.coarse", "shape", ("--h", "1"), codes=frozenset({2})),
        Case("shape.edge", "shape", ("edge.obj", *COLUMN), extra=hinge),
        Case("shape.corner", "shape", ("corner.obj", *COLUMN), extra=hinge),
        Case("shape.checkerboard", "shape", ("checkerboard.obj", *COLUMN), extra=hinge),
        Case("shape.flat", "shape", ("flat.obj",)),
        Case("shape.empty", "shape", codes=frozenset({3}), extra=says("in one point"),
             mesh=boxes((np.zeros(3), np.zeros(3)))),
        Case("shape.tiny", "shape", ("--size", "1e-310"), codes=frozenset({3})),
        Case("shape.aspect", "shape", ("--h", "1e-7"), codes=frozenset({6}))]
    for count in (2, 100, 1000):
        cases.append(Case(f"pieces.{count}", "shape", COLUMN, extra=like_solo, mesh=pieces(count),
                          verbs=BOTH if count < 1000 else NETWORK, short=count <= 100))
    for name, edges in (("sheet.60", (6, 0.1, 6)), ("needle.500", (50, 0.1, 0.1)),
                        ("sheet.300", (30, 0.1, 30)), ("needle.10000", (1000, 0.1, 0.1))):
        size = int(name.split(".")[1])
        cases.append(Case(name, "shape", ("--pin", "x<0%", "--young", "1e7", "--frames", "5"),
                          NETWORK, short=size in (60, 500),
                          mesh=boxes((np.zeros(3), np.array(edges)))))
    held = {"all": "all", "one": "box(0,100%,0, 0,100%,0)", "line": "box(0,100%,0, 100%,100%,0)",
            "plane": "x<0%"}
    cases += [Case(f"pins.{name}", "block", ("--pin", place), extra=keeps_pins)
              for name, place in held.items()]
    move = "y<0%: shift 0s:0,0,0; 500ms:"
    return [*cases,
            Case("pins.empty", "block", ("--pin", "y>50m"), extra=says("holds nothing")),
            Case("pins.reaction", "block", ("--pin", "y<0%", "--static"), ELEMENTS, extra=carries),
            Case("pins.contradictory", "block", ("--pin", "y<0%", "--move", move + "1,0,0"),
                 ELEMENTS, frozenset({2}), extra=says("contradict")),
            Case("pins.two.moves", "block", ("--move", move + "1,0,0", "--move", move + "0,1,0"),
                 ELEMENTS, frozenset({2}), extra=says("contradict")),
            Case("pins.fast", "block", ("--move", move + "60,0,0"), ELEMENTS, STOPPED,
                 passive=False)]


# --- solver and inputs


def all_threads(run: Finished, get: Get) -> Iterator[str]:
    """Seven and sixteen threads."""
    options = tuple(run.words[4:run.words.index("--threads")])
    for count in ("7", "16"):
        if bits(get("tumble", (*options, "--threads", count))) != bits(run):
            yield f"U7: other bits with {count} threads"


def starved(run: Finished, get: Get) -> Iterator[str]:
    """Fewer outer loops of the published algorithm: drafts, farther from its own fixed point."""
    paper = ("--solver", "paper", "--outer")
    best = last(get("scale", (*paper, "2000")))
    errors = [apart(last(get("scale", (*paper, count))), best)
              for count in ("1", "3", "5", "20", "50")]
    for a, b in zip(errors, errors[1:]):
        yield from below("error with more loops over that with fewer", b / a, 1)
    if run.state["steps/converged"].any():
        yield "a step of one loop is called converged"


def broken(run: Finished, _get: Get) -> Iterator[str]:
    """Nothing is left behind."""
    if any((run.folder / name).exists() for name in ("out.pc2", "state.h5", "report.json")):
        yield "refused, but files are there"


def inputs() -> list[Case]:
    """Numbers that are none, zero, below zero."""
    words = {"--young": "{}", "--density": "{}", "--fps": "{}", "--h": "{}", "--size": "{}",
             "--poisson": "{}", "--gravity": "0,{},0", "--velocity": "{},0,0",
             "--tolerance": "{}", "--substeps": "{}"}
    cases = []
    for option, text in words.items():
        values = ["nan", "inf"]
        if option not in ("--gravity", "--velocity"):
            values += ["-1"] if option == "--poisson" else ["0", "-1"]
        for value in values + (["0.5", "0.7"] if option == "--poisson" else []):
            cases.append(Case(f"input{option[1:]}.{value}", "beam", (option, text.format(value)),
                              codes=frozenset({2}), extra=broken, short=value in ("nan", "0.5")))
    for name, value in (("nan", np.nan), ("inf", np.inf)):
        vertices, faces = boxes((np.zeros(3), np.full(3, 0.1)))
        vertices[3, 1] = value
        cases.append(Case(f"input.vertex.{name}", "shape", mesh=(vertices, faces),
                          codes=frozenset({3}), extra=broken))
    return cases


def steps_by_time_error() -> list[Case]:
    """Scenes at the scheme that is the default."""
    # an impact may take more steps than there are
    auto = ("--time-scheme", "auto", "--substeps", "auto", "--no-strict-time")
    drops = {"soft": ("--young", "1e3"), "fast": ("--velocity", "0,-50,0")}
    return [*(Case(f"auto.{scene}", scene, auto) for scene in ("beam", "drop", "offset", "heavy")),
            *(Case(f"auto.{name}", "drop", (*auto, *options)) for name, options in drops.items()),
            Case("auto.stiff", "drop", (*auto, "--young", "1e9"), NETWORK),
            Case("auto.tumble", "tumble", auto, NETWORK)]


def solvers() -> list[Case]:
    """Threads, starvation, sizes."""
    cases = [Case(f"threads.{mode}", "tumble", ("--solver", mode), NETWORK, extra=all_threads)
             for mode in ("quasi", "newton")]
    cases.append(Case("threads.fem", "tumble", ("--voxels", "6"), ELEMENTS, extra=all_threads))
    cases.append(Case("starved.paper", "scale", ("--solver", "paper", "--outer", "1"), NETWORK,
                      frozenset({4}), passive=False, extra=starved))
    for side in (22, 46):
        cases.append(Case(f"size.{side**3}", "tumble", ("--voxels", str(side)), NETWORK,
                          extra=lands, short=False))
    return cases


CASES = [*materials(), *loads(), *shapes(), *inputs(), *solvers(), *steps_by_time_error()]
