# SPDX-License-Identifier: Apache-2.0
"""three.js in a headless Chromium: GLTFLoader and AnimationMixer on a page of a loopback server.

The word after the job names three.js: a module that exports THREE and GLTFLoader (nicegui's
`elements/scene/dist/index.js`), or a folder with `build/three.module.js` and `examples/jsm`.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from client_job import Answer, Job, load_job

FOLDER_MODULE = """import * as THREE from '/three/build/three.module.js';
import {GLTFLoader} from '/three/examples/jsm/loaders/GLTFLoader.js';
export {THREE, GLTFLoader};"""
SECONDS = 150
TYPES = {".html": "text/html", ".js": "text/javascript"}


class Page(ThreadingHTTPServer):
    """Serves the page and its files, collects what it posts."""

    def __init__(self, job: Job, library: Path) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.job, self.library = job, library
        self.answer, self.own, self.failure = Answer("?"), 0.0, ""
        self.done = threading.Event()

    def content(self, path: str) -> tuple[bytes, str]:
        """Bytes and media type of a path. @throws OSError where there is none."""
        if path == "/job":
            times = [self.job.seconds(frame) for frame in self.job.frames]
            return json.dumps({"frames": self.job.frames, "times": times}).encode(), "text/plain"
        if path == "/library.js" and self.library.is_dir():
            return FOLDER_MODULE.encode(), TYPES[".js"]
        files = {"/": Path(__file__).with_name("three_page.html"), "/asset.glb": Path(self.job.glb),
                 "/library.js": self.library}
        file = files.get(path)
        if file is None:
            if not path.startswith("/three/") or ".." in path:
                raise FileNotFoundError(path)
            file = self.library / path[len("/three/") :]
        return file.read_bytes(), TYPES.get(file.suffix, "application/octet-stream")

    def take(self, path: str, value: Any) -> None:
        """What the page posts."""
        if path == "/frame":
            for shown in value["objects"]:
                self.answer.show(value["frame"], shown["positions"])
                self.own = max(self.own, shown["own"])
            return
        if path == "/done":
            self.answer.version = value["version"]
            if self.own > 1e-6:
                self.answer.notes.append(f"getVertexPosition differs by {self.own:.1e}")
        else:
            self.failure = str(value)
        self.done.set()


class Handler(BaseHTTPRequestHandler):
    """Hands requests to the server."""

    server: Page

    def do_GET(self) -> None:
        """A file of the page."""
        try:
            body, kind = self.server.content(self.path)
        except OSError:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_POST(self) -> None:
        """A report of the page."""
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(204)
        self.end_headers()
        self.server.take(self.path, json.loads(body))

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing is logged."""


def main() -> None:
    """Serves the page, opens it, waits for its answer."""
    job, words = load_job()
    page = Page(job, Path(words[0]))
    threading.Thread(target=page.serve_forever, daemon=True).start()
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or "google-chrome"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
             "--no-first-run", f"--user-data-dir={profile}",
             f"http://127.0.0.1:{page.server_address[1]}/"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        finished = page.done.wait(SECONDS)
        process.terminate()
        process.wait(30)
    if page.failure or not finished:
        sys.exit(page.failure or f"no answer within {SECONDS} s")
    page.answer.save(job)


if __name__ == "__main__":
    main()
