"""Files that a scenario names: whole ones of a bounded size in its folder and below, and nothing of what is outside."""

from __future__ import annotations

import os
import re
import socket
from pathlib import Path

import pytest

from vireport.base.errors import UsageError
from vireport.base.reading import ANYWHERE, ReadingPlace

SECRET = "root:secret"


@pytest.fixture
def place(tmp_path: Path) -> ReadingPlace:
    """A folder with a file in it and one below, beside another whose name begins alike."""
    for name in ("in/a", "in/deep/b", "inside/secret"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(SECRET)
    return ReadingPlace(str(tmp_path / "in"))


def refused(place: ReadingPlace, name: str, largest: int = 1000) -> str:
    with pytest.raises(UsageError) as error:
        place.read(name, largest)
    (line,) = error.value.lines
    assert SECRET not in line
    return line


def test_files_in_a_folder_and_below_are_read(place: ReadingPlace, tmp_path: Path) -> None:
    os.symlink("deep/b", tmp_path / "in/link")
    os.symlink("in", tmp_path / "the folder")
    linked = ReadingPlace(str(tmp_path / "the folder"))
    for name in ("a", "deep/b", "deep/../a", "link", str(tmp_path / "in/a")):
        assert place.read(name, 100) == linked.read(name, 100) == SECRET.encode(), name


OUT = "leads out of the folder of the scenario (allowed: files in it and below, so copy it there; or --allow-outside"


@pytest.mark.parametrize(
    "name", ["../inside/secret", "deep/../../inside/secret", "ABSOLUTE", "link", "links/secret", "x"]
)
def test_what_leads_out_is_refused_unless_it_is_allowed(place: ReadingPlace, tmp_path: Path, name: str) -> None:
    """By itself, by what is above, by a link to a file or to a folder, or by a link to a link."""
    secret = tmp_path / "inside/secret"
    os.symlink(secret, tmp_path / "in/link")
    os.symlink("../inside", tmp_path / "in/links")
    os.symlink("link", tmp_path / "in/x")
    path = str(secret) if name == "ABSOLUTE" else name
    assert refused(place, path).startswith(f"{path}: {OUT}")
    assert ReadingPlace(place.folder, outside=True).read(path, 100) == SECRET.encode()


def test_of_what_is_outside_nothing_is_told(place: ReadingPlace) -> None:
    """Neither whether it is there, nor what it is."""
    told = {refused(place, name).partition(": ")[2] for name in ("../no such", "/etc", "/etc/hostname", "/dev/zero")}
    assert len(told) == 1


@pytest.mark.parametrize(
    ("name", "what"),
    [("pipe", "a pipe"), ("deep", "a folder"), (".", "a folder"), ("socket", "a socket"), ("/dev/zero", "a device")],
)
def test_what_is_no_file_is_refused_and_not_waited_for(monkeypatch, tmp_path: Path, name: str, what: str) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("deep").mkdir()
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        assert refused(ANYWHERE, name) == f"{name} is {what} (allowed: a file)"
    os.symlink("pipe", "link")
    assert refused(ReadingPlace(), "link") == "link is a pipe (allowed: a file)"


def test_a_file_is_read_whole_or_refused_by_its_size(place: ReadingPlace, tmp_path: Path) -> None:
    with (tmp_path / "in/giant").open("wb") as file:
        file.truncate(1 << 40)
    assert re.fullmatch(
        r".*/in/giant: the file is larger than 50 MB \(cut the record\)", refused(place, "giant", 50_000_000)
    )
    assert place.read("a", len(SECRET)) == SECRET.encode()
    refused(place, "a", len(SECRET) - 1)


@pytest.mark.skipif(not Path("/proc/self/maps").is_file(), reason="the system has no such files")
def test_a_file_that_says_no_size_is_refused() -> None:
    assert (
        refused(ANYWHERE, "/proc/self/maps")
        == "/proc/self/maps changes while it is read (allowed: a file that is complete)"
    )


def test_names_that_are_none_are_refused(place: ReadingPlace) -> None:
    assert "cannot be read: " in refused(place, "a\0b")
    assert "cannot be read: No such file" in refused(place, "no such")
    assert "cannot be read: " in refused(place, "x" * 5000)
    os.symlink("round", Path(place.folder) / "round")
    assert "cannot be read: " in refused(place, "round")
