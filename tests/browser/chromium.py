"""A headless Chromium driven through a pipe with its own debugging protocol; the standard library is enough."""

import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-dev-shm-usage", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--remote-debugging-pipe",
)  # fmt: skip


def find_chromium():
    """Path of an installed Chromium, or None."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Chromium:
    """One browser with one page; `events` is what the page reported: requests, console messages, exceptions."""

    def __init__(self, seconds=120.0):
        self._profile = tempfile.TemporaryDirectory(prefix="chromium-", ignore_cleanup_errors=True)
        self._seconds, self._number, self._unread, self.events = seconds, 0, b"", []
        # The browser reads commands from descriptor 3 and writes answers to descriptor 4.
        pairs = [os.pipe(), os.pipe()]
        theirs = [fcntl.fcntl(fd, fcntl.F_DUPFD, 10) for fd in (pairs[0][0], pairs[1][1])]
        os.close(pairs[0][0])
        os.close(pairs[1][1])
        self._write, self._read = pairs[0][1], pairs[1][0]
        self._process = subprocess.Popen(
            [find_chromium(), *OPTIONS, f"--user-data-dir={self._profile.name}"],
            preexec_fn=lambda: [os.dup2(fd, wanted) for fd, wanted in zip(theirs, (3, 4), strict=True)],  # noqa: PLW1509
            pass_fds=(3, 4),
            **dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL),
        )
        for fd in theirs:
            os.close(fd)
        self._session = None
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.send(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self._write)
        os.close(self._read)
        self._process.terminate()
        self._process.wait(timeout=30)
        self._profile.cleanup()

    def send(self, method, **parameters):
        """Send a command and wait for its result; what happens meanwhile goes to `events`."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        content = json.dumps(message).encode() + b"\0"
        while content:
            content = content[os.write(self._write, content) :]
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def _receive(self):
        deadline = time.monotonic() + self._seconds
        while b"\0" not in self._unread:
            ready, _, _ = select.select([self._read], [], [], max(deadline - time.monotonic(), 0.0))
            chunk = os.read(self._read, 1 << 20) if ready else b""
            if not chunk:
                raise RuntimeError("Chromium does not answer" if not ready else "Chromium has closed its pipe")
            self._unread += chunk
        message, _, self._unread = self._unread.partition(b"\0")
        return json.loads(message)

    def seen(self, method):
        """Parameters of every event of one kind."""
        return [event["params"] for event in self.events if event.get("method") == method]

    def open(self, path):
        """Open a file and wait until it is loaded."""
        loads = len(self.seen("Page.loadEventFired"))
        self.send("Page.navigate", url=Path(path).resolve().as_uri())
        while len(self.seen("Page.loadEventFired")) == loads:
            self.events.append(self._receive())

    def evaluate(self, expression):
        """Value of a JavaScript expression, or what its promise brings."""
        result = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(str(result["exceptionDetails"]))
        return result["result"].get("value")

    def resize(self, width, height=900):
        """Make the window this many CSS pixels wide and high."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def colours(self, scheme):
        """Prefer ``light`` or ``dark``."""
        self.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
