"""Whatever happens to a run or to its files, the next one ends with the same bytes, or says what is in its way."""

from __future__ import annotations

import errno
import hashlib
import os
import shutil
from collections import namedtuple
from io import BytesIO
from pathlib import Path
from random import Random

import pyarrow.parquet as pq
import pytest
from conftest import first
from map_texts import CHUNKS, TEXT, result, store_in, undisturbed_result, written_map

from vireport.base.errors import OutputError, UsageError
from vireport.map.cells import store as map_store
from vireport.map.cells import workers
from vireport.map.cells.run import run_map
from vireport.map.cells.store import RejectedFileError, chunk_or_bytes, encoded_chunk, is_finished, read_chunk

FINISHED = [".lock", "map.parquet", "map.parquet.sha256"]


class Stop(Exception):
    """Ends a run from within."""


def stopping(after: int, error: BaseException):
    """Progress that raises once so many cells are done."""

    def progress(done: int, total: int) -> None:
        if done >= after:
            raise error

    return progress


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return written_map(tmp_path)


def chunk_files(folder: Path) -> list[Path]:
    return sorted((folder / ".chunks").glob("*.chunk"))


@pytest.fixture
def out(file: Path) -> Path:
    """Folder of a run that was stopped after seven of nine chunks."""
    folder = file.parent / "out"
    with pytest.raises(Stop):
        run_map(str(file), folder, workers=1, progress=stopping(420, Stop()), draw=False)
    assert len(chunk_files(folder)) == 7
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("error", [KeyboardInterrupt(), Stop()], ids=["ctrl-c", "error"])
def test_a_stopped_run_is_resumed(file: Path, error: BaseException, monkeypatch: pytest.MonkeyPatch) -> None:
    out = file.parent / "out"
    monkeypatch.setattr(workers, "WORTH_HELP", 1e-9)
    with pytest.raises(type(error)):
        run_map(str(file), out, workers=2, progress=stopping(120, error), draw=False)
    stored = chunk_files(out)
    assert 2 <= len(stored) < CHUNKS
    seen: list[int] = []
    run_map(str(file), out, workers=1, progress=lambda done, total: seen.append(done), draw=False)
    assert seen[0] == sum(60 if path.stem != "000000008" else 20 for path in stored)
    assert result(out) == undisturbed_result()


def lost(chunks: list[Path]) -> None:
    chunks[1].unlink()


def cut_off(chunks: list[Path]) -> None:
    chunks[1].write_bytes(chunks[1].read_bytes()[:-100])


def empty(chunks: list[Path]) -> None:
    chunks[1].write_bytes(b"")


def flipped_bit(chunks: list[Path]) -> None:
    data = bytearray(chunks[1].read_bytes())
    data[len(data) // 4] ^= 1
    chunks[1].write_bytes(data)


def copied(chunks: list[Path]) -> None:
    shutil.copy(chunks[0], chunks[1])


def of_another_map(chunks: list[Path]) -> None:
    other = store_in(chunks[1].parent, TEXT.replace("restitution: 0.5", "restitution: 0.6"))
    chunks[1].write_bytes(encoded_chunk(other.plan, other.map_sha256, 1))


@pytest.mark.parametrize("damage", first(2, [lost, cut_off, empty, flipped_bit, copied, of_another_map]))
def test_a_chunk_that_is_not_what_it_should_be_is_computed_again(file: Path, out: Path, damage) -> None:
    chunks = chunk_files(out)
    damage(chunks)
    summary = run_map(str(file), out, workers=1, draw=False)
    assert (str(chunks[1]) in summary) == (damage is not lost)
    assert summary.count("computed again") == (damage is not lost)
    assert result(out) == undisturbed_result()


@pytest.mark.parametrize("damage", [lost, flipped_bit])
def test_a_chunk_damaged_during_the_run_is_computed_again(file: Path, out: Path, damage) -> None:
    def progress(done: int, total: int) -> None:
        if done == total:
            damage(chunk_files(out))

    assert "computed again" in run_map(str(file), out, workers=1, progress=progress, draw=False)
    assert result(out) == undisturbed_result()


def flipped(data: bytes, bit: int) -> bytes:
    damaged = bytearray(data)
    damaged[bit // 8] ^= 1 << bit % 8
    return bytes(damaged)


def test_any_flipped_bit_of_a_chunk_is_noticed() -> None:
    store = store_in(Path("nowhere"))
    data = encoded_chunk(store.plan, store.map_sha256, 2)
    assert len(read_chunk(store, 2, data)) == 60
    for bit in Random(1).sample(range(8 * len(data)), 1000):
        with pytest.raises(RejectedFileError, match="is damaged"):
            read_chunk(store, 2, flipped(data, bit))
    earlier = b"PAR1, as chunks once were"
    with pytest.raises(RejectedFileError, match="is of another version"):
        read_chunk(store, 2, hashlib.sha256(earlier).digest() + earlier)


@pytest.mark.slow
@pytest.mark.parametrize("flips", [300, pytest.param(5000, marks=pytest.mark.slow)])
def test_no_flipped_bit_of_a_finished_map_or_of_its_digest_is_accepted(file: Path, flips: int) -> None:
    """Half of the flips are in the description at the end of the file, which no checksum of a page covers."""
    out = file.parent / "out"
    run_map(str(file), out, workers=1, draw=False)
    store, data, digest = store_in(out), result(out), (out / "map.parquet.sha256").read_bytes()
    assert is_finished(store, [])
    description, rng = 8 * (len(data) - 8 - int.from_bytes(data[-8:-4], "little")), Random(flips)
    rejected: list[str] = []
    bits = [rng.randrange(8 * len(data)) for _ in range(flips // 2)]
    bits += [rng.randrange(description, 8 * len(data)) for _ in range(flips // 2)]
    for bit in bits:
        (out / "map.parquet").write_bytes(flipped(data, bit))
        assert not is_finished(store, rejected)
    (out / "map.parquet").write_bytes(data)
    for bit in range(8 * len(digest)):
        (out / "map.parquet.sha256").write_bytes(flipped(digest, bit))
        assert not is_finished(store, rejected)
    assert len(rejected) == flips + 8 * len(digest)
    run_map(str(file), out, workers=1, draw=False)
    assert (result(out), (out / "map.parquet.sha256").read_bytes()) == (data, digest)


def test_what_killed_runs_left_is_removed(file: Path, out: Path) -> None:
    (out / ".chunks" / ".000000003.chunk.abcd").write_bytes(b"half a chunk")
    (out / ".map.parquet.new").write_bytes(b"half a map")
    (out / ".map.parquet.sha256.abcd").write_bytes(b"half a digest")
    (out / ".map-margin.png.abcd").write_bytes(b"half a picture")
    shutil.copy(chunk_files(out)[0], out / ".chunks" / "000000099.chunk")
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed_result()
    assert sorted(path.name for path in out.iterdir()) == FINISHED
    # Killed between the last two steps: the map is there, and its chunks still are.
    (out / ".chunks").mkdir()
    (out / ".chunks" / "000000000.chunk").write_bytes(b"a chunk")
    run_map(str(file), out, workers=1, draw=False)
    assert sorted(path.name for path in out.iterdir()) == FINISHED


def test_a_finished_map_is_verified_and_left_alone(file: Path) -> None:
    out = file.parent / "out"
    run_map(str(file), out, workers=1, draw=False)
    written = (out / "map.parquet").stat().st_mtime_ns
    run_map(str(file), out, workers=1, progress=stopping(0, Stop()), draw=False)
    assert (out / "map.parquet").stat().st_mtime_ns == written
    data = bytearray(undisturbed_result())
    data[len(data) // 3] ^= 16
    (out / "map.parquet").write_bytes(data)
    assert "map.parquet is damaged: computed again" in run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed_result()


def test_digest_of_the_finished_map_is_that_of_sha256sum(file: Path) -> None:
    out = file.parent / "out"
    run_map(str(file), out, workers=1, draw=False)
    listed = f"{hashlib.sha256(result(out)).hexdigest()}  map.parquet\n"
    assert (out / "map.parquet.sha256").read_text(encoding="ascii") == listed


def test_identity_is_in_the_finished_map() -> None:
    file = pq.ParquetFile(BytesIO(undisturbed_result()))
    assert file.read().num_rows == 500
    metadata = file.metadata.metadata
    assert metadata[b"map"].decode() == TEXT
    for key in (b"map_sha256", b"vireport", b"numpy"):
        assert key in metadata[b"vireport"]


@pytest.mark.parametrize("finished", [False, True])
def test_another_map_is_not_mixed_in(file: Path, out: Path, finished: bool) -> None:
    if finished:
        run_map(str(file), out, workers=1, draw=False)
    file.write_text(TEXT.replace("restitution: 0.5", "restitution: 0.6"), encoding="utf-8")
    with pytest.raises(UsageError, match="the map file changed"):
        run_map(str(file), out, workers=1, draw=False)
    file.write_text(TEXT, encoding="utf-8")
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed_result()


def test_another_version_is_not_mixed_in(file: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vireport.map.cells.store.__version__", "99")
    with pytest.raises(UsageError, match="the version of vireport changed"):
        run_map(str(file), out, workers=1, draw=False)


def test_a_file_that_is_no_map_is_not_replaced(file: Path, tmp_path: Path) -> None:
    (tmp_path / "map.parquet").write_text("something else", encoding="utf-8")
    with pytest.raises(UsageError, match="is no map"):
        run_map(str(file), tmp_path, workers=1, draw=False)
    assert (tmp_path / "map.parquet").read_text(encoding="utf-8") == "something else"


@pytest.mark.parametrize("place", ["map.parquet", ".lock", ".chunks/000000001.chunk", ".chunks"])
@pytest.mark.parametrize("kind", ["folder", "FIFO", "link"])
def test_only_files_are_used(file: Path, tmp_path: Path, place: str, kind: str) -> None:
    path = tmp_path / "out" / place
    path.parent.mkdir(parents=True)
    if kind == "folder":
        path = path.with_name("map.parquet") if place == ".chunks" else path
        path.mkdir()
    elif kind == "FIFO":
        os.mkfifo(path)
    else:
        path.symlink_to(file)
    with pytest.raises(UsageError, match=f"{path.name}: is a {kind}, where"):
        run_map(str(file), tmp_path / "out", workers=1, draw=False)


@pytest.mark.slow
def test_two_runs_do_not_share_a_folder(file: Path) -> None:
    def progress(done: int, total: int) -> None:
        with pytest.raises(UsageError, match="out: another run"):
            run_map(str(file), file.parent / "out", workers=1, draw=False)
        raise Stop

    with pytest.raises(Stop):
        run_map(str(file), file.parent / "out", workers=1, progress=progress, draw=False)


def test_a_map_that_does_not_fit_on_the_disk_is_refused_beforehand(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = file.parent / "out"
    usage = namedtuple("usage", "total used free")
    needed = 0.8 * 2 * 500 * 18 * 8
    with monkeypatch.context() as patch:
        patch.setattr(shutil, "disk_usage", lambda path: usage(1e9, 1e9, needed))
        with pytest.raises(UsageError, match="the map needs about"):
            run_map(str(file), out, workers=1, progress=stopping(1, Stop()), draw=False)
        patch.setattr(shutil, "disk_usage", lambda path: usage(1e9, 1e9, 1.3 * needed))
        run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed_result()


@pytest.mark.parametrize("failing", first(1, [1, 3, CHUNKS, CHUNKS + 1]))
def test_a_full_disk_is_told_and_the_run_resumed(file: Path, monkeypatch: pytest.MonkeyPatch, failing: int) -> None:
    """Each chunk is renamed once it is written, then the digest of the whole map, and the map last."""
    out, rename, calls = file.parent / "out", os.replace, []

    def replace(source, target) -> None:
        calls.append(target)
        if len(calls) > failing:
            raise OSError(errno.ENOSPC, "No space left on device")
        rename(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", replace)
        with pytest.raises(OutputError, match=r"No space left.*run the same command again"):
            run_map(str(file), out, workers=1, draw=False)
    assert len(chunk_files(out)) == min(failing, CHUNKS)
    assert not (out / "map.parquet").exists()
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed_result()


def test_a_worker_stores_a_chunk_where_it_sees_the_folder_and_otherwise_sends_it(tmp_path: Path) -> None:
    store = store_in(tmp_path)
    store.chunks.mkdir()
    sent = chunk_or_bytes(store, "mark", 2)
    assert sent == encoded_chunk(store.plan, store.map_sha256, 2)
    assert not chunk_files(tmp_path)
    (store.chunks / "mark").touch()
    assert chunk_or_bytes(store, "mark", 2) is None
    assert store.chunk(2).read_bytes() == sent
    store.chunk(3).mkdir()  # no file can be put there
    assert chunk_or_bytes(store, "mark", 3) == encoded_chunk(store.plan, store.map_sha256, 3)


def test_a_chunk_is_the_same_however_many_cells_are_evaluated_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    store = store_in(Path("map"))
    whole = encoded_chunk(store.plan, store.map_sha256, 1)
    monkeypatch.setattr(map_store, "PART", 7)
    assert encoded_chunk(store.plan, store.map_sha256, 1) == whole
