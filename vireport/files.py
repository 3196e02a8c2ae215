"""Files that are whole or are not there."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from pathlib import Path

from vireport.errors import UsageError


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files by their names into a folder, which is made if there are any.

    Raises
    ------
    UsageError
        If it cannot be written to.
    """
    try:
        if files:
            folder.mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            write_whole(folder / name, data)
    except OSError as error:
        raise UsageError(f"{error.filename or folder} cannot be written: {error.strerror}") from error


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
