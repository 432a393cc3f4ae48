"""A headless Chromium that does what a user does: looks at a page and clicks.

It is spoken to by Chrome's DevTools protocol over a pipe: JSON messages that end in a zero byte.
"""

import contextlib
import itertools
import json
import os
import select
import subprocess
import tempfile
import time

from vh_drake.experiments.browser import FLAGS, find_browser

_FIND = """(() => {
  const rows = [...document.querySelectorAll('*')].filter(
    e => e.children.length == 0 && e.textContent.trim() == LABEL);
  if (!rows.length) return null;
  rows[0].scrollIntoView({block: 'center'});
  const box = rows[0].getBoundingClientRect();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const hit = document.elementFromPoint(x, y);
  return hit && (rows[0].closest("li") || rows[0]).contains(hit) ? [x, y] : null;
})()"""


class Browser:
    """One page in one browser; a context manager.

    Args:
        url: of the page.
        size: of the window in pixels.
    """

    def __init__(self, url: str, size: tuple[int, int] = (700, 1000)) -> None:
        self._ids = itertools.count(1)
        self._buffer = b""
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        read, self._out = os.pipe()
        self._in, write = os.pipe()
        # Chromium reads from file 3 and writes to file 4, which a shell puts in their place.
        self._process = subprocess.Popen(
            [
                "bash",
                "-c",
                f'exec "$@" 3<&{read} 4>&{write}',
                "bash",
                find_browser(),
                *FLAGS,
                "--remote-debugging-pipe",
                f"--user-data-dir={self._profile.name}",
                f"--window-size={size[0]},{size[1]}",
                "about:blank",
            ],
            pass_fds=(read, write),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(read)
        os.close(write)
        target = self._call("Target.createTarget", url=url)["targetId"]
        attached = self._call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):
            os.write(self._out, json.dumps({"id": 0, "method": "Browser.close"}).encode() + b"\0")
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._out)
        os.close(self._in)
        self._profile.cleanup()

    def click(self, label: str, limit_s: float = 60.0) -> None:
        """Clicks with the mouse on what bears a text, once it is there."""
        x, y = self._wait_for(label, limit_s)
        for kind in ("mousePressed", "mouseReleased"):
            self._page("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def press(self, key: str, code: str) -> None:
        """Presses a key and lets it go."""
        for kind in ("keyDown", "keyUp"):
            self._page("Input.dispatchKeyEvent", type=kind, key=key, code=code)

    def evaluate(self, script: str) -> object:
        """What JavaScript gives on the page."""
        told = self._page("Runtime.evaluate", expression=script, returnByValue=True)
        return told["result"].get("value")

    def _wait_for(self, label: str, limit_s: float) -> tuple[float, float]:
        end, before = time.monotonic() + limit_s, None
        while time.monotonic() < end:
            place = self.evaluate(_FIND.replace("LABEL", json.dumps(label)))
            if place and place == before:  # A page that is still being built moves what it has.
                return tuple(place)
            before = place
            time.sleep(0.1)
        raise TimeoutError(f"no {label!r} on the page within {limit_s:g} s")

    def _page(self, method: str, **params: object) -> dict:
        return self._call(method, sessionId=self._session, **params)

    def _call(self, method: str, sessionId: str | None = None, **params: object) -> dict:
        number = next(self._ids)
        message = {"id": number, "method": method, "params": params}
        if sessionId:
            message["sessionId"] = sessionId
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def _receive(self, limit_s: float = 60.0) -> dict:
        while b"\0" not in self._buffer:
            if not select.select([self._in], [], [], limit_s)[0]:
                raise TimeoutError("the browser does not answer")
            data = os.read(self._in, 65536)
            if not data:
                raise RuntimeError("the browser has ended")
            self._buffer += data
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)
