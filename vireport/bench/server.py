"""The page of the bench on this machine alone: who may ask, and what is answered.

It listens on 127.0.0.1 and believes nobody but the page that it has given out: each address begins with a secret, which
the host, the origin and the size of what is sent must go with. A page of another site can neither read nor write.
"""

from __future__ import annotations

import secrets
import socket
import subprocess
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from os.path import realpath
from pathlib import Path
from traceback import print_exc
from typing import Any

import msgspec
from markupsafe import Markup, escape

from vireport.base.encoding import json_answer, json_text
from vireport.base.errors import UsageError, VireportError
from vireport.bench.jobs import Aside, Asked, Worker
from vireport.bench.session import MODULES, NAME, Opened, first, job_of, refusal, require_new, save, start_data
from vireport.scenario.loading import load
from vireport.scenario.writing import names_records
from vireport.text.folders import TEMPLATES
from vireport.text.templates import environment_of

HOST = "127.0.0.1"

LARGEST_QUESTION = 64_000
"""Bytes of a question; a state has some hundred."""

SILENCE = 20.0
"""How long a connection may stay silent [s]: a slow one keeps a thread."""

MOST_UNKNOWN = 64
"""Connections at a time that have not shown the secret yet; of more, the one that has waited longest is closed."""

MOST_ANSWERS = 64
"""Requests that are answered at a time; a browser opens six connections for a page."""

MOST_PAGES = 3
"""Pages with a process of their own, beside that of the margins; of more, that of the page that has asked least
recently is ended."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""What the page may load: what this server gives, and nothing else."""

REPORT_FILES = {"report.html": "text/html; charset=utf-8", "report.pdf": "application/pdf"}
"""Files of a report that the page leads to. Each has a policy of its own in it."""


SCRIPT, STYLE = "text/javascript; charset=utf-8", "text/css; charset=utf-8"
PARTS = {
    **{name: ((f"bench/{name}",), SCRIPT) for name in (*MODULES, "local.js")},
    "bench.css": (("_colors.css", "bench/bench.css"), STYLE),
}
"""Parts of the page: the templates that each is made of, and their kind."""


class Refused(Exception):
    """A request that is not answered, with the status that says why."""

    def __init__(self, status: HTTPStatus) -> None:
        super().__init__(status.phrase)
        self.status = status


class Bench:
    """A scenario that pages ask about.

    Parameters
    ----------
    session : Opened
    folder : Path
        Where scenarios and reports are saved.
    """

    def __init__(self, session: Opened, folder: Path) -> None:
        self.session, self.folder = session, folder
        self.secret = secrets.token_urlsafe(24)
        self._workers: OrderedDict[str, Worker] = OrderedDict()
        self._spare: Worker | None = None
        self._margins_worker: Worker | None = None
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Start the process of the margins, and that of the first page ahead of it."""
        self._margins_worker, self._spare = Worker(), Worker()

    def page(self) -> bytes:
        """The HTML of the bench, with the data that it starts with."""
        start = json_text(start_data(self.session)).replace("<", "\\u003c")
        template = environment_of(None, lambda value: str(escape(value))).get_template("bench/page.html.j2")
        return template.render(title=self.session.name, start=Markup(start)).encode()

    def quick(self, kind: str, question: Asked) -> dict[str, object] | None:
        """Answer what the user waits for: where a file was saved, the margins, or what is first computed."""
        if kind == "save":
            return {"saved": str(save(self.session, question.state, question.name, self.folder))}
        if kind == "margins":
            assert self._margins_worker is not None
            return self._margins_worker.answer(job_of(self.session, Aside.MARGINS, question))
        self._worker(question.page).drop()
        return first(self.session, question.state)

    def slow(self, kind: Aside, question: Asked) -> Iterator[dict[str, object]]:
        """What follows when the hand rests."""
        yield from self._worker(question.page).answers(job_of(self.session, kind, question))

    def report(self, question: Asked) -> Iterator[dict[str, object]]:
        """Save a scenario, and run it as anybody else would."""
        require_new(self.folder / question.name)
        path = save(self.session, question.state, question.name, self.folder)
        yield {"progress": f"writing the report of {path}"}
        folder = path.with_suffix("")
        command = [sys.executable, "-P", "-m", "vireport", "run", str(path), "-o", str(folder)]
        # Saved into another folder it may name records outside of that, which are those that this page may read.
        elsewhere = realpath(self.folder) != realpath(self.session.place.folder) and names_records(load(path).scenario)
        command += ["--allow-outside"] * (self.session.place.outside or elsewhere)
        run = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", check=False)
        if run.returncode > 1:
            yield {"answer": {"refused": [{"path": "", "message": line} for line in run.stderr.splitlines()]}}
            return
        yield {
            "answer": {
                "saved": str(path),
                "folder": str(folder),
                "report": question.name,
                "failed": bool(run.returncode),
            }
        }

    def end(self) -> None:
        """End the worker processes of all pages."""
        for worker in (*self._workers.values(), *filter(None, [self._spare, self._margins_worker])):
            worker.end()

    def _worker(self, page: str) -> Worker:
        """The process of a page, begun ahead for the first one."""
        with self._lock:
            worker = self._workers.pop(page, None) or self._spare or Worker()
            self._spare = None if worker is self._spare else self._spare
            self._workers[page] = worker
            while len(self._workers) > MOST_PAGES:
                self._workers.popitem(last=False)[1].end()
            return worker


class _Handler(BaseHTTPRequestHandler):
    """Answers the requests of one connection of a browser."""

    protocol_version = "HTTP/1.1"
    server_version, sys_version = "vireport", ""
    timeout = SILENCE
    server: _Server
    wbufsize = -1  # one packet for head and body: with two, the second waits 40 ms for the first to be acknowledged
    disable_nagle_algorithm = True

    def __init__(self, bench: Bench, *arguments: Any) -> None:
        self.bench = bench
        super().__init__(*arguments)

    def do_GET(self) -> None:
        self._answered(self._get)

    def do_POST(self) -> None:
        self._answered(self._post)

    def log_message(self, format: str, *arguments: object) -> None:
        """Say nothing of requests: the terminal shows what is wrong, and the address."""

    def _answered(self, answer: Callable[[str], None]) -> None:
        try:
            what = self._requested_path()
            with self.server.place(self.connection):
                answer(what)
        except Refused as refused:
            self.close_connection = True  # what was not read must not be taken for a request
            self._send(refused.status, b"", "text/plain")
        except (ConnectionError, TimeoutError):  # the page has gone
            self.close_connection = True
        except Exception:
            print_exc()
            self.close_connection = True
            with suppress(OSError):
                self._send(HTTPStatus.INTERNAL_SERVER_ERROR, b"", "text/plain")

    def _requested_path(self) -> str:
        """The path of a request without the secret that it begins with.

        Raises
        ------
        Refused
            Where the host is another one, so that another site's name leads here, or the secret.
        """
        if self.headers.get_all("Host") not in [[host] for host in self._hosts]:
            raise Refused(HTTPStatus.FORBIDDEN)
        _, secret, *rest = [*self.path.split("/", 2), "", ""][:3]
        if not secrets.compare_digest(secret.encode(), self.bench.secret.encode()):
            raise Refused(HTTPStatus.FORBIDDEN)
        return rest[0]

    @property
    def _hosts(self) -> tuple[str, str]:
        port = self.connection.getsockname()[1]
        return f"{HOST}:{port}", f"localhost:{port}"

    def _get(self, what: str) -> None:
        if what == "":
            self._send(HTTPStatus.OK, self.bench.page(), "text/html; charset=utf-8")
        elif what in PARTS:
            names, kind = PARTS[what]
            part = b"".join((TEMPLATES / name).read_bytes() for name in names)
            self._send(HTTPStatus.OK, part, kind)
        elif what.startswith("report/"):
            _, name, file = [*what.split("/"), "", ""][:3]
            path = self.bench.folder / name / file
            if file not in REPORT_FILES or not NAME.fullmatch(name) or not path.is_file():
                raise Refused(HTTPStatus.NOT_FOUND)
            self._send(HTTPStatus.OK, path.read_bytes(), REPORT_FILES[file], policy="frame-ancestors 'none'")
        else:
            raise Refused(HTTPStatus.NOT_FOUND)

    def _post(self, what: str) -> None:
        if self.headers.get("Origin") not in [f"http://{host}" for host in self._hosts]:
            raise Refused(HTTPStatus.FORBIDDEN)
        if self.headers.get_content_type() != "application/json":
            raise Refused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
        question = self._question()
        if what in ("first", "margins", "save"):
            answer = _refusing(partial(self.bench.quick, what, question))
            self._send(HTTPStatus.OK, json_answer(answer), "application/json")
        elif what == "report":
            self._stream(self.bench.report(question))
        elif what in set(Aside):
            self._stream(self.bench.slow(Aside(what), question))
        else:
            raise Refused(HTTPStatus.NOT_FOUND)

    def _question(self) -> Asked:
        length = self.headers.get("Content-Length", "")
        if not length.isascii() or not length.isdigit():
            raise Refused(HTTPStatus.LENGTH_REQUIRED)
        if len(length) > 9 or int(length) > LARGEST_QUESTION:
            raise Refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        try:
            return msgspec.json.decode(self.rfile.read(int(length)), type=Asked)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise Refused(HTTPStatus.BAD_REQUEST) from error

    def _stream(self, answers: Iterator[dict[str, object]]) -> None:
        """Send answers as they come, each a line."""
        self.close_connection = True
        self._head(HTTPStatus.OK, "application/x-ndjson", {"Connection": "close"})
        for answer in _each_refusing(answers):
            self.wfile.write(json_text(answer).encode() + b"\n")
            self.wfile.flush()

    def _send(self, status: HTTPStatus, body: bytes, kind: str, policy: str = POLICY) -> None:
        self._head(status, kind, {"Content-Length": str(len(body))}, policy)
        self.wfile.write(body)
        self.wfile.flush()

    def _head(self, status: HTTPStatus, kind: str, more: Mapping[str, str], policy: str = POLICY) -> None:
        self.send_response(status)
        headers = {
            "Content-Type": kind,
            "Content-Security-Policy": policy,
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Cross-Origin-Resource-Policy": "same-origin",
        }
        for name, value in (headers | dict(more)).items():
            self.send_header(name, value)
        self.end_headers()


def _refusing(answer: Callable[[], dict[str, object] | None]) -> dict[str, object] | None:
    """An answer, or why it is refused."""
    try:
        return answer()
    except VireportError as error:
        return refusal(error)


def _each_refusing(answers: Iterator[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Answers as they come; where one cannot be given, why."""
    try:
        yield from answers
    except VireportError as error:
        yield {"answer": refusal(error)}


class _Server(ThreadingHTTPServer):
    """A thread for each connection. Those that have not shown the secret yet take no place from those that have."""

    daemon_threads, block_on_close = True, False
    request_queue_size = MOST_UNKNOWN

    def __init__(self, bench: Bench, port: int) -> None:
        self._places = threading.BoundedSemaphore(MOST_ANSWERS)
        self._unknown = OrderedDict[socket.socket, None]()
        self._lock = threading.Lock()
        super().__init__((HOST, port), partial(_Handler, bench))

    @contextmanager
    def place(self, connection: socket.socket) -> Iterator[None]:
        """Hold a place for a request whose secret and host are known; its connection waits for the next one then.

        Raises
        ------
        Refused
            Where too many are answered.
        """
        if not self._places.acquire(blocking=False):
            raise Refused(HTTPStatus.SERVICE_UNAVAILABLE)
        try:
            with self._lock:
                self._unknown.pop(connection, None)
            yield
        finally:
            self._places.release()
            self._wait(connection)

    def process_request(self, request: Any, client_address: Any) -> None:
        self._wait(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        with self._lock:
            self._unknown.pop(request, None)
        super().shutdown_request(request)

    def _wait(self, connection: socket.socket) -> None:
        """Have a connection wait for its request, and close the one that has waited longest where too many do."""
        with self._lock:
            self._unknown[connection] = None
            longest = self._unknown.popitem(last=False)[0] if len(self._unknown) > MOST_UNKNOWN else None
        if longest is not None:
            with suppress(OSError):
                longest.shutdown(socket.SHUT_RDWR)  # its thread reads the end, and closes it

    def handle_error(self, request: Any, client_address: object) -> None:
        """Say nothing where a page has gone in the middle of a line."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


def serve(session: Opened, folder: Path, port: int, begun: Callable[[str], None]) -> None:
    """Give out the page of a scenario until the process is interrupted.

    Parameters
    ----------
    session : Opened
    folder : Path
        Where scenarios and reports are saved.
    port : int
        0 for any that is free.
    begun : callable
        Told the address of the page.

    Raises
    ------
    UsageError
        If the port is in use, or may not be used.
    """
    bench = Bench(session, folder)
    try:
        try:
            server = _Server(bench, port)
        except (OSError, OverflowError) as error:
            why = getattr(error, "strerror", None) or str(error)
            raise UsageError(
                f"port {port} cannot be used: {why} (allowed: another one; 0 takes one that is free)"
            ) from error
        with server:
            bench.begin()
            begun(f"http://{HOST}:{server.server_address[1]}/{bench.secret}/")
            server.serve_forever(poll_interval=0.2)
    finally:
        bench.end()
