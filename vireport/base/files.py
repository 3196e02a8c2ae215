"""Files that are whole or are not there, and sets of files that belong together."""

from __future__ import annotations

import errno
import os
import secrets
import stat
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import rmtree

from vireport.base import interrupts
from vireport.base.errors import OutputError, UsageError

STAGING = ".vireport-"
"""How the name begins of a folder in which a set of files waits until all of them are written."""

FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""What is wrong with the disk, and not with the place that the caller named."""

PATIENCE = 10.0
"""How long another run may take to put its files into the same folder [s]; it takes some milliseconds."""


def write_files(folder: Path, files: Mapping[str, bytes], stale: Iterable[str] = ()) -> None:
    """Put a set of files into a folder, which is made if there are any, all of them or none.

    They are written beside those that are there, and then put in place together. A process that is killed in between
    leaves fewer files, but never some of one set and some of another.

    Parameters
    ----------
    folder : Path
    files : mapping of str to bytes
        Contents by their names.
    stale : iterable of str
        Names of files that go if they are there and not in the set.

    Raises
    ------
    UsageError
        If the folder cannot be written to.
    OutputError
        If the disk is full or faulty.
    """
    if not files:
        return
    with writable(folder):
        created = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        try:
            with _locked(folder) as alone:
                if alone:
                    _remove_abandoned(folder)
                _require_places(folder, [*files, *stale])
                _put(folder, files, stale)
        except BaseException:
            if created:
                with suppress(OSError):  # there is something in it by now
                    folder.rmdir()
            raise


def require_writable(folder: Path, names: Iterable[str] = ()) -> None:
    """Say before any work that a folder, or the one it is to be made in, cannot be written to.

    Raises
    ------
    UsageError
    """
    if not folder.is_absolute():
        try:
            os.getcwd()
        except FileNotFoundError as error:
            raise UsageError(f"{folder} cannot be written: the current folder has been deleted") from error
    there = folder
    while not os.path.lexists(there) and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise UsageError(f"{folder} cannot be written: {there} is no folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise UsageError(f"{folder} cannot be written: {there} does not allow it")
    with writable(folder):
        _require_places(folder, names)


def write_new(path: Path, data: bytes) -> None:
    """Write a file where there is none; one that fails leaves nothing behind.

    Raises
    ------
    FileExistsError
        If there is one.
    OSError
        If it cannot be written.
    """
    open(path, "xb").close()
    try:
        write_whole(path, data)
    except BaseException:
        path.unlink(missing_ok=True)
        raise


def write_whole(path: Path, data: bytes) -> None:
    """Write under a temporary name and rename: an interrupted run leaves the old file or the new one."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with open(temporary, "xb") as file:
            file.write(data)
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


@contextmanager
def writable(place: Path, advice: str = "") -> Iterator[None]:
    """Say what cannot be written, and why; `advice` follows.

    Raises
    ------
    UsageError, OutputError
        In the place of an OSError.
    """
    try:
        yield
    except OSError as error:
        kind = OutputError if error.errno in FAULTS else UsageError
        what = error.filename or place
        raise kind(f"{os.fsdecode(what)} cannot be written: {error.strerror or error}{advice}") from error


def _put(folder: Path, files: Mapping[str, bytes], stale: Iterable[str]) -> None:
    """Write all files into a folder of their own, take away what is there, and move them to where it was."""
    staging = folder / f"{STAGING}{secrets.token_hex(4)}"
    old = staging / "old"
    moved: list[tuple[Path, Path]] = []

    def move(source: Path, target: Path) -> None:
        os.rename(source, target)
        moved.append((source, target))

    try:
        old.mkdir(parents=True)
        for name, data in files.items():
            (staging / name).write_bytes(data)
        with interrupts.deferred():
            for name in dict.fromkeys((*files, *stale)):
                if os.path.lexists(folder / name):
                    move(folder / name, old / name)
            for name in files:
                move(staging / name, folder / name)
            moved.clear()
            rmtree(staging, ignore_errors=True)
    except BaseException:
        for source, target in reversed(moved):  # should that fail too, the old files stay where they are now
            os.rename(target, source)
        rmtree(staging, ignore_errors=True)
        raise


def _require_places(folder: Path, names: Iterable[str]) -> None:
    """Refuse to put a file where there is a folder or a device, which are not ours to remove."""
    for name in names:
        with suppress(FileNotFoundError, NotADirectoryError):
            mode = os.lstat(folder / name).st_mode
            if not stat.S_ISREG(mode) and not stat.S_ISLNK(mode):
                raise OSError(errno.EEXIST, "there is something that is no file", str(folder / name))


def _remove_abandoned(folder: Path) -> None:
    """Remove what runs that were killed have left, those of all others being over."""
    for left in folder.glob(f"{STAGING}*"):
        rmtree(left, ignore_errors=True)


@contextmanager
def _locked(folder: Path) -> Iterator[bool]:
    """Hold a folder for one process; False where the system has no locks for folders."""
    try:
        import fcntl
    except ImportError:  # Windows
        yield False
        return
    descriptor, end = os.open(folder, os.O_RDONLY), time.monotonic() + PATIENCE
    try:
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                if time.monotonic() > end:
                    raise UsageError(f"{folder} cannot be written: another run is writing to it") from error
                time.sleep(0.01)
                continue
            except OSError:  # a file system without locks
                break
            yield True
            return
    finally:
        os.close(descriptor)
    yield False
