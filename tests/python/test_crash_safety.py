# SPDX-License-Identifier: Apache-2.0
"""Outputs of runs that are killed, and of disks that are full.

A run killed at any time leaves the old file of each output or the whole new one, and nothing else
in the folder but the log, whose lines are whole but for the last, which has no line break where a kill
cut it; killed between two system calls, both files, the new one under its temporary name.
"""
import json
import os
import random
import re
import resource
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import h5py

import command
import glb_check
import state_file
from glb_file import read_document

KILLS = int(os.environ.get("ELASTOGEN_KILLS", "100"))
OLD = b"what was here before"
BEAM = command.turned_box([1, 0.25, 0.25], [0, 0, 1], 0)


def arguments(folder: Path) -> list[str]:
    """A short run with every output."""
    asset = command.write_obj(folder / "beam.obj", *BEAM)
    out = folder / "out"
    out.mkdir(exist_ok=True)
    return [command.BINARY, "animate", str(asset), "--voxels", "12", "--frames", "12",
            "--pin", "x<5%", "--young", "200kPa", "--quiet",
            "-o", str(out / "a.glb"), "-o", str(out / "a.pc2"), "--state", str(out / "a.h5"),
            "--report", str(out / "a.json"), "--log-json", str(out / "a.log")]


class Killed(unittest.TestCase):
    def check_whole(self, path: Path, name: str) -> None:
        """The file is a whole one of the output of that name."""
        content = path.read_bytes()
        if name == "a.glb":
            glb_check.check_animation(read_document(path))
        elif name == "a.json":
            self.assertIn("steps", json.loads(content))
        elif name == "a.h5":
            with h5py.File(path, "r") as file:
                self.assertGreater(len(state_file.read_state(file).steps["time"]), 1)
        else:
            self.assertEqual(content[:12], b"POINTCACHE2\0")
            points, samples = (int.from_bytes(content[k:k + 4], "little") for k in (16, 28))
            self.assertEqual(len(content), 32 + 12 * points * samples)

    def check(self, folder: Path, whole: dict[str, int], killed: bool) -> None:
        """Each file is old or whole; counts the whole ones. Files get a name when they are whole: a
        temporary one for the moment before the old file is replaced, in which a kill can fall."""
        out = folder / "out"
        for path in out.iterdir():
            name = re.sub(r"\.tmp\d+-\d+$", "", path.name)
            self.assertIn(name, {*whole, "a.log"})
            if name == "a.log" or path.read_bytes() == OLD:
                continue
            self.check_whole(path, name)
            whole[name] += path.name == name
        log = out / "a.log"
        if log.exists():
            *lines, cut = log.read_text().split("\n")
            for line in lines:
                json.loads(line)
            # the kernel may end a write at a page of the file when a signal kills the process
            self.assertTrue(cut == "" or (killed and '{"'.startswith(cut[:2])))

    def test_leaves_old_files_or_whole_ones(self) -> None:
        rng = random.Random(7)
        whole = dict.fromkeys(("a.glb", "a.pc2", "a.h5", "a.json"), 0)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            run = arguments(folder)
            begin = time.monotonic()
            self.assertEqual(subprocess.run(run, timeout=120, check=False).returncode, 0)
            seconds = time.monotonic() - begin
            for _ in range(KILLS):
                for file in (folder / "out").iterdir():
                    file.unlink()
                for file in whole:
                    (folder / "out" / file).write_bytes(OLD)
                with subprocess.Popen(run) as process:
                    try:
                        process.wait(rng.uniform(0, 1.1 * seconds))
                    except subprocess.TimeoutExpired:
                        process.send_signal(signal.SIGKILL)
                self.check(folder, whole, killed=True)
        # the kills came early and late
        self.assertGreater(sum(whole.values()), 0)
        self.assertLess(sum(whole.values()), 4 * KILLS)

    def test_a_signal_ends_with_its_code_and_whole_files(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                run = arguments(folder)
                run[run.index("--frames") + 1] = "100000"
                with subprocess.Popen(run) as process:
                    time.sleep(1)
                    process.send_signal(number)
                    self.assertEqual(process.wait(20), 128 + number)
                self.check(folder, dict.fromkeys(("a.glb", "a.pc2", "a.h5", "a.json"), 0),
                           killed=False)
                self.assertEqual(json.loads((folder / "out/a.json").read_text())["warnings"][-1],
                                 "interrupted")


class FullDisk(unittest.TestCase):
    def run_limited(self, out: Path, before) -> subprocess.CompletedProcess:
        asset = command.write_obj(out.parent / "beam.obj", *BEAM)
        return subprocess.run(
            [command.BINARY, "animate", str(asset), "--voxels", "16", "--frames", "60", "--quiet",
             "--pin", "x<5%", "-o", str(out / "a.glb"), "--state", str(out / "a.h5")],
            timeout=120, capture_output=True, text=True, check=False, preexec_fn=before)

    def test_a_limit_on_file_size_ends_with_code_6(self) -> None:
        def limit() -> None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

        with tempfile.TemporaryDirectory() as name:
            out = Path(name) / "out"
            out.mkdir()
            (out / "a.glb").write_bytes(OLD)
            result = self.run_limited(out, limit)
            self.assertEqual(result.returncode, 6, result.stderr)
            self.assertIn("a.h5", result.stderr)
            self.assertEqual((out / "a.glb").read_bytes(), OLD)
            self.assertEqual(list(out.iterdir()), [out / "a.glb"])

    def test_frames_beyond_the_limit_end_with_code_6(self) -> None:
        """Frames wait in a file of their own, which the thread that writes them fills."""
        def limit() -> None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, 5_000))

        for threads in ("1", "2"):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                out = folder / "out"
                out.mkdir()
                asset = command.write_obj(folder / "beam.obj", *BEAM)
                result = subprocess.run(
                    [command.BINARY, "animate", str(asset), "--voxels", "8", "--frames", "200",
                     "--quiet", "--analytic", "--device", "cpu", "--threads", threads,
                     "--pin", "x<5%", "-o", str(out / "a.pc2")],
                    timeout=120, capture_output=True, text=True, check=False, preexec_fn=limit)
                self.assertEqual(result.returncode, 6, result.stderr)
                self.assertIn("a.pc2", result.stderr)
                self.assertEqual(list(out.iterdir()), [])

    def test_a_small_disk_ends_with_code_6(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            out = Path(name) / "disk"
            out.mkdir()
            mount = ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(out)]
            if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
                self.skipTest("may not mount a tmpfs")
            try:
                result = self.run_limited(out, None)
                self.assertEqual(result.returncode, 6, result.stderr)
                self.assertIn("No space left", result.stderr)
                self.assertEqual(list(out.iterdir()), [])
            finally:
                subprocess.run(["umount", str(out)], check=True)


if __name__ == "__main__":
    unittest.main()
