"""Chromium without a window, driven by its own protocol over a pipe, with the network refused."""

from __future__ import annotations

import base64
import io
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome")
PROGRAM = next((path for path in map(shutil.which, NAMES) if path), None)
OPTIONS = (
    *("--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--no-first-run"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--disable-default-apps", "--hide-scrollbars", "--force-device-scale-factor=1"),
    # Whatever a page may ask for, there is no such proxy.
    "--proxy-server=127.0.0.1:9",
    "--proxy-bypass-list=<-loopback>",
    "--disable-dev-shm-usage",
)
KEYS = {"ArrowRight": 39, "ArrowLeft": 37, "Home": 36, "End": 35, " ": 32, ",": 188, ".": 190}


class Browser:
    """A browser with one page."""

    def __init__(self, width=1280, height=720):
        # The browser's own processes may still write there while it is removed.
        self.folder = tempfile.TemporaryDirectory(
            prefix="contensou-browser-", ignore_cleanup_errors=True
        )
        there, to_browser = os.pipe()
        from_browser, back = os.pipe()

        def connect():
            low, high = os.dup(there), os.dup(back)
            os.dup2(low, 3)
            os.dup2(high, 4)

        self.process = subprocess.Popen(
            [PROGRAM, *OPTIONS, f"--user-data-dir={self.folder.name}", "about:blank"],
            pass_fds=(3, 4, there, back),
            preexec_fn=connect,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            close_fds=True,
        )
        os.close(there)
        os.close(back)
        self.out, self.into = to_browser, from_browser
        self.buffer = b""
        self.number = 0
        self.session = None
        self.complaints: list[str] = []
        self.asked: list[str] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.resize(width, height)

    def resize(self, width, height, touch=False):
        """The size of the page in pixels."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)

    def call(self, method, **parameters):
        """Send a command; its result."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive(120)
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            self.take_note(answer)

    def receive(self, patience):
        """The next message."""
        while b"\0" not in self.buffer:
            ready, _, _ = select.select([self.into], [], [], patience)
            assert ready, "the browser says nothing"
            data = os.read(self.into, 1 << 20)
            assert data, "the browser has ended"
            self.buffer += data
        words, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(words)

    def take_note(self, message):
        """Keep complaints of a page and what it asks for."""
        method, what = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = what["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning"):
            self.complaints.append(str([word.get("value") for word in what["args"]]))
        elif method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            text = what["entry"]["text"]
            # Reading the picture back is the test's doing.
            if "ReadPixels" not in text:
                self.complaints.append(text)
        elif method == "Network.requestWillBeSent":
            self.asked.append(what["request"]["url"])

    def open(self, path, ready="window.contensou && contensou.drawn.frames > 0"):
        """Open a page of this machine and wait until it is ready."""
        self.complaints.clear()
        self.asked.clear()
        self.call("Page.navigate", url=path.as_uri())
        self.wait(ready)

    def wait(self, condition, patience=120):
        """Wait until an expression is true."""
        end = time.monotonic() + patience
        while not self.value(f"Boolean({condition})"):
            assert time.monotonic() < end, f"{condition}: {self.complaints}"
            time.sleep(0.02)

    def value(self, expression):
        """The value of an expression in the page."""
        done = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in done, done["exceptionDetails"]
        return done["result"].get("value")

    def key(self, key):
        """Press a key."""
        code = KEYS.get(key, ord(key[0].upper()))
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            self.call(
                "Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, **text
            )

    def click(self, selector):
        """Click in the middle of an element."""
        self.value(f"document.querySelector({selector!r}).scrollIntoView({{block: 'nearest'}})")
        x, y, w, h = self.value(
            f"(r => [r.x, r.y, r.width, r.height])(document.querySelector({selector!r})"
            ".getBoundingClientRect())"
        )
        self.drag((x + w / 2, y + h / 2), (x + w / 2, y + h / 2))

    def drag(self, start, end):
        """Press the mouse button, move, let it go."""
        for kind, (x, y) in (
            ("mousePressed", start),
            ("mouseMoved", end),
            ("mouseReleased", end),
        ):
            self.call(
                "Input.dispatchMouseEvent",
                type=kind,
                x=x,
                y=y,
                button="left",
                buttons=0 if kind == "mouseReleased" else 1,
                clickCount=1,
            )

    def touch(self, *places):
        """A step of a touch: the fingers that are down, none at the end."""
        kind = "touchEnd" if not places else "touchMove" if self.touched else "touchStart"
        self.touched = bool(places)
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    touched = False

    def draw(self):
        """Let the page draw what has changed."""
        self.value("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")

    def picture(self, path=None):
        """The page as an array of pixels (rows, columns, red green blue)."""
        self.draw()
        self.wait("!window.contensou || contensou.state.playing || contensou.settled()")
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if path:
            path.write_bytes(data)
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)

    def close(self):
        """End the browser."""
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.out)
        os.close(self.into)
        for _ in range(20):
            self.folder.cleanup()
            if not Path(self.folder.name).exists():
                break
            time.sleep(0.1)


def show(window: Browser, page: Path, camera: str, nearer: float) -> None:
    """Open the page of a run, nothing but its bodies in it."""
    window.open(page)
    window.value(
        "(() => { for (const tag of ['header', 'aside', 'footer'])"
        " document.querySelector(tag).style.display = 'none';"
        " document.documentElement.dataset.theme === 'light' ||"
        " document.getElementById('theme').click();"
        f" contensou.setCamera('{camera}'); dispatchEvent(new Event('resize')); }})()"
    )
    if nearer != 1:
        window.value(
            "document.getElementById('stage').dispatchEvent(new WheelEvent('wheel',"
            f" {{deltaY: {-1000 * np.log(nearer)}, cancelable: true}}))"
        )


def frame(window: Browser, time: float) -> Image.Image:
    """The page at a time."""
    window.value(f"contensou.seek({time})")
    return Image.fromarray(window.picture().astype(np.uint8))
