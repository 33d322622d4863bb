#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Feeds the fuzz harnesses and judges them: a table of executions, coverage, crashes, slow inputs.

    cmake --preset fuzz && cmake --build --preset fuzz --target fuzz_all
    tests/fuzz/run.py [--seconds 60 | --smoke] [--jobs 2] [--json FILE] [HARNESS ...]

Inputs that were found stay in build/fuzz/corpus/HARNESS and begin the next run; those that crash
lie in build/fuzz/crashes/HARNESS. Small real files of the folder ELASTOGEN_ASSETS are seeds too.
Exit status 1 if a harness of ours crashed, ran out of time or out of memory; what the harnesses of
libraries that only run in elastogen-reader find is printed, not counted. --json keeps the results, each
with its seconds, commit and day, beside those of other harnesses that the file has already."""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from seeds import write_dictionary, write_seeds

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "scenes"))
from definitions import run_header  # noqa: E402

LIBRARIES = {"assimp", "vdb"}  # read foreign files in a process of their own
SLOW = 2  # seconds from which libFuzzer reports an input as slow
ENVIRONMENT = os.environ | {"ASAN_OPTIONS": "detect_leaks=0",
                            "UBSAN_OPTIONS": "print_stacktrace=1"}


@dataclass(frozen=True)
class Result:
    """What one harness came to; `crashes` are the files of its findings."""

    harness: str
    seeds: int
    executions: int
    edges: int
    crashes: list[Path]
    slow: int
    finished: bool
    reason: str

    @property
    def failed(self) -> bool:
        """Whether it stopped early for a reason that is ours."""
        return self.harness not in LIBRARIES and (bool(self.crashes) or not self.finished)


def last_number(pattern: str, text: str) -> int:
    """The last number that a pattern finds, 0 without one."""
    found = re.findall(pattern, text)
    return int(found[-1]) if found else 0


def reason_of(log: str) -> str:
    """The line that says why a harness ended."""
    for pattern in (r"property: .*", r"ERROR: \S+Sanitizer: .*", r"\S+: runtime error: .*",
                    r"ERROR: libFuzzer: .*", r"terminate called.*"):
        found = re.search(pattern, log)
        if found:
            return found[0][:150]
    return "" if "Done " in log else log.strip().rpartition("\n")[2][:150]


def command(binary: Path, seconds: int, crashes: Path, corpus: list[Path],
            dictionary: Path | None) -> list[str]:
    """libFuzzer's options."""
    return [str(binary), f"-max_total_time={seconds}", "-max_len=65536", "-rss_limit_mb=2048",
            "-timeout=10", f"-report_slow_units={SLOW}", "-print_final_stats=1", "-seed=1",
            "-use_value_profile=1", f"-artifact_prefix={crashes}/",
            *([f"-dict={dictionary}"] if dictionary else []), *map(str, corpus)]


def fuzz(binary: Path, seconds: int, assets: str | None) -> Result:
    """One run of one harness; of a library's it goes on behind a crash."""
    build, harness = binary.parent, binary.name.removeprefix("fuzz_")
    corpus, seeds = build / "corpus" / harness, build / "seeds" / harness
    crashes, words = build / "crashes" / harness, build / "seeds" / f"{harness}.dict"
    shutil.rmtree(crashes, ignore_errors=True)
    shutil.rmtree(seeds, ignore_errors=True)
    for folder in (corpus, crashes):
        folder.mkdir(parents=True, exist_ok=True)
    count = write_seeds(harness, seeds, assets)
    dictionary = words if write_dictionary(harness, words) else None
    words_of_run = command(binary, seconds, crashes, [corpus, seeds], dictionary)
    if harness in LIBRARIES:
        words_of_run[1:1] = ["-fork=1", "-ignore_crashes=1", "-ignore_timeouts=1",
                             "-ignore_ooms=1"]
    done = subprocess.run(words_of_run, capture_output=True, check=False, env=ENVIRONMENT,
                          text=True, errors="replace")
    log = done.stdout + done.stderr
    (build / f"{harness}.log").write_text(log)
    found = [f for f in sorted(crashes.iterdir()) if not f.name.startswith("slow-unit-")]
    executions = max(last_number(r"number_of_executed_units: (\d+)", log),
                     last_number(r"#(\d+)", log))
    return Result(harness, count, executions, last_number(r"cov: (\d+)", log), found,
                  log.count("Slowest unit"), done.returncode == 0, reason_of(log))


def keep(path: Path, results: list[Result], seconds: int) -> None:
    """Takes results into a file, in the place of older ones of the same harness."""
    rows = json.loads(path.read_text())["rows"] if path.exists() else {}
    header = run_header() | {"seconds": seconds}
    for r in results:
        rows[r.harness] = header | {"seeds": r.seeds, "executions": r.executions, "edges": r.edges,
                                    "crashes": len(r.crashes), "slow": r.slow,
                                    "finished": r.finished}
    path.write_text(json.dumps({"rows": dict(sorted(rows.items()))}, indent=1) + "\n")


def main() -> int:
    """Runs what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("harness", nargs="*", help="all that are built unless named")
    options.add_argument("--build", type=Path, default=ROOT / "build" / "fuzz")
    options.add_argument("--seconds", type=int, default=60, help="of each harness")
    options.add_argument("--smoke", action="store_true", help="2 seconds each")
    options.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options.add_argument("--json", type=Path, help="results, for the table of the documentation")
    chosen = options.parse_args()

    binaries = [f for f in sorted(chosen.build.glob("fuzz_*")) if os.access(f, os.X_OK)]
    names = [f.name.removeprefix("fuzz_") for f in binaries]
    unknown = set(chosen.harness) - set(names)
    if unknown or not binaries:
        print(f"no harness {', '.join(sorted(unknown))}; built are: {', '.join(names) or 'none'}",
              file=sys.stderr)
        return 2
    wanted = [b for b, n in zip(binaries, names) if not chosen.harness or n in chosen.harness]
    seconds = 2 if chosen.smoke else chosen.seconds
    assets = os.environ.get("ELASTOGEN_ASSETS")
    print("| harness | seeds | executions | edges | crashes | slow inputs |\n"
          "|---|---|---|---|---|---|")
    with ThreadPoolExecutor(chosen.jobs) as pool:
        results = list(pool.map(lambda b: fuzz(b, seconds, assets), wanted))
    for r in results:
        print(f"| {r.harness} | {r.seeds} | {r.executions} | {r.edges} | {len(r.crashes)} | "
              f"{r.slow} |")
    if chosen.json:
        keep(chosen.json, results, seconds)
    for r in results:
        if r.crashes or not r.finished:
            whose = "a library in elastogen-reader" if r.harness in LIBRARIES else "ours"
            print(f"{r.harness} ({whose}): {r.reason}", *(f"  {f}" for f in r.crashes[:5]),
                  sep="\n")
    return int(any(r.failed for r in results))


if __name__ == "__main__":
    sys.exit(main())
