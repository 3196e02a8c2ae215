"""Sets of files: all of one run or all of another, whatever interrupts it, and nothing of anybody else's."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from vireport.base import files, interrupts
from vireport.base.errors import OutputError, UsageError
from vireport.base.files import require_writable, write_files, write_new, write_whole

OLD = {"a": b"old a", "b": b"old b"}
NEW = {"a": b"new a", "c": b"new c"}


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_files(tmp_path / "out", OLD)
    return tmp_path / "out"


def test_a_set_takes_the_place_of_another_and_leaves_what_is_not_of_it(folder: Path) -> None:
    (folder / "mine").write_bytes(b"mine")
    write_files(folder, NEW, ("b",))
    assert content(folder) == {**NEW, "mine": b"mine"}


@pytest.mark.parametrize("reason", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("count", range(6))
def test_whatever_goes_wrong_leaves_the_old_set(folder: Path, reason: BaseException, count: int, monkeypatch) -> None:
    """Each operation on files fails once: two are written, two old ones moved away, two new ones moved in."""
    calls = 0

    def failing(real):
        def call(*arguments):
            nonlocal calls
            calls += 1
            if calls == count + 1:
                raise reason
            return real(*arguments)

        return call

    monkeypatch.setattr(Path, "write_bytes", failing(Path.write_bytes))
    monkeypatch.setattr(os, "rename", failing(os.rename))
    with pytest.raises((OutputError, KeyboardInterrupt)):
        write_files(folder, NEW, ("b",))
    assert content(folder) == OLD


def test_a_run_that_fails_leaves_no_folder(tmp_path: Path, monkeypatch) -> None:
    def full(path: Path, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OutputError, match="No space left") as caught:
        write_files(tmp_path / "out", NEW)
    assert caught.value.exit_code == 3
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_while_files_are_put_in_place_waits(folder: Path, monkeypatch) -> None:
    """The rest is put in place, and the interrupt is not forgotten."""
    rename = os.rename

    def interrupted(*arguments: Path) -> None:
        rename(*arguments)
        interrupts._interrupt(2, None)

    monkeypatch.setattr(os, "rename", interrupted)
    monkeypatch.setattr(interrupts, "_received", False)
    write_files(folder, NEW, ("b",))
    assert content(folder) == NEW
    assert interrupts.received()
    with pytest.raises(KeyboardInterrupt):
        write_files(folder, OLD)
    assert content(folder) == NEW


def test_what_a_killed_run_has_left_is_removed(folder: Path) -> None:
    left = folder / f"{files.STAGING}0123" / "old"
    left.mkdir(parents=True)
    (left / "a").write_bytes(b"")
    write_files(folder, NEW)
    assert content(folder) == {**OLD, **NEW}


def test_two_runs_do_not_mix(folder: Path, monkeypatch) -> None:
    fcntl = pytest.importorskip("fcntl")
    monkeypatch.setattr(files, "PATIENCE", 0.05)
    held = os.open(folder, os.O_RDONLY)
    fcntl.flock(held, fcntl.LOCK_EX)
    with pytest.raises(UsageError, match="another run"):
        write_files(folder, NEW)
    os.close(held)
    assert content(folder) == OLD
    write_files(folder, NEW)


def test_a_folder_in_the_place_of_a_file_is_not_touched(folder: Path) -> None:
    (folder / "c").mkdir()
    (folder / "c" / "mine").write_bytes(b"mine")
    for check in (lambda: require_writable(folder, NEW), lambda: write_files(folder, NEW)):
        with pytest.raises(UsageError, match="no file"):
            check()
    assert (folder / "c" / "mine").read_bytes() == b"mine"


def test_links_are_replaced_and_what_they_lead_to_is_not(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "far").write_bytes(b"far")
    (folder / "c").symlink_to(tmp_path / "far")
    write_files(folder, NEW)
    assert (tmp_path / "far").read_bytes() == b"far"
    assert not (folder / "c").is_symlink()


def test_what_cannot_be_written_is_said_beforehand(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(UsageError, match="is no folder"):
        require_writable(tmp_path / "file" / "out" / "deep")
    require_writable(tmp_path / "new" / "out")
    assert not (tmp_path / "new").exists()


def test_permissions_are_those_that_the_user_asks_for(tmp_path: Path) -> None:
    previous = os.umask(0o027)
    try:
        write_files(tmp_path / "out", NEW)
        write_new(tmp_path / "new", b"")
    finally:
        os.umask(previous)
    modes = [stat.S_IMODE(path.stat().st_mode) for path in (tmp_path / "out", tmp_path / "out" / "a", tmp_path / "new")]
    assert modes == [0o750, 0o640, 0o640]


def test_a_new_file_is_whole_or_not_there(tmp_path: Path, monkeypatch) -> None:
    write_new(tmp_path / "new", b"first")
    with pytest.raises(FileExistsError):
        write_new(tmp_path / "new", b"second")
    assert (tmp_path / "new").read_bytes() == b"first"

    def failing(source: Path, target: Path) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", failing)
    for write, name in ((write_new, "other"), (write_whole, "new")):
        with pytest.raises(OSError, match="No space left"):
            write(tmp_path / name, b"second")
    assert (tmp_path / "new").read_bytes() == b"first"
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
