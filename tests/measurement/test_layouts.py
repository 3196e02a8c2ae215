"""Files in the layouts of instruments are read as they are, with their exact values; broken ones are refused."""

from __future__ import annotations

import contextlib
import io
import re
import struct
import sys
import zipfile
from pathlib import Path
from typing import Any

import layouts
import numpy as np
import pyarrow
import pytest
from layouts import COUNT, STEP, TIMES, VOLTAGE, Layout
from pyarrow import parquet
from scipy.io import savemat

from vireport.base.errors import VireportError
from vireport.measurement.recordings import FlawKind, Recording, read_recording
from vireport.measurement.records import parse_record
from vireport.scenario.blocks import LayoutBlock

ALL = {layout.format: layout for layout in layouts.layouts()}


def read(folder: Path, data: bytes | str, file: str = "x.csv", **keys: Any) -> Recording:
    (folder / file).write_bytes(data.encode() if isinstance(data, str) else data)
    return read_recording(str(folder / file), keys=LayoutBlock.model_validate(keys) if keys else None)


def read_layout(folder: Path, layout: Layout, data: bytes | None = None) -> Recording:
    keys = layout.record if layout.columns else {}
    return read(folder, layout.data if data is None else data, layout.file, **keys)


@pytest.mark.parametrize("name", ALL)
def test_a_layout_is_read_as_it_is(name: str, tmp_path: Path) -> None:
    layout = ALL[name]
    recording = read_layout(tmp_path, layout)
    assert layout.tells in recording.reading
    assert recording.reading.endswith("1,400 samples at 2 ms")
    assert (recording.samples, recording.flaws, len(recording.stretches)) == (COUNT, (), 1)
    assert recording.step_s == pytest.approx(STEP, rel=1e-12)
    assert recording.start_s == pytest.approx(layout.start, rel=1e-12)
    assert {channel.name for channel in recording.channels} >= {*layout.columns} - {"time_s"}
    for channel in recording.channels:
        exact = layout.exact[channel.name.partition("_")[0]]
        np.testing.assert_allclose(channel.values, exact, rtol=1e-12, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize("name", ALL)
def test_a_layout_that_is_broken_is_refused_or_tells_what_is_lost(name: str, tmp_path: Path) -> None:
    layout, rng = ALL[name], np.random.default_rng(1)
    noise = rng.integers(0, 256, 5000, dtype=np.uint8).tobytes()
    half = len(layout.data) // 2
    for broken in (
        layout.data[:half],
        layout.data[:200],
        layout.data[:half] + noise + layout.data[half:],
        layout.data[:100] + noise,
        layout.data[:half] + bytes(1000) + layout.data[half:],
        layout.data[:300] + b"," * 1_000_000 + layout.data[300:],
    ):
        # What was cut may be a record that is shorter.
        with contextlib.suppress(VireportError):
            assert read_layout(tmp_path, layout, broken).samples <= COUNT


@pytest.mark.parametrize(
    "name", ["TDMS", "UFF 58", "UFF 58b", "WAV", "MATLAB 5", "MATLAB 7.3", "HDF5", "Parquet", "npz"]
)
def test_a_binary_file_that_is_cut_off_is_refused(name: str, tmp_path: Path) -> None:
    layout = ALL[name]
    with pytest.raises(VireportError):
        read_layout(tmp_path, layout, layout.data[:-2000])


def test_a_uff_file_may_begin_with_other_sets(tmp_path: Path) -> None:
    layout = ALL["UFF 58"]
    head = "".join(f"{line:80s}\n" for line in ("    -1", "   151", *["model"] * 7, "    -1"))
    assert read_layout(tmp_path, layout, head.encode() + layout.data).samples == COUNT


def test_a_file_of_matlab_4_is_read(tmp_path: Path) -> None:
    stream = io.BytesIO()
    savemat(stream, {"time_s": TIMES, "voltage_v": VOLTAGE}, format="4")
    recording = read(tmp_path, stream.getvalue(), "x.dat")
    np.testing.assert_array_equal(recording.channels[0].values, VOLTAGE)


def npz(head: str, data: bytes) -> bytes:
    """An archive with an array whose header says what it likes."""
    text = head.ljust(117) + "\n"
    stored = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + data
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("voltage_v.npy", stored)
    return stream.getvalue()


def test_an_npz_file_is_read_only_where_its_header_fits(tmp_path: Path) -> None:
    head = "{{'descr': '{}', 'fortran_order': False, 'shape': ({},)}}"
    fits = read(tmp_path, npz(head.format("<f8", 100), np.arange(100.0).tobytes()), "x.npz", sampling_rate_hz=10.0)
    np.testing.assert_array_equal(fits.channels[0].values, np.arange(100.0))
    for kind, count, message in (
        ("<f8", 10**15, "its header does not fit its size (allowed: a file that is complete)"),
        ("<f8", 99, "its header does not fit its size"),
        ("|O", 100, "voltage_v: is no vector of real numbers"),
    ):
        with pytest.raises(VireportError, match=re.escape(message)):
            read(tmp_path, npz(head.format(kind, count), bytes(800)), "x.npz", sampling_rate_hz=10.0)


@pytest.mark.slow
def test_what_unfolds_to_more_than_signals_do_is_refused(tmp_path: Path) -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("voltage_v.npy", bytes(110_000_000))
    with pytest.raises(VireportError, match="it unfolds to more than signals that were recorded"):
        read(tmp_path, stream.getvalue(), "x.npz", sampling_rate_hz=10.0)
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table({"voltage_v": np.zeros(14_000_000)}), stream)
    with pytest.raises(VireportError, match="it unfolds to more than signals that were recorded"):
        read(tmp_path, stream.getvalue(), "x.parquet", sampling_rate_hz=10.0)


NEEDS = {"nptdms": "TDMS", "pyuff": "UFF 58", "h5py": "HDF5", "pyarrow": "Parquet"}


@pytest.mark.parametrize("module", NEEDS)
def test_without_its_package_a_file_names_the_command(module: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(VireportError, match=rf"needs {module} to be read: pip install 'vireport\[\w+\]'"):
        read_layout(tmp_path, ALL[NEEDS[module]])


def columns(**signals: Any) -> dict[str, Any]:
    return {"columns": {name: {"column": column} | more for name, (column, more) in signals.items()}}


ROWS = [f"{k / 1000},{k % 7},{-(k % 5)}" for k in range(100)]
TEXT = "Time,A,B\n" + "\n".join(ROWS) + "\n"
A = {"voltage_v": ("A", {"unit": "V"})}


def test_units_signs_and_scales_are_those_of_the_keys(tmp_path: Path) -> None:
    keys = columns(
        time_s=("Time", {"unit": "ms"}),
        voltage_v=("A", {"unit": "mV", "sign": -1}),
        acceleration_m_s2=(3, {"unit": "g", "scale": 10.0}),
    )
    recording = read(tmp_path, TEXT, **keys)
    voltage, acceleration = recording.channels
    assert recording.step_s == pytest.approx(1e-6)
    np.testing.assert_allclose(voltage.values, -1e-3 * (np.arange(100) % 7), rtol=1e-12)
    np.testing.assert_allclose(acceleration.values, -98.0665 * (np.arange(100) % 5), rtol=1e-12)


def test_a_unit_of_the_file_is_taken_where_none_is_given(tmp_path: Path) -> None:
    text = TEXT.replace("Time,A,B", "Time (ms),A [kV],B (mm/s²)")
    recording = read(tmp_path, text, **columns(voltage_v=("A", {}), acceleration_m_s2=("B", {})))
    assert recording.step_s == pytest.approx(1e-6)
    assert [float(channel.values.min()) for channel in recording.channels] == [0.0, -0.004]
    assert float(recording.channels[0].values.max()) == 6000.0


REFUSED: dict[str, tuple[str, dict[str, Any], str]] = {
    "no unit": (
        TEXT,
        columns(time_s=(1, {"unit": "s"}), voltage_v=("A", {})),
        "voltage_v.unit: is needed",
    ),
    "other unit": (
        TEXT,
        columns(voltage_v=("A", {"unit": "g"})),
        "voltage_v.unit: g is no unit of voltage",
    ),
    "unit of the file": (
        TEXT.replace(",A,", ",A (V),"),
        columns(acceleration_m_s2=("A", {})),
        "acceleration_m_s2.unit: V of the file is no unit of acceleration (allowed: m/s2, g, mm/s2; a sensor",
    ),
    "no column": (TEXT, columns(voltage_v=("C", {})), "'C': no column has this name (allowed: Time, A, B; or a number"),
    "two columns": (TEXT.replace("B", "A", 1), columns(voltage_v=("A", {})), "'A': 2 columns have this name"),
    "no such number": (TEXT, columns(voltage_v=(4, {})), "4 is no column (allowed: 1 to 3)"),
    "no times": (TEXT, columns(**A), "it has no times (allowed: a column of times"),
    "two times": (
        TEXT.replace("Time,A,B", "Time (s),A,Clock (ms)"),
        columns(**A),
        "record.columns.time_s: is needed: Time, Clock all have times (allowed: one of them)",
    ),
    "of impacts": (TEXT, columns(membrane=("A", {})), "record.columns.membrane: is of a file of impacts"),
    "times and rate": (
        TEXT,
        columns(time_s=("Time", {"unit": "s"}), **A) | {"sampling_rate_hz": 10.0},
        "has times, and record.sampling_rate_hz is given (leave one of them out)",
    ),
    "two ways": (
        "\n".join(f"{k},{k % 7}" for k in range(100)),
        {"columns": {"voltage_v": {"column": 1, "unit": "V"}}},
        "x.csv:1: '0,0' can be read in two ways: commas between columns, or decimal commas (allowed: record.decimal",
    ),
    "a step of 0": (
        "Sample Interval,0,s\n" + TEXT.replace("Time,", "No,"),
        columns(**A),
        "the time between samples that its head states is not above 0",
    ),
    "another mark": (TEXT, columns(**A) | {"delimiter": ";"}, "no lines of numbers were found in it"),
    "all skipped": (TEXT, columns(**A) | {"skip_rows": 1000}, "the file is empty"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_two_readings_would_be_is_asked_for(name: str, tmp_path: Path) -> None:
    text, keys, message = REFUSED[name]
    with pytest.raises(VireportError, match=re.escape(message)):
        read(tmp_path, text, **keys)


@pytest.mark.parametrize(("keys", "largest"), [({"decimal": ","}, 2.6), ({"delimiter": ","}, 2.0)])
def test_a_key_decides_between_two_readings(keys: dict[str, str], largest: float, tmp_path: Path) -> None:
    text = "\n".join(f"{k % 3},{k % 7}" for k in range(100))
    block = columns(voltage_v=(1, {"unit": "V"})) | keys | {"sampling_rate_hz": 1000.0}
    assert float(read(tmp_path, text, **block).channels[0].values.max()) == largest


def test_lines_are_skipped_where_they_look_like_numbers(tmp_path: Path) -> None:
    block = columns(time_s=(1, {"unit": "s"}), voltage_v=(2, {"unit": "V"}))
    assert read(tmp_path, "9,9,9\n8,8,8\n" + TEXT, skip_rows=2, **block).samples == 100


def test_a_rate_in_the_head_or_in_the_keys_gives_the_times(tmp_path: Path) -> None:
    values = "\n".join(f"{k % 7};{k % 5}" for k in range(100))
    for head, more in (
        ("Sampling rate;2;kHz\n", {}),
        ("Sample Interval:;500 µs\n", {}),
        ("", {"sampling_rate_hz": 2e3}),
    ):
        recording = read(tmp_path, f"{head}\nA;B\n{values}", **columns(**A) | more)
        assert recording.step_s == pytest.approx(5e-4, rel=1e-12)


def test_samples_that_are_missing_or_repeated_are_told_with_their_places(tmp_path: Path) -> None:
    lines = list(ROWS)
    lines[7], lines[8], lines[50], lines[51] = "0.007,,2", "0.008,nan,2", "0.05,∞,1", "0.051,3,1"
    recording = read(tmp_path, "time_s,bottom_voltage_v,top_voltage_v\n" + "\n".join(lines))
    (missing,) = recording.flaws
    assert (missing.kind, missing.signal, missing.count, missing.row) == (FlawKind.MISSING, "bottom_voltage_v", 3, 7)
    assert missing.at_s == pytest.approx(0.007)
    assert recording.samples == 97
    assert [(part.first, part.last) for part in recording.stretches] == [(0, 7), (7, 48), (48, 97)]
    lines[50:52] = ["0.05,2,1", "0.05,3,1"]
    recording = read(tmp_path, "time_s,bottom_voltage_v,top_voltage_v\n" + "\n".join(lines))
    assert [(flaw.kind, flaw.count, flaw.row) for flaw in recording.flaws][1:] == [(FlawKind.REPEATED, 1, 51)]


IMPACTS = "Zeit (ms);Seite\n" + "\n".join(f"{100 + 200 * k},5;{('bottom', 'top')[k % 2]}" for k in range(6))


def test_impacts_are_read_by_the_same_keys() -> None:
    keys = LayoutBlock.model_validate(columns(time_s=("Zeit", {}), membrane=("Seite", {})))
    record = parse_record(IMPACTS.encode(), "x.csv", 2.0, keys=keys)
    np.testing.assert_allclose(record.times, 0.1005 + 0.2 * np.arange(6), rtol=1e-12)
    assert record.walls.tolist() == [1, -1, 1, -1, 1, -1]
    with pytest.raises(VireportError, match=r"record\.columns\.membrane: is needed, as no column"):
        parse_record(IMPACTS.encode(), "x.csv", 2.0, keys=LayoutBlock.model_validate(columns(time_s=("Zeit", {}))))
    with pytest.raises(VireportError, match=re.escape("x.csv:3: membrane: 'left' is no membrane")):
        parse_record(IMPACTS.replace("top", "left", 1).encode(), "x.csv", 2.0, keys=keys)


def test_the_docs_list_every_layout() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "recordings.md").read_text(encoding="utf-8")
    listed = page.partition("## What is read as it is")[2].partition("##")[0]
    names = re.findall(r"^- (?:Instruments|Formats): (.+)\.$", listed, re.MULTILINE)
    assert "; ".join(names).split("; ") == list(ALL)
