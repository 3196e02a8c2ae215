"""A page in Chromium, as the tests drive it."""

from __future__ import annotations

import json
import os
import select
import shutil
import subprocess
from base64 import b64decode
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--force-prefers-reduced-motion")
PATIENCE = 60
"""Time that the browser has for an answer [s]."""

needs_a_browser = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium to try the page in")


AXE = find_spec("axe_playwright_python")
"""The package that carries axe-core; nothing else of it is used."""

needs_axe = pytest.mark.skipif(AXE is None, reason="there is no axe-core: pip install --no-deps axe-playwright-python")


class Browser:
    """A page in Chromium, spoken to through a pipe; `events` are what it has said of itself."""

    def __init__(self, profile: Path) -> None:
        commands, self.write = os.pipe()
        self.read, answers = os.pipe()

        def pipes() -> None:
            for ours, its in ((commands, 3), (answers, 4)):
                os.dup2(ours, its)
                os.set_inheritable(its, True)  # which `dup2` leaves as it is where both are the same

        arguments = [str(CHROMIUM), *OPTIONS, f"--user-data-dir={profile}"]
        self.process = subprocess.Popen(
            arguments, preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.count, self.rest, self.events, self.session = 0, b"", [], {}
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = {"sessionId": self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        self.count += 1
        message = {"id": self.count, "method": method, "params": params, **self.session}
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while (answer := self.next()).get("id") != self.count:
            self.events.append(answer)
        assert "error" not in answer, answer
        return answer["result"]

    def next(self) -> dict[str, Any]:
        while b"\0" not in self.rest:
            assert select.select([self.read], [], [], PATIENCE)[0], "the browser does not answer"
            self.rest += os.read(self.read, 1 << 16)
        message, _, self.rest = self.rest.partition(b"\0")
        return json.loads(message)

    def open(self, path: Path) -> None:
        self.visit(path.as_uri())

    def visit(self, address: str) -> None:
        self.address, before = address, len(self.events)
        self.call("Page.navigate", url=self.address)
        while not any(event["method"] == "Page.loadEventFired" for event in self.events[before:]):
            self.events.append(self.next())

    def close(self) -> None:
        """End it, and refuse anything that the page has asked for or that has gone wrong."""
        self.end()
        assert self.asked == {self.address}

    def end(self) -> None:
        """End it, and refuse what has gone wrong."""
        self.process.terminate()
        self.process.wait()
        assert self.of("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded") == []

    @property
    def asked(self) -> set[str]:
        """The addresses that pages have asked for."""
        urls = (event["params"]["request"]["url"] for event in self.of("Network.requestWillBeSent"))
        return {url.partition("#")[0] for url in urls if not url.startswith("data:")}

    def look(self, width: int, scheme: str = "light") -> bytes:
        """Give the window a width [px] and a scheme of colours, and return what it shows as a PNG file."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        return b64decode(self.call("Page.captureScreenshot")["data"])

    def of(self, *methods: str) -> list[dict[str, Any]]:
        """Its events of some kinds."""
        return [event for event in self.events if event["method"] in methods]

    def run(self, script: str) -> Any:
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def press(self, key: str, code: int) -> None:
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def overflow(self) -> int:
        """How far the page is wider than the window [px]."""
        return int(self.run("document.documentElement.scrollWidth - document.documentElement.clientWidth"))

    def violations(self, *rules: str) -> list[tuple[str, list[str]]]:
        """What axe-core finds wrong for readers with other senses: by all its rules, or by some, with the elements."""
        assert AXE is not None
        (folder,) = AXE.submodule_search_locations or ()
        self.run((Path(folder) / "axe.min.js").read_text(encoding="utf-8"))
        asked = {"runOnly": rules} if rules else {}
        found = self.run(f"axe.run({json.dumps(asked)}).then(x => x.violations)")
        return [(x["id"], [node["html"][:120] for node in x["nodes"][:3]]) for x in found]
