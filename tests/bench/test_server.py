"""The server of the bench answers its own page, refuses everybody else, and goes on."""

from __future__ import annotations

import json
import os
import random
import signal
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import EXAMPLES
from serving import Served, serving

from vireport.bench.server import MOST_UNKNOWN
from vireport.bench.session import MODULES, first, loaded_of, opened
from vireport.cli.app import main
from vireport.scenario.loading import load


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bench")


@pytest.fixture(scope="module")
def bench(folder: Path) -> Iterator[Served]:
    with serving(EXAMPLES / "design-point.yaml", folder) as served:
        yield served


def test_the_page_and_its_parts_are_given_out(bench: Served) -> None:
    status, page, headers = bench.request("GET")
    assert status == 200
    assert b'id="start"' in page
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert headers["Cache-Control"] == "no-store"
    parts = {"bench.css": "text/css"} | dict.fromkeys((*MODULES, "local.js"), "text/javascript")
    for part, kind in parts.items():
        status, body, headers = bench.request("GET", part)
        assert (status, headers["Content-Type"].partition(";")[0]) == (200, kind)
        assert body


def test_questions_are_answered_as_python_answers_them(bench: Served) -> None:
    state = {"device.length_m": 0.71}
    assert bench.ask("first", state) == first(opened(EXAMPLES / "design-point.yaml"), state)
    assert bench.ask("margins", state)["margins"][0]["parameter"] == "frequency_hz"
    refused = bench.ask("first", {"device.length_m": -1.0})["refused"]
    assert [mistake["path"] for mistake in refused] == ["device.length_m"]


def test_what_takes_long_is_answered_line_by_line(bench: Served) -> None:
    state = {"device.length_m": 0.6, "requirements.margin_any_percent": 3.0}
    assert bench.ask("study", state)["verdict"]["sentence"] == "It does not run: no 1:1 motion is stable."
    status, body, _ = bench.request("POST", "changes", json.dumps({"page": "one", "state": state}).encode())
    lines = [json.loads(line) for line in body.splitlines()]
    assert status == 200
    assert lines[0] == {"progress": "what to change: length"}
    assert lines[-1]["answer"]["changes"]
    cells = bench.ask("plane", {}, axes=["length_m", "restitution"], ranges=[[0.4, 1.0], [0.3, 0.7]])["cells"]
    assert {0, 1, 2} >= {cell for row in cells for cell in row} >= {1, 2}
    refused = bench.ask("plane", {}, axes=["length_m", "mass"], ranges=[[0.4, 1.0], [0.3, 0.7]])["refused"]
    assert "'mass' is no input of the device" in refused[0]["message"]


HOSTS = "evil.test", "127.0.0.1", "localhost:1", "", "127.0.0.1.evil.test"
PATHS = (
    "/",
    "//",
    "/x/",
    "/" + "A" * 32 + "/",
    "/../",
    "/%2e%2e/",
    "/bench.js",
    "/favicon.ico",
    "*",
    "http://evil.test/",
)
PARTS = "x", "../pyproject.toml", "..%2f..%2fetc/passwd", "bench.js/../x"
REPORTS = "", "x", "../report.html", "a/b/report.html", "x/y.html", "%2e%2e/report.html"
METHODS = "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "HEAD", "BREW"
ORIGINS = "", "null", "http://evil.test", "https://127.0.0.1", "http://127.0.0.1"
KINDS = "text/plain", "application/x-www-form-urlencoded", "multipart/form-data"
BODIES = (
    *(b"", b"{", b"[]", b"1", b'"x"', b"{}", b'{"state": 1}', b'{"state": [], "page": 2}'),
    *(b"\xff\xfe", b"[" * 60_000, b'{"state": {}, "axes": ["a"]}'),
    *(b'{"state": {"title": "\xff"}}', b'{"state": {"\xc3": 1}}', '{"state": {"title": "\xfc"}}'.encode("latin-1")),
)
QUESTION = json.dumps({"page": "one", "state": {}}).encode()
ASKED = {"method": "POST", "what": "first", "body": QUESTION}

HOSTILE: list[tuple[int, dict[str, Any]]] = [
    *((403, {"method": "GET", "path": path}) for path in PATHS),
    *((403, {"method": "GET", "Host": host}) for host in HOSTS),
    *((404, {"method": "GET", "what": what}) for what in PARTS),
    *((404, {"method": "GET", "what": f"report/{what}"}) for what in REPORTS),
    *((501, {"method": method}) for method in METHODS),
    *((403, ASKED | {"Origin": origin}) for origin in ORIGINS),
    *((403, ASKED | {"Host": host}) for host in HOSTS),
    *((415, ASKED | {"Content_Type": kind}) for kind in KINDS),
    *((411, ASKED | {"Content_Length": size}) for size in ("x", "-1", "1e3", "0x10")),
    *((413, ASKED | {"Content_Length": size}) for size in ("64001", "9" * 9, "9" * 30)),
    *((400, ASKED | {"body": body}) for body in BODIES),
    *((404, ASKED | {"what": what}) for what in ("x", "first/", "", "quick", "../first")),
]
"""Requests of others, and of pages that are not ours, with the status that they get."""


def test_everybody_else_is_refused_and_the_server_goes_on(bench: Served) -> None:
    assert len(HOSTILE) * 2 >= 100
    for status, request in HOSTILE * 2:
        assert bench.request(**request)[0] == status, request
    assert bench.ask("first", {})["shown"] == 0


def test_lines_that_are_no_requests_are_refused(bench: Served) -> None:
    rng = random.Random(5)
    for _ in range(40):
        garbage = bytes(rng.randrange(256) for _ in range(rng.randrange(1, 300))) + b"\r\n\r\n"
        with socket.create_connection(("127.0.0.1", bench.port), timeout=10) as connection:
            connection.sendall(garbage)
            connection.shutdown(socket.SHUT_WR)
            answer = b"".join(iter(lambda: connection.recv(4096), b""))
        assert b"200 OK" not in answer
    assert bench.ask("first", {})["shown"] == 0


@pytest.mark.slow
def test_connections_that_say_nothing_do_not_keep_others_waiting(bench: Served) -> None:
    silent = [socket.create_connection(("127.0.0.1", bench.port)) for _ in range(40)]
    for connection in silent[:20]:
        connection.sendall(b"POST " + bench.path.encode() + b"first HTTP/1.1\r\nHost: 127.0")
    begun = time.monotonic()
    assert bench.ask("first", {})["shown"] == 0
    assert time.monotonic() - begun < 15  # they are given up after 20 s
    for connection in silent:
        connection.close()


def test_silent_connections_take_no_place_from_the_page(bench: Served) -> None:
    """More than may wait at a time: those that have waited longest are closed, and the page is answered.

    So is a request that is known, and whose body is late.
    """
    late = bench.question("first", b'{"page": "one", "state": {}}')
    known = socket.create_connection(("127.0.0.1", bench.port), timeout=30)
    known.sendall(late[:-1])
    assert bench.ask("first", {})["shown"] == 0
    silent = [socket.create_connection(("127.0.0.1", bench.port), timeout=30) for _ in range(MOST_UNKNOWN + 8)]
    for k, connection in enumerate(silent):
        connection.sendall((b"", b"POST /wrong/first HTTP/1.1\r\nHost: 127.0", b"GET /")[k % 3])
    assert bench.ask("first", {})["shown"] == 0
    assert [connection.recv(1) for connection in silent[:8]] == [b""] * 8
    known.sendall(late[-1:])
    assert known.recv(12) == b"HTTP/1.1 200"
    for connection in (known, *silent):
        connection.close()
    assert bench.ask("first", {})["shown"] == 0


def test_of_many_mistakes_the_first_are_told(bench: Served) -> None:
    told = bench.ask("first", {f"k{n}": 1 for n in range(3000)})["refused"]
    assert len(told) == 21
    assert told[0]["path"] == "k0"
    assert told[-1] == {"path": "", "message": "There are 2980 more mistakes."}


@pytest.mark.slow
def test_a_page_that_is_loaded_again_and_again_leaves_four_processes(bench: Served) -> None:
    """Each page is left while its first question is being answered."""
    for page in range(20):
        question = json.dumps({"page": f"page {page}", "state": {"disturbances": {"prove": True}}}).encode()
        with socket.create_connection(("127.0.0.1", bench.port), timeout=30) as connection:
            connection.sendall(bench.question("study", question))
            assert connection.recv(12) == b"HTTP/1.1 200"
        time.sleep(0.1)
    time.sleep(2.0)
    assert len(children(bench.process.pid)) <= 4
    assert bench.ask("study", {})["verdict"]


def test_a_state_may_hold_anything(bench: Served) -> None:
    for state in (
        {"": 1},
        {"a.b.c": {"d": [1, "x", None, True]}},
        {"device": None},
        {"device.length_m": "<script>", "title": "\u202e\x00"},
        {"sweep": {"parameter": "x"}},
        {"x" * 5000: 1},
        {"device.length_m=1": 2},
        {"excitation.harmonics": [[[]]]},
        {"device.length_m": 1e308},
        {"period_ratio": 10**30},
    ):
        assert bench.ask("first", state)["refused"], state
    assert bench.ask("first", {})["shown"] == 0


@pytest.mark.slow
def test_two_pages_do_not_wait_for_one_another(bench: Served) -> None:
    """One works out proofs of a minute, and is ended when its page asks for another thing."""
    slow = {"disturbances": {"prove": True}, "device.length_m": 0.72}
    answers: dict[str, Any] = {}

    def ask(page: str, state: dict[str, Any]) -> None:
        question = json.dumps({"page": page, "state": state}).encode()
        answers[page] = bench.request("POST", "study", question)[1]

    first_page = threading.Thread(target=ask, args=("slow", slow))
    first_page.start()
    time.sleep(1.0)
    begun = time.monotonic()
    ask("quick", {"device.length_m": 0.73})
    assert b"verdict" in answers["quick"]
    again = json.dumps({"page": "slow", "state": {"device.length_m": 0.74}}).encode()
    assert b"verdict" in bench.request("POST", "study", again)[1]
    first_page.join(20)
    assert b'"answer"' not in answers["slow"]
    assert time.monotonic() - begun < 30


def test_a_scenario_and_its_report_are_written(bench: Served, folder: Path) -> None:
    saved = bench.ask("save", {"device.length_m": 0.7}, name="mine")
    assert saved == {"saved": "mine.yaml"}
    assert load(folder / "mine.yaml").scenario.device.length_m == 0.7
    refused = bench.ask("save", {}, name="mine")["refused"]
    assert refused == [{"path": "", "message": "mine.yaml exists already (give another name)"}]
    assert "no name for a file" in bench.ask("save", {}, name="../mine")["refused"][0]["message"]


@pytest.mark.slow
def test_a_report_is_that_of_a_run(bench: Served, folder: Path, tmp_path: Path) -> None:
    told = bench.ask("report", {"device.length_m": 0.7}, name="whole")
    assert told == {"saved": "whole.yaml", "folder": "whole", "report": "whole", "failed": False}
    assert main(["run", str(folder / "whole.yaml"), "-o", str(tmp_path), "-q"]) == 0
    assert (tmp_path / "report.html").read_bytes() == (folder / "whole" / "report.html").read_bytes()
    for file in ("report.html", "report.pdf"):
        status, body, _ = bench.request("GET", f"report/whole/{file}")
        assert (status, body) == (200, (folder / "whole" / file).read_bytes())
    assert bench.request("GET", "report/whole/results.json")[0] == 404


@pytest.mark.slow
def test_a_report_saved_elsewhere_has_the_records_of_the_page(tmp_path: Path) -> None:
    with serving(EXAMPLES / "driven.yaml", tmp_path) as served:
        told = served.ask("report", {}, name="driven")
    assert told == {"saved": "driven.yaml", "folder": "driven", "report": "driven", "failed": False}
    assert "driven" in json.loads((tmp_path / "driven" / "results.json").read_text())


@pytest.mark.slow
def test_it_ends_at_ctrl_c_with_all_its_processes(tmp_path: Path) -> None:
    with serving(EXAMPLES / "design-point.yaml", tmp_path) as served:
        assert served.ask("study", {})["verdict"]
        beside = children(served.process.pid)
        assert len(beside) == 2
        served.process.send_signal(signal.SIGINT)
        _, errors = served.process.communicate(timeout=20)
    assert served.process.returncode == 130
    assert (
        errors.splitlines()[-1] == "vireport: interrupted (the page keeps what is set; files that it saved are there)"
    )
    assert "Traceback" not in errors
    assert not any(Path(f"/proc/{own}").exists() for own in beside)


def children(process: int) -> list[int]:
    """Those of each thread of a process."""
    threads = Path(f"/proc/{process}/task").iterdir()
    return [int(own) for thread in threads for own in (thread / "children").read_text().split()]


def test_a_port_in_use_is_told(bench: Served, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explore", str(EXAMPLES / "design-point.yaml"), "--no-browser", "--port", str(bench.port)]) == 2
    message = capsys.readouterr().err
    assert message.startswith(f"vireport: error: port {bench.port} cannot be used: ")
    assert "0 takes one that is free" in message


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.yaml"], "nowhere.yaml: no such file"),
        ([str(EXAMPLES / "maps" / "map.yaml")], "has a map block"),
        ([str(EXAMPLES / "inclined.yaml"), "--set", "device.restitution=2"], "device.restitution"),
        ([str(EXAMPLES / "inclined.yaml"), "--port", "70000"], "65535"),
        ([str(EXAMPLES / "inclined.yaml"), "-o", os.devnull], "is no folder"),
    ],
)
def test_what_cannot_be_explored_is_told(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["explore", "--no-browser", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_an_earlier_run_is_explored_as_its_scenario_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario, known = str(EXAMPLES / "design-point.yaml"), []
    assert main(["run", scenario, "-o", str(tmp_path), "--format", "json", "-q"]) == 0
    monkeypatch.setattr("vireport.bench.server.serve", lambda opened, *_: known.append(opened))
    over = ["--set", "device.length_m=0.71", "--no-browser"]
    assert main(["explore", str(tmp_path / "results.json"), *over]) == 0
    assert main(["explore", scenario, *over]) == 0
    again, first = (loaded_of(opened, {}).scenario for opened in known)
    assert again == first
    assert again.device.length_m == 0.71


@pytest.mark.slow
def test_where_no_browser_opens_the_address_is_there(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def serve(known: Any, folder: Path, port: int, begun: Any) -> None:
        begun("http://127.0.0.1:1/x/")

    monkeypatch.setattr("vireport.bench.server.serve", serve)
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    assert main(["explore", str(EXAMPLES / "best-design.yaml")]) == 0
    told = capsys.readouterr()
    assert told.out == "http://127.0.0.1:1/x/\n"
    assert "The block design has no part here" in told.err
    assert "open the address by hand" in told.err
