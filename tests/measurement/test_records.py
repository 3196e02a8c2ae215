"""Records of impacts: what is read, and where, what and what is allowed of each mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vireport.base.errors import ScenarioError, UsageError
from vireport.cli.app import main
from vireport.measurement.records import parse_record, read_record

HEAD = "time_s,membrane\n"
GOOD = f"{HEAD}0.1,bottom\n0.3,top\n0.6,bottom\n"


@pytest.mark.parametrize(
    "data",
    [
        GOOD.encode(),
        b"\xef\xbb\xbf" + GOOD.encode(),
        GOOD.replace("\n", "\r\n").encode(),
        b"\n" + GOOD.encode() + b"\n\n",
        b"membrane,voltage_v,time_s\nbottom,2001,0.1\ntop,,3e-1\nbottom,2000, 0.6\n",
        b'"time_s","membrane"\n"0.1","bottom"\n"0.3","top"\n"0.6","bottom"\n',
    ],
)
def test_a_record_is_read(data: bytes) -> None:
    record = parse_record(data, "x.csv", 2.0)
    assert record.times.tolist() == [0.1, 0.3, 0.6]
    assert record.walls.tolist() == [1, -1, 1]


NOT_UTF_8 = "is not UTF-8 (allowed: CSV in UTF-8"
NO_TEXT = "a zero byte: this is no text (allowed: CSV in UTF-8)"
NO_NUMBER = "is not a finite number"
NO_MEMBRANE = "is no membrane"
UNKNOWN = "unknown column"
NO_COLUMN = "no column is known by its name (the first line is time_s,membrane"
UNIT = "(allowed: seconds, and excitation.frequency_hz in Hz"
ORDER = "(allowed: ascending times, each once)"
VALUES = "(allowed: commas between columns, and points in numbers)"

FILES: dict[str, tuple[bytes, int, str]] = {
    "empty": (b"", 1, "the file is empty (the first line is time_s,membrane"),
    "byte order mark alone": (b"\xef\xbb\xbf", 1, "the file is empty"),
    "blank": (b"\n \n", 1, "the file is empty"),
    "UTF-16": (GOOD.encode("utf-16"), 1, "the file is UTF-16 (allowed: save it as CSV in UTF-8)"),
    "UTF-16, other order": (b"\xfe\xff" + GOOD.encode("utf-16-be"), 1, "the file is UTF-16"),
    "UTF-16 without mark": (GOOD.encode("utf-16-le"), 1, NO_TEXT),
    "Latin-1": (HEAD.encode() + b"0.1,top\n0.2,\xe9\n", 3, f"byte 0xE9 {NOT_UTF_8}"),
    "cut within a character": (GOOD.encode() + b"0.7,\xe2\x82", 5, f"byte 0xE2 {NOT_UTF_8}"),
    "gzip": (b"\x1f\x8b\x08\x00abc", 1, NOT_UTF_8),
    "PNG": (b"\x89PNG\r\n\x1a\n", 1, NOT_UTF_8),
    "PDF": (b"%PDF-1.4\n%\xe2\xe3", 2, NOT_UTF_8),
    "spreadsheet": (b"PK\x03\x04\x14\x00\x00", 1, NO_TEXT),
    "WAV": (b"RIFF$\x00\x00\x00WAVEfmt ", 1, NO_TEXT),
    "MATLAB": (b"MATLAB 5.0 MAT-file\x00", 1, NO_TEXT),
    "JSON": (b'{"time_s": [0.1], "membrane": ["top"]}', 1, UNKNOWN),
    "YAML": (b"time_s: 0.1\nmembrane: top\n", 1, UNKNOWN),
    "HTML": (b"<html><body>404</body></html>", 1, NO_COLUMN),
    "two byte order marks": (b"\xef\xbb\xbf" * 2 + GOOD.encode(), 1, UNKNOWN),
}
"""Bytes of files that are no text of ours, the line of the mistake, and what is said."""

TEXTS: dict[str, tuple[str, int, str]] = {
    "head alone": (HEAD, 1, "0 impacts (at least 3"),
    "one impact": (f"{HEAD}0.1,top\n", 2, "1 impact (at least 3"),
    "two impacts": (f"{HEAD}0.1,top\n0.2,top\n", 3, "2 impacts"),
    "semicolons": ("time_s;membrane\n0.1;top\n", 1, "columns are separated by semicolons (allowed: commas"),
    "semicolons and decimal commas": ("time_s;membrane\n0,1;top\n", 1, "columns are separated by semicolons"),
    "semicolons after a good head": (f"{HEAD}0.1;top\n", 2, f"1 value for 2 columns. Semicolons? {VALUES}"),
    "tabs": ("time_s\tmembrane\n0.1\ttop\n", 1, "columns are separated by tabs"),
    "spaces": ("time_s membrane\n0.1 top\n", 1, UNKNOWN),
    "bars": ("time_s|membrane\n0.1|top\n", 1, UNKNOWN),
    "decimal comma": (f"{HEAD}0,1,top\n", 2, f"3 values for 2 columns. A decimal comma? {VALUES}"),
    "quoted decimal comma": (f'{HEAD}"0,1",top\n', 2, "time_s: '0,1' is not a finite number; decimal comma?"),
    "thousands": (f'{HEAD}"1,000.5",top\n', 2, NO_NUMBER),
    "misspelt head": ("time_s,membran\n", 1, "membran: unknown column; did you mean 'membrane'?"),
    "capital head": ("Time_s,Membrane\n", 1, "Time_s: unknown column; did you mean 'time_s'?"),
    "head with unit": ("time [s],membrane\n", 1, "time [s]: unknown column; did you mean 'time_s'?"),
    "head in milliseconds": ("time_ms,membrane\n", 1, "time_ms: unknown column"),
    "other head": ("t,wall\n", 1, NO_COLUMN),
    "no head": ("0.1,bottom\n0.2,top\n", 1, NO_COLUMN),
    "comment": (f"# exported\n{GOOD}", 1, NO_COLUMN),
    "separator line": (f"sep=,\n{GOOD}", 1, NO_COLUMN),
    "numbered rows": ("index,time_s,membrane\n1,0.1,top\n", 1, "index: unknown column"),
    "notes": ("time_s,membrane,notes\n0.1,top,x\n", 1, "notes: unknown column"),
    "nameless column": (",time_s,membrane\n1,0.1,top\n", 1, "a column without a name (allowed: time_s"),
    "comma at every end": ("time_s,membrane,\n0.1,top,\n", 1, "a column without a name"),
    "column twice": ("time_s,time_s,membrane\n", 1, "time_s: the column stands twice (allowed: once)"),
    "membranes twice": ("time_s,membrane,membrane\n", 1, "membrane: the column stands twice"),
    "no membranes": ("time_s\n0.1\n", 1, "membrane: the column is missing"),
    "no times": ("membrane\ntop\n", 1, "time_s: the column is missing"),
    "two heads": (HEAD + GOOD, 2, f"time_s: 'time_s' {NO_NUMBER}"),
    "head again": (f"{GOOD}{HEAD}0.7,top\n", 5, f"time_s: 'time_s' {NO_NUMBER}"),
    "line of units": (f"{HEAD}s,\n0.1,top\n", 2, f"time_s: 's' {NO_NUMBER}"),
    "columns the other way round": ("membrane,time_s\n0.1,top\n", 2, f"time_s: 'top' {NO_NUMBER}"),
    "misspelt label": (f"{HEAD}0.1,botom\n", 2, "membrane: 'botom' is no membrane; did you mean 'bottom'?"),
    "turned letters": (f"{HEAD}0.1,tpo\n", 2, "'tpo' is no membrane; did you mean 'top'?"),
    "capital label": (f"{HEAD}0.1,Top\n", 2, "'Top' is no membrane; did you mean 'top'? (allowed: bottom, top)"),
    "capitals": (f"{HEAD}0.1,BOTTOM\n", 2, "did you mean 'bottom'?"),
    "number as label": (f"{HEAD}0.1,1\n", 2, f"'1' {NO_MEMBRANE}"),
    "letter as label": (f"{HEAD}0.1,B\n", 2, f"'B' {NO_MEMBRANE}"),
    "another language": (f"{HEAD}0.1,unten\n", 2, f"'unten' {NO_MEMBRANE}"),
    "no label": (f"{HEAD}0.1,\n", 2, "'' is no membrane (allowed: bottom, top)"),
    "endless label": (f"{HEAD}0.1,{'x' * 9999}\n", 2, f"'{'x' * 40}' {NO_MEMBRANE}"),
    "writing direction": (f"{HEAD}0.1,\u202etop\n", 2, r"'\u202etop' is no membrane"),
    "terminal colours": (f"{HEAD}0.1,\x1b[31mtop\n", 2, r"'\x1b[31mtop' is no membrane"),
    "NaN": (f"{HEAD}nan,top\n", 2, f"time_s: 'nan' {NO_NUMBER}"),
    "NaN with sign": (f"{HEAD}-NaN,top\n", 2, NO_NUMBER),
    "infinity": (f"{HEAD}inf,top\n", 2, NO_NUMBER),
    "beyond doubles": (f"{HEAD}1e999,top\n", 2, f"'1e999' {NO_NUMBER}"),
    "5000 digits": (f"{HEAD}{'1' * 5000},top\n", 2, NO_NUMBER),
    "underscore": (f"{HEAD}1_0,top\n", 2, f"'1_0' {NO_NUMBER}"),
    "hexadecimal": (f"{HEAD}0x1p-3,top\n", 2, NO_NUMBER),
    "fraction": (f"{HEAD}1/3,top\n", 2, NO_NUMBER),
    "unit in the cell": (f"{HEAD}0.1 s,top\n", 2, NO_NUMBER),
    "per cent": (f"{HEAD}10%,top\n", 2, NO_NUMBER),
    "date": (f"{HEAD}2026-11-23 10:00:01.2,top\n", 2, NO_NUMBER),
    "time of day": (f"{HEAD}00:00:01.234,top\n", 2, NO_NUMBER),
    "digits of another script": (f"{HEAD}\u0661.\u0662,top\n", 2, NO_NUMBER),
    "wide digits": (f"{HEAD}\uff10.1,top\n", 2, NO_NUMBER),
    "typographic minus": (f"{HEAD}\u22120.1,top\n", 2, NO_NUMBER),
    "invisible character": (f"{HEAD}0.1\u200b,top\n", 2, NO_NUMBER),
    "no time": (f"{HEAD},top\n", 2, "time_s: is empty (allowed: a number"),
    "text": (f"{HEAD}soon,top\n", 2, f"'soon' {NO_NUMBER}"),
    "missing cell": (f"{HEAD}0.1\n", 2, f"1 value for 2 columns. {VALUES}"),
    "cell too many": (f"{HEAD}0.1,top,\n", 2, "3 values for 2 columns"),
    "two rows in one": (f"{HEAD}0.1,top\x0b0.3,bottom\n", 2, "3 values for 2 columns"),
    "line separator": (f"{HEAD}0.1,top\u20280.3,bottom\n", 2, "3 values for 2 columns"),
    "end of a DOS file": (f"{GOOD}\x1a", 5, "1 value for 2 columns"),
    "far down": (HEAD + "\n" * 50 + "x,top\n", 52, f"time_s: 'x' {NO_NUMBER}"),
    "after a cell of two lines": (f'{HEAD}"0.1\n",top\nx,top\n', 4, f"time_s: 'x' {NO_NUMBER}"),
    "bad voltage": ("time_s,membrane,voltage_v\n0.1,top,high\n", 2, f"voltage_v: 'high' {NO_NUMBER}"),
    "no voltage": ("time_s,membrane,voltage_v\n0.1,top,nan\n", 2, f"voltage_v: 'nan' {NO_NUMBER}"),
    "endless velocity": ("time_s,membrane,velocity_m_s\n0.1,top,inf\n", 2, f"velocity_m_s: 'inf' {NO_NUMBER}"),
    "unsorted": (f"{HEAD}0.1,top\n0.3,top\n0.2,top\n", 4, f"time_s: 0.2 s is before that of line 3 {ORDER}"),
    "descending": (f"{HEAD}0.6,top\n0.3,top\n0.2,top\n", 3, "time_s: 0.3 s is before that of line 2"),
    "clock set back": (GOOD + GOOD.removeprefix(HEAD), 5, "time_s: 0.1 s is before that of line 4"),
    "twice": (f"{HEAD}0.1,top\n0.3,top\n\n0.3,bottom\n", 5, f"time_s: 0.3 s is that of line 3 {ORDER}"),
    "both zeros": (f"{HEAD}-0.0,top\n0.0,top\n1,top\n", 3, "0.0 s is that of line 2"),
    "milliseconds": (f"{HEAD}100,top\n300,top\n500,bottom\n", 2, "The times look like milliseconds."),
    "microseconds": (f"{HEAD}1e5,top\n3e5,top\n5e5,bottom\n", 2, UNIT),
    "nanoseconds": (f"{HEAD}1e8,top\n3e8,top\n5e8,bottom\n", 2, UNIT),
    "sample numbers": (f"{HEAD}4410,top\n13230,top\n22050,bottom\n", 2, UNIT),
    "days": (f"{HEAD}1e-7,top\n3e-7,top\n5e-7,bottom\n", 2, "half of the flights are shorter than"),
    "huge numbers": (f"{HEAD}1e300,top\n2e300,top\n3e300,top\n", 2, UNIT),
    "digits lost": (f"{HEAD}1e12,top\n1000000000000.3,top\n1000000000000.6,top\n", 2, "count them from the record's"),
    "zero byte": (f"{HEAD}0.1,top\0\n", 2, NO_TEXT),
    "zero bytes alone": (f"{GOOD}\0\0\0\n", 5, NO_TEXT),
    "open quote": (f'{HEAD}"0.1,top\n', 2, "unexpected end of data (allowed: CSV with commas)"),
    "quote within a number": (f'{HEAD}0."1,top\n', 2, NO_NUMBER),
    "text after a quote": (f'{HEAD}"0.1"x,top\n', 2, "expected after"),
    "single quotes": (f"{HEAD}'0.1',top\n", 2, NO_NUMBER),
    "endless cell": (f'{HEAD}"{"1" * 200_000}",top\n', 2, "a line of more than 100000 bytes (allowed: an impact"),
    "endless head": (f"{HEAD[:-1]}{',' * 200_000}\n", 1, "a line of more than 100000 bytes"),
}
"""Texts with a mistake, its line, and what is said."""

MISTAKES = FILES | {name: (text.encode(), line, message) for name, (text, line, message) in TEXTS.items()}


def test_a_mistake_is_told_where_it_is_and_what_is_allowed() -> None:
    assert len(MISTAKES) >= 100
    for name, (data, line, message) in MISTAKES.items():
        with pytest.raises(ScenarioError) as refused:
            parse_record(data, "x.csv", 2.0)
        first = next((told for told in refused.value.lines if message in told), "")
        assert first.startswith(f"x.csv:{line}: "), (name, refused.value.lines)
        assert all("(" in told for told in refused.value.lines), name


@pytest.mark.slow
def test_of_malformed_files_nothing_is_written(capsys, tmp_path, monkeypatch) -> None:
    """Through the command: code 2, each mistake with file and line on stderr, no folder and nothing on stdout."""
    scenario = str(Path(__file__).resolve().parents[2] / "examples" / "measured.yaml")
    monkeypatch.chdir(tmp_path)
    for name, (data, line, message) in MISTAKES.items():
        Path("x.csv").write_bytes(data)
        assert main(["identify", scenario, "--impacts", "x.csv", "-o", "out"]) == 2, name
        said = capsys.readouterr()
        assert not said.out, name
        assert f"x.csv:{line}: " in said.err, (name, said.err)
        assert message in said.err.replace("\n", " "), (name, said.err)
        assert [path.name for path in Path().iterdir()] == ["x.csv"], name


def test_a_gigabyte_is_refused_by_its_size(tmp_path) -> None:
    with (tmp_path / "long.csv").open("wb") as file:
        file.truncate(1 << 30)
    with pytest.raises(UsageError, match=r"long\.csv: the file is larger than 50 MB \(cut the record\)"):
        read_record(str(tmp_path / "long.csv"), 2.0)


def test_errors_of_times_are_read_and_must_be_above_0() -> None:
    head = "time_s,membrane,standard_error_s\n"
    own = parse_record(f"{head}0.1,top,1e-4\n0.4,bottom,2e-4\n0.6,top,4e-4\n".encode(), "x.csv", 2.0)
    assert own.unused == ()
    assert own.relative.tolist() == [0.5, 1.0, 2.0]
    alike = parse_record(f"{head}0.1,top,1e-4\n0.4,bottom,1e-4\n0.6,top,1e-4\n".encode(), "x.csv", 2.0)
    assert alike.relative is None
    with pytest.raises(ScenarioError) as raised:
        parse_record(f"{head}0.1,top,0\n0.4,bottom,\n0.6,top,-1\n".encode(), "x.csv", 2.0)
    assert [(mistake.line, mistake.path) for mistake in raised.value.mistakes] == [
        (line, "standard_error_s") for line in (2, 3, 4)
    ]


def test_all_mistakes_are_told_at_once_and_a_thousand_not_one_by_one() -> None:
    with pytest.raises(ScenarioError) as refused:
        parse_record(f"{HEAD}x,top\n0.1,topp\n".encode(), "x.csv", 2.0)
    assert [line.split(": ")[0] for line in refused.value.lines] == ["x.csv:2", "x.csv:3"]
    with pytest.raises(ScenarioError) as refused:
        parse_record((HEAD + "x,top\n" * 1000).encode(), "x.csv", 2.0)
    assert refused.value.lines[20:] == ("x.csv: and 980 more (mend these first)",)


@pytest.mark.slow
def test_a_million_mistakes_are_not_counted() -> None:
    with pytest.raises(ScenarioError) as refused:
        parse_record((HEAD + "x,top\n" * 1_000_000).encode(), "x.csv", 2.0)
    assert refused.value.lines[20:] == ("x.csv: and over 100000 more (mend these first)",)


def test_a_file_that_is_not_there_is_told() -> None:
    with pytest.raises(UsageError, match=r"nowhere\.csv cannot be read: No such file"):
        read_record("/nowhere.csv", 2.0)


@settings(max_examples=60)
@given(st.one_of(st.binary(max_size=60), st.text(max_size=60).map(lambda text: (HEAD + text).encode())))
def test_no_file_is_a_fault_of_ours(data: bytes) -> None:
    try:
        record = parse_record(data, "x.csv", 2.0)
    except ScenarioError:
        return
    assert np.all(np.diff(record.times) > 0)
