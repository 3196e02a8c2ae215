"""The bench as a user starts it: a process that prints its address."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit


class Served(NamedTuple):
    """A bench that runs: where, and its process."""

    address: str
    process: subprocess.Popen[str]

    @property
    def port(self) -> int:
        return int(urlsplit(self.address).port or 0)

    @property
    def path(self) -> str:
        return urlsplit(self.address).path

    def request(
        self, method: str, what: str = "", body: bytes | None = None, path: str | None = None, **headers: str
    ) -> tuple[int, bytes, dict[str, str]]:
        """Status, body and headers of an answer; a header of the name ``X_Y`` is sent as ``X-Y``, an empty one not."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=30)
        usual = {"Host": f"127.0.0.1:{self.port}"}
        if body is not None:
            usual |= {"Origin": f"http://127.0.0.1:{self.port}", "Content-Type": "application/json"}
            usual["Content-Length"] = str(len(body))
        usual |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection.putrequest(method, (self.path if path is None else path) + what, skip_host=True)
        for name, value in usual.items():
            if value:
                connection.putheader(name, value)
        connection.endheaders(body)
        answer = connection.getresponse()
        told = answer.status, answer.read(), dict(answer.getheaders())
        connection.close()
        return told

    def question(self, kind: str, body: bytes) -> bytes:
        """A request with a question, byte for byte."""
        head = f"POST {self.path}{kind} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n"
        head += f"Origin: http://127.0.0.1:{self.port}\r\nContent-Type: application/json\r\n"
        return f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body

    def ask(self, kind: str, state: dict[str, Any], **more: Any) -> Any:
        """The last thing that a question is answered with."""
        question = json.dumps({"page": "one", "state": state, **more}).encode()
        status, body, _ = self.request("POST", kind, question)
        assert status == 200, body
        last = json.loads(body.splitlines()[-1])
        return last.get("answer", last)


@contextmanager
def serving(scenario: Path, folder: Path, *options: str) -> Iterator[Served]:
    """Run ``vireport explore`` in a folder; it is ended by Ctrl-C."""
    command = [sys.executable, "-m", "vireport", "explore", str(scenario), "--no-browser", *options]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "encoding": "utf-8"}
    with subprocess.Popen(command, cwd=folder, **streams) as process:
        assert process.stdout is not None
        try:
            yield Served(process.stdout.readline().strip(), process)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
