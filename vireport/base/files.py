"""Files that are whole or are not there, and sets of files that belong together."""

from __future__ import annotations

import errno
import os
import re
import stat
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import rmtree

from vireport.base import interrupts
from vireport.base.errors import OutputError, UsageError
from vireport.base.version import __version__

STAGING = ".vireport-"
"""How the name begins of a folder in which a set of files waits until all of them are written."""

FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""What is wrong with the disk, and not with the place that the caller named."""

WRITTEN_BY = f"vireport {__version__}"
"""What a file says of itself, in its kind's way, where it was written by this program."""

MARKS = {
    ".html": re.compile(rb'<meta name="generator" content="vireport |<!-- vireport '),
    ".json": re.compile(rb'"provenance":\s*\{\s*"version":\s*"[^"]*",\s*"scenario_name":'),
    ".md": re.compile(rb"<!-- vireport "),
    ".pdf": re.compile(rb"/(Author|Creator)\s*\(vireport |\n% vireport "),
    ".png": re.compile(rb"\A\x89PNG\r\n.*tEXtSoftware\x00vireport ", re.DOTALL),
    ".svg": re.compile(rb"<!-- vireport "),
    ".xml": re.compile(rb'<testsuites name="vireport"'),
    ".yaml": re.compile(rb"\n# vireport "),
    "branches.csv": re.compile(rb"\Abranch,family,sweep_value,d,gbar,"),
    "compare.csv": re.compile(rb"\Ascenario,rank,verdict,(conclusions,)?requirements_met,"),
}
"""By what a file is known to be written by this program, by its suffix; a table has no place for a mark, and is known
by its head."""

COMMENTS = {".html": "<!-- {} -->", ".md": "<!-- {} -->", ".pdf": "% {}", ".svg": "<!-- {} -->", ".yaml": "# {}"}
"""What a file ends with where nothing else in it says what wrote it, by its suffix."""

RECOGNISED_BY = {"impacts.csv": ("identified.json", "figure-record.png"), "identified.yaml": ("identified.json",)}
"""Files with what a user's have as well: they are ours beside one of these of ours."""

MOST_NAMED = 5
"""Files that a message names."""

PATIENCE = 10.0
"""How long another run may take to put its files into the same folder [s]; it takes some milliseconds."""


def write_files(folder: Path, files: Mapping[str, bytes], stale: Iterable[str] = ()) -> None:
    """Put a set of files into a folder, which is made if there are any, all of them or none, each with its mark.

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
    files = {name: marked(name, data) for name, data in files.items()}
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


def require_writable(folder: Path, names: Iterable[str] = (), force: bool = False) -> None:
    """Say before any work that files cannot be written to a folder, or would replace some that are not ours.

    Parameters
    ----------
    folder : Path
        Where they go; it may have to be made.
    names : iterable of str
        Files that may be written, and go where they are there already.
    force : bool
        Whether files that this program did not write may go too.

    Raises
    ------
    UsageError
    """
    if not folder.is_absolute():
        try:
            os.getcwd()
        except FileNotFoundError as error:
            raise UsageError(f"{folder} cannot be written: the current folder has been deleted") from error
    existing = folder
    while not os.path.lexists(existing) and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise UsageError(f"{folder} cannot be written: {existing} is no folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise UsageError(f"{folder} cannot be written: {existing} does not allow it")
    names = tuple(names)
    with writable(folder):
        _require_places(folder, names)
    if not force:
        _require_ours(folder, names)


def _require_ours(folder: Path, names: Iterable[str]) -> None:
    """Refuse to replace files that this program did not write.

    Raises
    ------
    UsageError
    """
    others = [name for name in names if os.path.lexists(folder / name) and not _is_ours(folder / name)]
    if others:
        named = ", ".join(others[:MOST_NAMED]) + (", ..." if len(others) > MOST_NAMED else "")
        one = len(others) == 1
        raise UsageError(
            f"{folder} holds {named}, which vireport did not write: nothing is replaced (name another folder with -o, "
            f"or give --force, which replaces {'it' if one else 'them'})"
        )


def _is_ours(path: Path) -> bool:
    """Whether a file says that this program wrote it; one that cannot be read does not."""
    if path.name in RECOGNISED_BY:
        return any(_is_ours(path.with_name(name)) for name in RECOGNISED_BY[path.name])
    try:
        return path.is_file() and is_marked(path.name, path.read_bytes())
    except OSError:
        return False


def marked(name: str, data: bytes) -> bytes:
    """A file that says what wrote it, as far as its kind has a place for that."""
    comment = COMMENTS.get(Path(name).suffix)
    if comment is None or name in RECOGNISED_BY or is_marked(name, data):
        return data
    return data + f"\n{comment.format(WRITTEN_BY)}\n".encode()


def is_marked(name: str, data: bytes) -> bool:
    """Whether a file of some name and content says that this program wrote it."""
    mark = MARKS.get(name) or MARKS.get(Path(name).suffix)
    return mark is not None and mark.search(data) is not None


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
    temporary = path.with_name(f".{path.name}.{os.urandom(4).hex()}")
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
    staging = folder / f"{STAGING}{os.urandom(4).hex()}"
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
