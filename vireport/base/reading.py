"""Reads files that a scenario names, which may be of somebody else: whole ones of a bounded size, below a folder.

What is no file, such as a pipe or a device, is refused before it is opened: some never end, and some act on being read.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from msgspec import Struct

from vireport.base.errors import UsageError

FLAGS = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_BINARY", "O_CLOEXEC", "O_NONBLOCK", "O_NOCTTY"))
"""With which a file is opened, so that one that was exchanged for a pipe in between is not waited for."""

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


class ReadingPlace(Struct, frozen=True):
    """Where files are looked for by their paths.

    Attributes
    ----------
    folder : str
        From which a relative path leads.
    outside : bool
        Whether a path may lead out of the folder: by itself, by ``..`` or by a symbolic link.
    """

    folder: str = "."
    outside: bool = False

    def path_of(self, name: str) -> str:
        """Path of a file as it is shown, which need not be there."""
        return os.path.join(self.folder, name) if self.folder != "." else name

    def path_from(self, folder: str, name: str) -> str:
        """Path by which a scenario in another folder has the same file; an absolute one stays as it is.

        Raises
        ------
        UsageError
            If the file is outside of this folder.
        """
        if not self.outside:
            self._below(name)
        base, target = os.path.realpath(self.folder), os.path.realpath(folder)
        if os.path.isabs(name) or base == target:
            return name
        # The file itself may be a link: what stands beside the link belongs to it.
        path, file = os.path.split(os.path.join(base, name))
        return os.path.join(os.path.relpath(os.path.realpath(path), target), file)

    def read(self, name: str, largest: int) -> bytes:
        """Read a file that belongs to the scenario, as bytes.

        Parameters
        ----------
        name : str
            Its path.
        largest : int
            Bytes that it may have.

        Raises
        ------
        UsageError
            If it is outside of the folder, no file, larger than allowed, or cannot be read.
        """
        visible_path = self.path_of(name)
        try:
            path = self.path_of(name) if self.outside else self._below(name)
            _require_file(visible_path, os.stat(path).st_mode)
            descriptor = os.open(path, FLAGS | (0 if self.outside else getattr(os, "O_NOFOLLOW", 0)))
            with open(descriptor, "rb") as file:
                status = os.fstat(descriptor)
                _require_file(visible_path, status.st_mode)
                if status.st_size > largest:
                    raise UsageError(f"{visible_path}: the file is larger than {_size(largest)} (cut the record)")
                data = file.read(status.st_size + 1)
        except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise UsageError(f"{visible_path} cannot be read: {reason}") from error
        if len(data) != status.st_size:
            raise UsageError(f"{visible_path} changes while it is read (allowed: a file that is complete)")
        return data

    def _below(self, name: str) -> str:
        """The file that a path leads to, all links followed, so that none is followed on opening it."""
        root, path = os.path.realpath(self.folder), os.path.realpath(os.path.join(self.folder, name))
        if not Path(path).is_relative_to(root):
            raise UsageError(
                f"{name}: leads out of the folder of the scenario (allowed: files in it and below, so copy it "
                "there; or --allow-outside, where you trust the scenario)"
            )
        return path


ANYWHERE = ReadingPlace(outside=True)
"""For paths that the caller of the program gives."""


def _require_file(path: str, mode: int) -> None:
    if not stat.S_ISREG(mode):
        what = KINDS.get(stat.S_IFMT(mode), "no file")
        raise UsageError(f"{path} is {what} (allowed: a file)")


def _size(count: int) -> str:
    return f"{count // 10**9} GB" if count >= 10**9 else f"{count // 10**6} MB"
