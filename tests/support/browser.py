"""A page in Chromium without a window, through the pipes of its DevTools protocol."""

from __future__ import annotations

import base64
import io
import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Timer
from typing import Any

import numpy as np
from PIL import Image

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
"""Where Debian's Chromium is; None if it is not installed."""
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--no-first-run",
    "--window-size=1000,800",
    "--remote-debugging-pipe",
)
PATIENCE = 120.0
"""Seconds after which a browser is ended in any case."""


class Page:
    """The page of a browser; `complaints` are its errors and warnings so far.

    `requests` are the addresses of all that it has asked for, but for those that begin with data.
    """

    def __init__(self, to: int, answers: int) -> None:
        self._to, self._answers = to, os.fdopen(answers, "rb")
        self._last, self._loads, self._session = 0, 0, ""
        self.complaints: list[str] = []
        self.requests: list[str] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **arguments: Any) -> dict[str, Any]:
        """Result of a method of the protocol; what the page says meanwhile is noted."""
        self._last += 1
        message: dict[str, Any] = {"id": self._last, "method": method, "params": arguments}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while (answer := self._next()).get("id") != self._last:
            self._note(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def _next(self) -> dict[str, Any]:
        found = bytearray()
        while (byte := self._answers.read(1)) != b"\0":
            if not byte:
                raise RuntimeError("the browser has ended")
            found += byte
        return json.loads(found)

    def _note(self, event: dict[str, Any]) -> None:
        told = event.get("params", {})
        match event.get("method"):
            case "Page.loadEventFired":
                self._loads += 1
            case "Network.requestWillBeSent" if not told["request"]["url"].startswith("data:"):
                self.requests.append(told["request"]["url"])
            case "Runtime.exceptionThrown":
                self.complaints.append(str(told["exceptionDetails"]))
            case "Runtime.consoleAPICalled" if told["type"] in ("error", "warning"):
                self.complaints.append(str(told["args"]))
            case "Log.entryAdded" if told["entry"]["level"] in ("error", "warning"):
                self.complaints.append(told["entry"]["text"])

    def value(self, expression: str) -> Any:
        """The value of JavaScript, once its promises are kept."""
        found = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in found:
            raise RuntimeError(str(found["exceptionDetails"]))
        return found["result"].get("value")

    def open(self, path: Path) -> None:
        """Show a file, and wait until it is there."""
        before = self._loads
        self.call("Page.navigate", url=path.absolute().as_uri())
        while self._loads == before:
            self._note(self._next())

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """An event of the mouse at a place of the window [px]: mousePressed, mouseMoved, …"""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """From one place of the window to another [px] with the left button, in ten moves."""
        self.mouse("mousePressed", *start, button="left", buttons=1, clickCount=1)
        for k in range(1, 11):
            x, y = (a + (b - a) * k / 10 for a, b in zip(start, end, strict=True))
            self.mouse("mouseMoved", x, y, button="left", buttons=1)
        self.mouse("mouseReleased", *end, button="left", clickCount=1)

    def press(self, key: str, code: str = "", **more: Any) -> None:
        """A key of the keyboard, pressed and released."""
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            given = {**more, **(text if kind == "keyDown" else {})}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, **given)

    def choose(self, selector: str, value: object) -> None:
        """Choose a value of a control as a reader does."""
        self.value(
            f"{{ const part = document.querySelector('{selector}'); part.value = '{value}';"
            "const typed = ['range', 'search'].includes(part.type) ? 'input' : 'change';"
            "part.dispatchEvent(new Event(typed)); }"
        )

    def nameless(self) -> list[str]:
        """Controls that are seen and have no name for those who cannot see them."""
        return self.value(
            "[...document.querySelectorAll('button, select, input, [tabindex=\"0\"]')].filter(e =>"
            "!e.closest('[hidden]') && !(e.textContent.trim() || e.getAttribute('aria-label') ||"
            "e.labels?.[0]?.textContent.trim())).map(e => e.outerHTML)"
        )

    @contextmanager
    def emulated(self, *, width: int = 0, scheme: str = "", mobile: bool = False) -> Iterator[None]:
        """Within it the window is `width` × 800 px, the system's colours are light or dark."""
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": mobile}
        features = [{"name": "prefers-color-scheme", "value": scheme}] if scheme else []
        self.call("Emulation.setEmulatedMedia", features=features)
        if width:
            self.call("Emulation.setDeviceMetricsOverride", **size)
        try:
            yield
        finally:
            self.call("Emulation.clearDeviceMetricsOverride")
            self.call("Emulation.setEmulatedMedia", features=[])

    def picture(self) -> np.ndarray:
        """What is seen, (height, width, 3) bytes [1]."""
        shot = self.call("Page.captureScreenshot", format="png")
        with Image.open(io.BytesIO(base64.b64decode(shot["data"]))) as image:
            return np.asarray(image.convert("RGB"), dtype=int)

    def seen(self, selector: str) -> np.ndarray:
        """What is seen of an element within its edge, (height, width, 3) bytes [1]."""
        x, y, width, height = (
            round(
                self.value(f"document.querySelector('{selector}').getBoundingClientRect().{side}")
            )
            for side in ("x", "y", "width", "height")
        )
        return self.picture()[max(y, 0) + 2 : y + height - 2, x + 2 : x + width - 2]


@contextmanager
def browser(folder: Path) -> Iterator[Page]:
    """A page of a browser that keeps its files in `folder`; it ends afterwards."""
    import fcntl  # which Windows has not

    ours, its_answers = os.pipe()
    its_calls, to = os.pipe()

    def pipes() -> None:
        answers = fcntl.fcntl(its_answers, fcntl.F_DUPFD, 10)  # which may be 3 itself
        os.dup2(its_calls, 3)
        os.dup2(answers, 4)

    process = subprocess.Popen(
        [str(CHROMIUM), *FLAGS, f"--user-data-dir={folder}"],
        preexec_fn=pipes, pass_fds=(3, 4), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(its_calls)
    os.close(its_answers)
    watch = Timer(PATIENCE, process.kill)
    watch.start()
    try:
        yield Page(to, ours)
    finally:
        watch.cancel()
        os.close(to)
        process.terminate()
        process.wait(timeout=20)
