"""Raw signals from files: what is read, and what, where and what is allowed of each mistake."""

from __future__ import annotations

import os
import re
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

from vireport.base.errors import UsageError, VireportError
from vireport.measurement.recordings import HeardPlace, Recording, read_recording

HEAD = "time_s,bottom_voltage_v,top_voltage_v"
ROWS = [f"{k / 1000},{k % 7},{-(k % 5)}" for k in range(100)]


def rows(change: int = -1, to: str = "", head: str = HEAD) -> str:
    own = list(ROWS)
    if change >= 0:
        own[change] = to
    return "\n".join([head, *own]) + "\n"


def read(tmp_path: Path, data: bytes, name: str = "x.csv") -> Recording:
    (tmp_path / name).write_bytes(data)
    return read_recording(str(tmp_path / name))


@pytest.mark.parametrize(
    "data",
    [
        rows().encode(),
        b"\xef\xbb\xbf" + rows().encode(),
        rows().replace("\n", "\r\n").encode(),
        rows().replace("\n", "\r").encode(),
        rows(head='"time_s", "bottom_voltage_v","top_voltage_v"').encode(),
    ],
)
def test_columns_are_read_by_their_names(tmp_path: Path, data: bytes) -> None:
    own = read(tmp_path, data)
    assert own.step_s == pytest.approx(1e-3)
    assert [channel.place for channel in own.channels] == [HeardPlace.BOTTOM, HeardPlace.TOP]
    np.testing.assert_array_equal(own.channels[0].values, np.arange(100) % 7)


def test_units_are_those_of_the_names(tmp_path: Path) -> None:
    lines = ["time_ms,unused_temperature,voltage_mv,acceleration_g"]
    lines += [f"{k},{20 + k},{k % 3},{k % 2}" for k in range(100)]
    own = read(tmp_path, "\n".join(lines).encode())
    assert own.step_s == pytest.approx(1e-3)
    voltage, acceleration = own.channels
    assert voltage.values.max() == pytest.approx(2e-3)
    assert acceleration.values.max() == pytest.approx(9.80665)


def test_a_gap_is_kept_and_times_that_were_rounded_are_put_on_a_clock(tmp_path: Path) -> None:
    times = [k / 2400 for k in range(300) if not 100 <= k < 150]
    lines = [HEAD, *(f"{time:.4f},{k % 7},1" for k, time in enumerate(times))]
    own = read(tmp_path, "\n".join(lines).encode())
    assert [(x.first, x.last) for x in own.stretches] == [(0, 100), (100, 250)]
    assert own.step_s == pytest.approx(1 / 2400, rel=1e-3)
    assert own.stretches[1].start_s == pytest.approx(150 / 2400, abs=5e-5)
    assert 0 < own.uneven_s < 1e-4


@pytest.mark.parametrize("power", [1.3, 2.0])
def test_times_at_unequal_steps_are_used_as_they_are(tmp_path: Path, power: float) -> None:
    times = (np.arange(300) / 300) ** power + 1e-3
    times[200:] += 1.0
    own = read(tmp_path, "\n".join([HEAD, *(f"{time},1,{k % 2}" for k, time in enumerate(times.tolist()))]).encode())
    assert not own.even
    assert [(part.first, part.last) for part in own.stretches] == [(0, 200), (200, 300)]
    np.testing.assert_array_equal(own.times, times)
    assert own.end_s == times[-1]
    assert own.step_s == pytest.approx(float(np.median(np.diff(times))))
    (before, after) = own.stretches
    assert own.row_of(after, float(times[250])) == pytest.approx(250)
    assert own.times_of(before, np.array([7.5]))[0] == pytest.approx((times[7] + times[8]) / 2)


MISTAKES = {
    "empty": ("", "x.csv:1: the file is empty (allowed: names and units"),
    "names alone": (f"{HEAD}\n", "x.csv:1: no lines of numbers were found in it (allowed: text"),
    "no names": ("\n".join(ROWS), "no column is named as a signal with its unit"),
    "names of an instrument": (
        rows(head='"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)"'),
        "x.csv: no column is named as a signal with its unit (allowed: names such as time_s,bottom_voltage_v,"
        "top_voltage_v,acceleration_m_s2; vireport identify --inspect FILE shows what is in it",
    ),
    "numbers without a name": (
        f"{HEAD}\n" + "".join(f"{row},1\n" for row in ROWS),
        "x.csv:1: column 4 has no name (allowed",
    ),
    "endless first line": ("a," * 100_000 + "\n0,1\n", "x.csv:1: a line of more than 100000 bytes (allowed: a sample"),
    "endless row": (f"{HEAD}\n0,1,2\n" + "1," * 100_000, "x.csv:3: a line of more than 100000 bytes"),
    "no unit": (rows(head="time_s,bottom_voltage,top_voltage_v"), "bottom_voltage: the name has no unit; did you mean"),
    "no unit of time": (rows(head="time,bottom_voltage_v,top_voltage_v"), "time: the name"),
    "other unit": (rows(head="time_s,bottom_voltage_psi,top_voltage_v"), "bottom_voltage_psi: the name is no signal"),
    "misspelt": (rows(head="time_s,botom_voltage_v,top_voltage_v"), "did you mean 'bottom_voltage_v'?"),
    "twice": (rows(head="time_s,top_voltage_v,top_voltage_v"), "top_voltage_v: stands twice (each once)"),
    "two of a kind": (rows(head="time_s,top_voltage_v,top_sound_pa"), "two signals are of the same kind, top"),
    "no time": (rows(head="voltage_v,unused_1,unused_2"), "it has no times (allowed: a column of times, as in"),
    "two times": (rows(head="time_s,time_ms,voltage_v"), "two columns have times (allowed: one"),
    "one membrane": (rows(head="time_s,bottom_voltage_v,unused"), "impacts on both membranes are needed"),
    "both ways": (rows(head="time_s,bottom_voltage_v,voltage_v"), "impacts on both membranes are needed"),
    "nothing": (rows(head="time_s,unused_1,unused_2"), "impacts on both membranes are needed"),
    "decimal comma": (rows(7, "0,007,1,2"), "x.csv:9: 4 values for 3 columns. A decimal comma?"),
    "too few": (rows(7, "0.007,1"), "x.csv:9: 2 values for 3 columns."),
    "text": (rows(7, "0.007,high,2"), "x.csv:9: bottom_voltage_v: 'high' is not a finite number"),
    "no voltage": (
        rows(7, "0.007,1,1e13"),
        "x.csv:9: top_voltage_v: '1e13' is no measured value (allowed: at most 1e+12",
    ),
    "grouped digits": (rows(7, "0.007,1_0,2"), "x.csv:9: bottom_voltage_v: '1_0' is not a finite number"),
    "unsorted": (rows(7, "0.001,1,2"), "x.csv:9: time_s: '0.001' is not after the time before it"),
    "no clock": (
        "\n".join([HEAD, *(f"{k}e-300,1,{k % 2}" for k in range(100))]),
        "time: samples are 1e-300 s apart (allowed: 1e-09 to 1e+06 s)",
    ),
    "short": ("\n".join([HEAD, *ROWS[:20]]), "20 samples (at least 64 are needed"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_with_what_is_allowed(tmp_path: Path, name: str) -> None:
    text, message = MISTAKES[name]
    with pytest.raises(VireportError, match=re.escape(message)) as refused:
        read(tmp_path, text.encode())
    assert refused.value.exit_code == 2
    assert all("(" in line for line in refused.value.lines)


def test_bytes_that_are_no_text_and_files_of_other_kinds_are_refused(tmp_path: Path) -> None:
    with pytest.raises(VireportError, match=r"no lines of numbers were found in it \(allowed: text with lines"):
        read(tmp_path, b"time_s,\xe9\n")
    with pytest.raises(VireportError, match=r"x.csv:2: a zero byte: this is no text \(allowed: text with lines"):
        read(tmp_path, b"time_s,voltage_v\n0\0,1\n")
    with pytest.raises(UsageError, match=r"x.csv is FLAC, which is not read \(convert it: ffmpeg -i .*x.csv .*\.wav\)"):
        read(tmp_path, b"fLaC\0\0\0")
    with pytest.raises(UsageError, match="cannot be read: No such file"):
        read_recording("/nowhere.csv")


SAMPLES = np.stack([np.arange(200) % 50, -(np.arange(200) % 30)], axis=1)
NOTES = "channels:\n  bottom_sound_fs: 1\n  top_sound_pa: -20\n"
BOMB = "channels:\n  voltage_v:\n    - &a0 [x, x, x, x]\n" + "".join(
    f"    - &a{k} [*a{k - 1}, *a{k - 1}, *a{k - 1}, *a{k - 1}]\n" for k in range(1, 9)
)
"""Notes of 400 bytes that stand for a million values."""


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32])
def test_a_wav_file_is_read_with_its_notes(tmp_path: Path, kind: Any) -> None:
    whole = {np.uint8: 128.0, np.int16: 32768.0, np.int32: 2.0**31, np.float32: 1.0}[kind]
    values = SAMPLES / 100 * whole + (128 if kind is np.uint8 else 0)
    wavfile.write(tmp_path / "x.wav", 8000, np.round(values).astype(kind) if whole > 1 else values.astype(kind))
    (tmp_path / "x.wav.yaml").write_text(NOTES)
    own = read_recording(str(tmp_path / "x.wav"))
    assert own.step_s == 1 / 8000
    np.testing.assert_allclose(own.channels[0].values, SAMPLES[:, 0] / 100, atol=0.005)
    np.testing.assert_allclose(own.channels[1].values, -20 * SAMPLES[:, 1] / 100, atol=0.1)


@pytest.mark.parametrize(
    ("notes", "message"),
    [
        (None, "x.wav.yaml is missing (allowed there: channels:"),
        ("[", "x.wav.yaml:1: a value is missing"),
        ("", "x.wav.yaml:1: has no channels (allowed"),
        (
            "channels: {bottom_sound_fs: 1, top_sound_fs: 1:30}",
            "x.wav.yaml:1: channels.top_sound_fs: got '1:30' (allowed",
        ),
        (f"{NOTES}  top_sound_pa: 2\n", "x.wav.yaml:4: channels.top_sound_pa: given twice, first on line 3"),
        (
            "channels:\n  bottom_sound_fs: !!int ''\n",
            "x.wav.yaml:2: channels.bottom_sound_fs: tags are not read, got '!!int'",
        ),
        (f"channels:\n  voltage_v: {'9' * 400}\n", "x.wav.yaml:2: channels.voltage_v: got 999"),
        (f"channels: {'[' * 5000}", "x.wav.yaml:1: channels.0.0: nested more than 20 levels deep"),
        (BOMB, "x.wav.yaml:3: channels.voltage_v.0: anchors are not read, got &a0 (delete it)"),
        ("#" * 1_000_001, "x.wav.yaml: the file is larger than 1 MB"),
        ("a: 1", "has no channels (allowed"),
        ("channels: {}", "has no channels (allowed"),
        (
            "channels: {bottom_sound_fs: 1, top_sound_fs: loud}",
            "channels.top_sound_fs: got 'loud' (allowed: full scale",
        ),
        ("channels: {bottom_sound_fs: 1, top_sound_fs: 0}", "got 0 (allowed"),
        ("channels: {bottom_sound_fs: 1, top_sound: 1}", "top_sound: the name has no unit"),
        ("channels: {sound_fs: 1}", "names 1 channels, and the file has 2 (allowed: all"),
        ("channels: {sound_fs: 1, time_s: 1}", "a WAV file has no channel of times"),
    ],
)
def test_notes_that_do_not_fit_are_refused(tmp_path: Path, notes: str | None, message: str) -> None:
    wavfile.write(tmp_path / "x.wav", 8000, SAMPLES.astype(np.int16))
    if notes is not None:
        (tmp_path / "x.wav.yaml").write_text(notes)
    with pytest.raises(VireportError, match=re.escape(message)) as refused:
        read_recording(str(tmp_path / "x.wav"))
    assert len(refused.value.lines) == 1


@pytest.mark.parametrize(("written", "full"), [("050", 50.0), ("5.12e1", 51.2), ("0o12", 10.0), ("-.5", -0.5)])
def test_numbers_of_notes_are_those_of_a_scenario(tmp_path: Path, written: str, full: float) -> None:
    wavfile.write(tmp_path / "x.wav", 8000, (100 * SAMPLES[:, 0]).astype(np.int16))
    (tmp_path / "x.wav.yaml").write_text(f"channels:\n  acceleration_m_s2: {written}\n")
    (own,) = read_recording(str(tmp_path / "x.wav")).channels
    np.testing.assert_allclose(own.values, full * 100 * SAMPLES[:, 0] / 32768, rtol=1e-12)


def wav(samples: bytes, rate: int = 8000, claimed: int | None = None, block: int = 4, head: bytes = b"RIFF") -> bytes:
    """A file of 16 bits and two channels with what its header says."""
    order = ">" if head == b"RIFX" else "<"
    size = len(samples) if claimed is None else claimed
    form = struct.pack(f"{order}IHHIIHH", 16, 1, 2, rate, rate * block, block, 16)
    whole = struct.pack(f"{order}I", min(36 + size, 0xFFFFFFFF))
    return head + whole + b"WAVEfmt " + form + b"data" + struct.pack(f"{order}I", size) + samples


WAV = SAMPLES.astype("<i2").tobytes()


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            wav(b""),
            "x.wav: its header says 0 bytes of samples, 4 for each, and 0 follow (allowed: a file whose recording",
        ),
        (wav(WAV, claimed=0), "x.wav: its header says 0 bytes of samples, 4 for each, and 800 follow"),
        (wav(WAV, claimed=0xFFFFFFFF), "x.wav: its header says 4294967295 bytes of samples"),
        (wav(WAV[:-2], claimed=800), "x.wav: its header says 800 bytes of samples, 4 for each, and 798 follow"),
        (wav(WAV[:-2]), "x.wav: its header says 798 bytes of samples, 4 for each"),
        (wav(WAV, rate=0), "x.wav: its header says 2 channels, 0 samples in a second and 4 bytes for each"),
        (wav(WAV, block=0), "x.wav: its header says 2 channels, 8000 samples in a second and 0 bytes for each"),
        (wav(WAV, block=3), "x.wav: its header says 2 channels, 8000 samples in a second and 3 bytes for each"),
        (wav(WAV)[:40], "x.wav cannot be read as WAV: it has no samples"),
        (wav(WAV)[:12] + wav(WAV)[36:], "x.wav cannot be read as WAV: its header does not say the format"),
    ],
)
def test_a_wav_file_whose_header_does_not_fit_is_refused(tmp_path: Path, data: bytes, message: str) -> None:
    (tmp_path / "x.wav.yaml").write_text(NOTES)
    with pytest.raises(UsageError, match=re.escape(message)) as refused:
        read(tmp_path, data, "x.wav")
    assert len(refused.value.lines) == 1


def test_a_wav_file_of_the_other_order_and_with_odd_chunks_is_read(tmp_path: Path) -> None:
    (tmp_path / "x.wav.yaml").write_text(NOTES)
    turned = wav(SAMPLES.astype(">i2").tobytes(), head=b"RIFX")
    noted = wav(WAV)[:12] + b"LIST\x03\0\0\0abc\0" + wav(WAV)[12:]
    for data in (turned, noted):
        own = read(tmp_path, data, "x.wav")
        np.testing.assert_array_equal(own.channels[1].values, -20 * SAMPLES[:, 1] / 32768)


def test_a_file_that_is_no_wav_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.wav.yaml").write_text(NOTES)
    with pytest.raises(UsageError, match="cannot be read as WAV"):
        read(tmp_path, b"RIFF\0\0\0\0WAVEfmt ", "x.wav")


TIMES = np.arange(100) / 1000
VECTORS = {"bottom_voltage_v": TIMES, "top_voltage_v": -TIMES}


def test_a_matlab_file_is_read_with_times_or_a_rate(tmp_path: Path) -> None:
    for clock in ({"time_s": TIMES}, {"sampling_rate_hz": 1000}):
        savemat(tmp_path / "x.mat", VECTORS | clock | {"unused_notes": "text"})
        own = read_recording(str(tmp_path / "x.mat"))
        assert own.step_s == pytest.approx(1e-3)
        np.testing.assert_array_equal(own.channels[1].values, -TIMES)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (VECTORS, "it has no times (allowed: a column of times"),
        (
            VECTORS | {"time_s": TIMES, "sampling_rate_hz": 1},
            "its times are 1 ms apart, and its head says 1 s (allowed",
        ),
        (VECTORS | {"sampling_rate_hz": -1}, "sampling_rate_hz: is no positive number"),
        (VECTORS | {"sampling_rate_hz": "fast"}, "sampling_rate_hz: is no positive number"),
        (VECTORS | {"time_s": TIMES[1:]}, "vectors of 99 to 100 samples (allowed: all of one length)"),
        ({"voltage_v": np.ones((10, 10)), "sampling_rate_hz": 1}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": TIMES * 1j, "sampling_rate_hz": 1}, "voltage_v: is no vector of real numbers"),
        ({"voltage": TIMES, "sampling_rate_hz": 1}, "voltage: the name has no unit"),
    ],
)
def test_variables_that_do_not_fit_are_refused(tmp_path: Path, content: dict[str, Any], message: str) -> None:
    savemat(tmp_path / "x.mat", content)
    with pytest.raises(VireportError, match=re.escape(message)):
        read_recording(str(tmp_path / "x.mat"))


def test_matlab_files_that_are_none_are_refused(tmp_path: Path) -> None:
    newer = NEWER + b"\x89HDF\r\n\x1a\n" + bytes(100)
    for data in (b"MATLAB", NEWER[:200], newer):
        with pytest.raises(UsageError, match=r"cannot be read as a MATLAB file|no variables"):
            read(tmp_path, data, "x.mat")


NEWER = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + bytes(384)
"""What a file of version 7.3 begins with, before the HDF5."""


def write_newer(path: Path, content: dict[str, Any]) -> None:
    """A file as MATLAB writes it: arrays transposed, their class beside them, text as numbers of its characters."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_group("#refs#")
        for title, own in content.items():
            if isinstance(own, str):
                stored = file.create_dataset(title, data=np.array([[ord(c)] for c in own], dtype=np.uint16))
                stored.attrs["MATLAB_class"] = np.bytes_("char")
                stored.attrs["MATLAB_int_decode"] = np.int32(2)
            elif isinstance(own, dict):
                stored = file.create_group(title)
                stored.attrs["MATLAB_class"] = np.bytes_("struct")
            elif not np.size(own):
                stored = file.create_dataset(title, data=np.array([0, 0], dtype=np.uint64))
                stored.attrs["MATLAB_class"] = np.bytes_("double")
                stored.attrs["MATLAB_empty"] = np.uint8(1)
            elif isinstance(own, h5py.ExternalLink | h5py.SoftLink):
                file[title] = own
            else:
                values = np.atleast_2d(np.asarray(own))
                if np.iscomplexobj(values):
                    pairs = np.empty(values.shape, dtype=[("real", "<f8"), ("imag", "<f8")])
                    pairs["real"], pairs["imag"] = values.real, values.imag
                    values = pairs
                stored = file.create_dataset(title, data=values.T)
                names = {"float64": "double", "float32": "single", "bool": "logical"}
                kind = "double" if np.iscomplexobj(own) else names.get(str(values.dtype), str(values.dtype))
                if kind != "uint64":  # that is taken for a file of HDF5 that is not MATLAB's
                    stored.attrs["MATLAB_class"] = np.bytes_(kind)
    with path.open("r+b") as file:
        file.write(NEWER)


@pytest.mark.parametrize("kind", ["float64", "float32", "int16"])
def test_a_matlab_file_of_version_7_3_is_read_as_an_older_one_is(tmp_path: Path, kind: str) -> None:
    heard = np.round(1000 * np.sin(np.arange(100))).astype(kind)
    for clock in ({"time_s": TIMES}, {"sampling_rate_hz": 1000.0}):
        content = {"bottom_voltage_mv": heard, "top_voltage_v": -TIMES[:, None]} | clock | {"unused_notes": "text"}
        savemat(tmp_path / "old.mat", content)
        write_newer(tmp_path / "new.mat", content)
        old, new = (read_recording(str(tmp_path / f"{name}.mat")) for name in ("old", "new"))
        assert new.step_s == old.step_s == pytest.approx(1e-3)
        assert {own.name for own in new.channels} == {"bottom_voltage_mv", "top_voltage_v"}
        of_old = {own.name: own for own in old.channels}
        for own in new.channels:
            np.testing.assert_array_equal(own.values, of_old[own.name].values)
            assert own.place is of_old[own.name].place


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (VECTORS, "it has no times (allowed: a column of times"),
        (VECTORS | {"sampling_rate_hz": -1.0}, "sampling_rate_hz: is no positive number"),
        (VECTORS | {"sampling_rate_hz": "fast"}, "sampling_rate_hz: is no positive number"),
        (VECTORS | {"time_s": TIMES[1:]}, "vectors of 99 to 100 samples (allowed: all of one length)"),
        ({"voltage_v": np.ones((10, 10)), "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": TIMES * 1j, "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": "x" * 100, "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": TIMES > 0, "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": {}, "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": [], "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        ({"voltage_v": np.ones(100, "uint64"), "sampling_rate_hz": 1.0}, "voltage_v: is no vector of real numbers"),
        (
            {"voltage_v": h5py.ExternalLink("other.mat", "voltage_v"), "sampling_rate_hz": 1.0},
            "voltage_v: is a link (allowed: the vector itself, in this file)",
        ),
        ({"voltage_v": h5py.SoftLink("/time_s"), "sampling_rate_hz": 1.0}, "voltage_v: is a link (allowed"),
        (
            {"voltage_v": np.where(TIMES > 0.05, np.nan, 1.0), "sampling_rate_hz": 1.0},
            "51 samples of 100 that are numbers (at least 64 are needed",
        ),
        ({"voltage": TIMES, "sampling_rate_hz": 1.0}, "voltage: the name has no unit"),
        ({}, "the file has no variables"),
    ],
)
def test_variables_of_version_7_3_that_do_not_fit_are_refused(
    tmp_path: Path, content: dict[str, Any], message: str
) -> None:
    write_newer(tmp_path / "x.mat", content)
    with pytest.raises(VireportError, match=re.escape(message)):
        read_recording(str(tmp_path / "x.mat"))


def test_without_the_package_a_file_of_version_7_3_names_the_command(tmp_path: Path, monkeypatch) -> None:
    write_newer(tmp_path / "x.mat", VECTORS | {"sampling_rate_hz": 1000.0})
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(UsageError, match=r"needs h5py to be read: pip install 'vireport\[recordings\]'"):
        read_recording(str(tmp_path / "x.mat"))


def stored(path: Path, make: Callable[[h5py.File], Any]) -> Path:
    """A file of version 7.3 with a signal that is made in some way."""
    write_newer(path, {"sampling_rate_hz": 1000.0})
    with h5py.File(path, "r+") as file:
        make(file).attrs["MATLAB_class"] = np.bytes_("double")
    return path


def virtual(file: h5py.File) -> Any:
    layout = h5py.VirtualLayout(shape=(1, 100), dtype="f8")
    layout[:] = h5py.VirtualSource("/etc/hostname", "x", shape=(1, 100))
    return file.create_virtual_dataset("voltage_v", layout)


NAME, GIANT, KILO = "voltage_v", (1, 200_000_000), (1, 1000)
"""A signal, and how many samples it says that it has: 1.6 GB of them."""

ELSEWHERE: dict[str, tuple[Callable[[h5py.File], Any], str]] = {
    "in any file": (
        lambda file: file.create_dataset(NAME, (1, 100), "f8", external=[("/etc/passwd", 0, 800)]),
        "voltage_v: its numbers are in other files (allowed: in this one)",
    ),
    "in a pipe": (
        lambda file: file.create_dataset(NAME, (1, 100), "f8", external=[("pipe", 0, 800)]),
        "voltage_v: its numbers are in other files",
    ),
    "virtual": (virtual, "voltage_v: its numbers are in other files"),
    "nowhere": (lambda file: file.create_dataset(NAME, GIANT, "f8"), "voltage_v: samples of it were never written"),
    "nowhere, packed": (
        lambda file: file.create_dataset(NAME, GIANT, "f8", chunks=KILO, compression="gzip"),
        "it unfolds to more than signals that were recorded (allowed: up to 100 times its size, or 100 MB)",
    ),
    "nowhere, few": (lambda file: file.create_dataset(NAME, (1, 9000), "f8", chunks=KILO), "samples of it were never"),
    "in one giant chunk": (
        lambda file: file.create_dataset(NAME, (1, 100), "f8", chunks=GIANT, maxshape=(1, None)),
        "it unfolds to more than signals",
    ),
    "packed otherwise": (
        lambda file: file.create_dataset(NAME, data=np.ones((1, 9000)), chunks=KILO, compression="lzf"),
        "voltage_v: is packed in a way that MATLAB does not know",
    ),
}
"""Signals that are not in a file, though it is small, by what makes them."""


@pytest.mark.parametrize("name", ELSEWHERE)
def test_what_is_not_in_a_file_is_refused_before_it_is_read(tmp_path: Path, monkeypatch, name: str) -> None:
    """Reading the pipe would wait for ever, and the giants would be taken for zeros."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    make, message = ELSEWHERE[name]
    path = stored(tmp_path / "x.mat", make)
    assert path.stat().st_size < 100_000
    with pytest.raises(UsageError, match=re.escape(message)) as refused:
        read_recording(str(path))
    assert len(refused.value.lines) == 1


@pytest.mark.parametrize("how", [{}, {"compression": "gzip"}, {"compression": 9, "shuffle": True, "fletcher32": True}])
def test_vectors_in_chunks_are_read(tmp_path: Path, how: dict[str, Any]) -> None:
    values = np.round(np.random.default_rng(1).standard_normal((1, 2500)), 3)
    path = stored(
        tmp_path / "x.mat", lambda file: file.create_dataset("acceleration_g", data=values, chunks=KILO, **how)
    )
    np.testing.assert_array_equal(read_recording(str(path)).channels[0].values, 9.80665 * values[0])


def test_a_chunk_that_unfolds_to_more_than_it_is_is_refused(tmp_path: Path) -> None:
    def make(file: h5py.File) -> Any:
        own = file.create_dataset(NAME, (1, 1000), "f8", chunks=KILO, compression="gzip")
        own.id.write_direct_chunk((0, 0), zlib.compress(bytes(10_000_000)))
        return own

    with pytest.raises(UsageError, match="it unfolds to more than signals"):
        read_recording(str(stored(tmp_path / "x.mat", make)))


@pytest.mark.slow
def test_a_packed_variable_unfolds_to_no_more_than_its_budget(tmp_path: Path) -> None:
    """100 kB that unfold to 110 MB, behind dimensions of 100 samples."""
    inner = struct.pack("<IIIIII", 6, 8, 6, 0, 5, 8) + struct.pack("<ii", 1, 100) + struct.pack("<II", 1, 9)
    inner += b"voltage_v".ljust(16, b"\0") + struct.pack("<II", 9, 110_000_000)
    own = zlib.compress(struct.pack("<II", 14, len(inner) + 110_000_000) + inner + bytes(110_000_000), 9)
    data = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(own)) + own
    assert len(data) < 120_000
    with pytest.raises(UsageError, match="it unfolds to more than signals"):
        read(tmp_path, data, "x.mat")


def test_packed_variables_are_read_and_cut_ones_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "y.mat", VECTORS | {"sampling_rate_hz": 1000}, do_compression=True)
    data = (tmp_path / "y.mat").read_bytes()
    np.testing.assert_array_equal(read(tmp_path, data, "x.mat").channels[1].values, -TIMES)
    with pytest.raises(UsageError, match=r"x\.mat: the file is cut off \(allowed: one that is complete\)"):
        read(tmp_path, data[:-9], "x.mat")
