"""Processes and clusters that compute a map: killed, absent, frozen, or with other packages."""

from __future__ import annotations

import os
import signal
import socket
import socketserver
import struct
import subprocess
import sys
import threading
import time
from collections import deque
from pathlib import Path

import pytest
from map_texts import TEXT, result, store_in, undisturbed_result, written_map

from vireport.base.errors import NumericalError, UsageError
from vireport.map.cells import workers
from vireport.map.cells.run import run_map


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return written_map(tmp_path)


RUN = """
import sys
from pathlib import Path
from vireport.map.cells import workers
from vireport.map.cells.run import run_map
workers.WORTH_HELP = 1e-9
if __name__ == "__main__":
    run_map(sys.argv[1], Path(sys.argv[2]), workers=2, draw=False)
"""


def wait_until(condition, seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.002)


def children(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()


@pytest.mark.slow
def test_kill_9_of_a_run_loses_no_chunk_and_leaves_no_process(file: Path, tmp_path: Path) -> None:
    file.write_text(TEXT.replace("count: 20", "count: 400"), encoding="utf-8")
    script, out = tmp_path / "run.py", tmp_path / "out"
    script.write_text(RUN, encoding="utf-8")
    run = subprocess.Popen([sys.executable, str(script), str(file), str(out)])
    wait_until(lambda: len(list((out / ".chunks").glob("*.chunk"))) >= 3 or run.poll() is not None)
    (helper,) = children(run.pid)
    run.kill()
    run.wait()
    assert 3 <= len(list((out / ".chunks").glob("*.chunk"))) < 167
    wait_until(lambda: not is_running(helper))
    run_map(str(file), out, workers=1, draw=False)
    run_map(str(file), tmp_path / "calm", workers=1, draw=False)
    assert result(out) == result(tmp_path / "calm")


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[workers.Helper]:
    """The processes that help with a map for which help pays at once."""
    helpers: list[workers.Helper] = []
    begin = workers.begin_helper

    def beginning(*arguments) -> workers.Helper:
        helpers.append(begin(*arguments))
        return helpers[-1]

    monkeypatch.setattr(workers, "WORTH_HELP", 1e-9)
    monkeypatch.setattr(workers, "begin_helper", beginning)
    return helpers


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3])
def test_same_bytes_on_any_number_of_cores(count: int, file: Path, begun: list[workers.Helper]) -> None:
    out = file.parent / "out"
    run_map(str(file), out, workers=count, draw=False)
    assert result(out) == undisturbed_result()
    assert sorted(path.name for path in out.iterdir()) == [".lock", "map.parquet", "map.parquet.sha256"]
    assert [helper.process.returncode for helper in begun] == [0] * (count - 1)


def test_no_process_is_begun_for_what_takes_less_time(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "WORTH_HELP", 1000.0)
    monkeypatch.setattr(workers, "begin_helper", None)
    run_map(str(file), file.parent / "out", workers=8, draw=False)
    assert result(file.parent / "out") == undisturbed_result()


@pytest.mark.slow
@pytest.mark.parametrize("fault", [signal.SIGKILL, signal.SIGSTOP])
def test_chunks_of_a_lost_process_are_computed_by_the_others(
    fault: signal.Signals, file: Path, begun: list[workers.Helper]
) -> None:
    shares: list[int] = []

    def progress(done: int, total: int) -> None:
        if begun and not shares:
            shares.append(len(begun[0].chunks))
            begun[0].process.send_signal(fault)
            # A process that stands still is lost once somebody ends it.
            threading.Timer(1.0, begun[0].process.kill).start()

    run_map(str(file), file.parent / "out", workers=2, progress=progress, draw=False)
    assert shares == [workers.AHEAD]
    assert begun[0].process.returncode == -signal.SIGKILL
    assert len(begun) == 1
    assert result(file.parent / "out") == undisturbed_result()


def test_what_fails_in_another_process_is_told_by_this_one(
    file: Path, begun: list[workers.Helper], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "HELPER", "vireport.no_such_module")
    run_map(str(file), file.parent / "out", workers=2, draw=False)
    assert begun[0].process.returncode == 1
    assert result(file.parent / "out") == undisturbed_result()


@pytest.mark.parametrize(
    "address", ["", "foo://1.2.3.4:5", "tcp://host", "tcp://host:99999", "tcp://host:x", "tcp://[::1", "tcp://:8786"]
)
def test_what_is_no_address_of_a_scheduler_is_refused(file: Path, address: str) -> None:
    with pytest.raises(UsageError, match="--scheduler: got"):
        run_map(str(file), file.parent / "out", scheduler=address, draw=False)


@pytest.fixture
def quiet_dask():
    dask = pytest.importorskip("dask")
    pytest.importorskip("distributed")
    settings = {
        "distributed.admin.tick.limit": "60s",
        "distributed.comm.timeouts.connect": "5s",
        "logging.distributed": "critical",
    }
    with dask.config.set(settings):
        yield


def cluster(count: int):
    import distributed

    return distributed.LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=":0", silence_logs=50)


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
@pytest.mark.parametrize("shared", [True, False])
def test_a_cluster_gives_the_same_bytes_though_a_worker_is_killed(
    shared: bool, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not shared:
        monkeypatch.setattr(Path, "touch", lambda path: None)
    with cluster(2) as dask_cluster:
        killed: list[int] = []

        def progress(done: int, total: int) -> None:
            if done >= 120 and not killed:
                killed.append(dask_cluster.workers[0].pid)
                os.kill(killed[0], signal.SIGKILL)

        out = file.parent / "out"
        run_map(str(file), out, scheduler=dask_cluster.scheduler_address, progress=progress, draw=False)
    assert killed
    assert result(out) == undisturbed_result()


def compute_on(address: str, folder: Path) -> None:
    store = store_in(folder)
    store.chunks.mkdir(parents=True)
    list(workers.compute(store, deque([0, 1]), address, 1))


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
def test_a_scheduler_that_is_not_there_is_told(tmp_path: Path) -> None:
    import dask

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "300ms"}),
        pytest.raises(NumericalError, match="cannot be reached"),
    ):
        compute_on("tcp://127.0.0.1:9", tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_something_else_in_the_place_of_a_scheduler_is_told(scheme: str, tmp_path: Path) -> None:
    class Greeting(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            self.request.sendall(b"SSH-2.0-OpenSSH_9.2\r\n")

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Greeting) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with pytest.raises(NumericalError, match="is no Dask scheduler"):
            compute_on(f"{scheme}://127.0.0.1:{server.server_address[1]}", tmp_path)
        server.shutdown()


NONSENSE = {
    "a frame that is no message": struct.pack("<QQQ", 21, 1, 5) + b"\xc1\xff\xff\xff\xff",
    "more than there is memory for": struct.pack("<QQ", 1 << 62, 1 << 40),
    "a page": b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
}


@pytest.mark.slow
@pytest.mark.parametrize("said", NONSENSE.values(), ids=NONSENSE)
def test_a_scheduler_that_speaks_nonsense_is_told_in_one_line(said: bytes, file: Path) -> None:
    class Nonsense(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            self.request.sendall(said)
            self.request.recv(1000)

    class Server(socketserver.ThreadingTCPServer):
        daemon_threads = True

    with Server(("127.0.0.1", 0), Nonsense) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        place = f"tcp://127.0.0.1:{server.server_address[1]}"
        run = subprocess.run(
            [sys.executable, "-m", "vireport", "map", file.name, "--scheduler", place],
            cwd=file.parent,
            capture_output=True,
            text=True,
        )
        server.shutdown()
    assert run.returncode == 3
    (line,) = run.stderr.splitlines()
    assert "is no Dask scheduler" in line


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
@pytest.mark.parametrize("fault", [signal.SIGKILL, signal.SIGSTOP])
def test_a_scheduler_that_is_lost_is_told_and_the_run_resumed(
    file: Path, fault: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed.utils import open_port

    monkeypatch.setattr(workers, "ANSWER", 5.0)
    port, out = open_port("127.0.0.1"), file.parent / "out"
    command, place = [sys.executable, "-m", "distributed.cli.dask_scheduler"], f"tcp://127.0.0.1:{port}"
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", place, "--nthreads=1", "--no-nanny"]
    with (
        subprocess.Popen([*command, "--host=127.0.0.1", f"--port={port}", "--no-dashboard"], stderr=-3) as scheduler,
        subprocess.Popen(worker, stderr=-3, cwd=file.parent) as computing,
    ):
        try:
            wait_until(lambda: is_listening(port))
            with pytest.raises(NumericalError, match=r"scheduler .* (was|were) lost"):
                run_map(
                    str(file),
                    out,
                    scheduler=place,
                    progress=lambda done, total: scheduler.send_signal(fault) if done == 120 else None,
                    draw=False,
                )
        finally:
            scheduler.kill()
            computing.kill()
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed_result()


def is_listening(port: int) -> bool:
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
def test_a_scheduler_without_workers_is_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "PATIENCE", 1.0)
    monkeypatch.setattr(workers, "POLL", 0.2)
    with cluster(0) as dask_cluster, pytest.raises(NumericalError, match=r"no workers for 1 s \(start one"):
        compute_on(dask_cluster.scheduler_address, tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
def test_frozen_workers_are_not_waited_for(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "PATIENCE", 3.0)
    monkeypatch.setattr(workers, "POLL", 0.5)
    with cluster(1) as dask_cluster:
        pid = dask_cluster.workers[0].pid

        def progress(done: int, total: int) -> None:
            if done == 120:
                os.kill(pid, signal.SIGSTOP)

        try:
            with pytest.raises(NumericalError, match="no sign of life from its workers for 3 s"):
                run_map(
                    str(file),
                    file.parent / "out",
                    scheduler=dask_cluster.scheduler_address,
                    progress=progress,
                    draw=False,
                )
        finally:
            os.kill(pid, signal.SIGCONT)


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
def test_frozen_workers_among_others_are_given_up(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "PATIENCE", 2.0)
    monkeypatch.setattr(workers, "POLL", 0.5)
    out, frozen = file.parent / "out", []
    with cluster(1) as dask_cluster:
        place = dask_cluster.scheduler_address
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", place, "--nthreads=1", "--no-nanny"]
        others = [subprocess.Popen([*worker, "--no-dashboard"], stderr=-3, cwd=file.parent) for _ in range(2)]
        nanny = dask_cluster.workers[0]
        first = nanny.pid

        def progress(done: int, total: int) -> None:
            if done >= 120 and not frozen:
                frozen.append(time.monotonic())
                os.kill(first, signal.SIGSTOP)
                others[0].send_signal(signal.SIGSTOP)

        try:
            wait_until(lambda: len(dask_cluster.scheduler.workers) == 3)
            run_map(str(file), out, scheduler=place, progress=progress, draw=False)
            assert frozen
            assert time.monotonic() - frozen[0] < 60  # the scheduler itself gives them up after 5 to 10 minutes
            others[0].send_signal(signal.SIGCONT)
            others[0].wait(30)  # its chunks are others': it is told to end
            wait_until(lambda: nanny.pid not in (None, first))
        finally:
            for process in others:
                process.kill()
                process.wait()
    assert result(out) == undisturbed_result()


OTHER_VERSION = """
from importlib import metadata

own = metadata.version
metadata.version = lambda name: "0.0.1" if name == "vireport" else own(name)
"""


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_dask")
def test_workers_with_another_version_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "sitecustomize.py").write_text(OTHER_VERSION, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    with (
        cluster(1) as dask_cluster,
        pytest.raises(NumericalError, match=r"worker tcp.* has vireport in version 0\.0\.1, this process"),
    ):
        compute_on(dask_cluster.scheduler_address, tmp_path)
