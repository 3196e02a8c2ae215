"""Records of impacts: what is read, and where, what and what is allowed of each mistake."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vireport.base import ScenarioError, UsageError
from vireport.measurement import parse_record, read_record

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


MISTAKES = {
    "empty": ("", "x.csv:1: the file is empty (the first line is time_s,membrane"),
    "blank": ("\n \n", "x.csv:1: the file is empty"),
    "head alone": (HEAD, "x.csv:1: 0 impacts (at least 3"),
    "one impact": (f"{HEAD}0.1,top\n", "x.csv:2: 1 impact (at least 3"),
    "two impacts": (f"{HEAD}0.1,top\n0.2,top\n", "x.csv:3: 2 impacts"),
    "semicolons": ("time_s;membrane\n0,1;top\n", "x.csv:1: columns are separated by semicolons (allowed: commas"),
    "tabs": ("time_s\tmembrane\n0.1\ttop\n", "columns are separated by tabs"),
    "decimal comma": (f"{HEAD}0,1,top\n", "x.csv:2: 3 values for 2 columns. A decimal comma?"),
    "quoted decimal comma": (f'{HEAD}"0,1",top\n', "x.csv:2: time_s: '0,1' is not a finite number; decimal comma?"),
    "misspelt head": ("time_s,membran\n", "x.csv:1: membran: unknown column; did you mean 'membrane'?"),
    "other head": ("t,wall\n", "x.csv:1: time_s: the column is missing"),
    "no head": ("0.1,bottom\n0.2,top\n", "unknown column"),
    "column twice": ("time_s,time_s,membrane\n", "x.csv:1: time_s: the column stands twice"),
    "misspelt label": (f"{HEAD}0.1,botom\n", "x.csv:2: membrane: 'botom' is no membrane; did you mean 'bottom'?"),
    "capital label": (f"{HEAD}0.1,Top\n", "'Top' is no membrane; did you mean 'top'? (allowed: bottom, top)"),
    "no label": (f"{HEAD}0.1,\n", "'' is no membrane (allowed: bottom, top)"),
    "NaN": (f"{HEAD}nan,top\n", "x.csv:2: time_s: 'nan' is not a finite number"),
    "infinity": (f"{HEAD}1e999,top\n", "'1e999' is not a finite number"),
    "underscore": (f"{HEAD}1_0,top\n", "'1_0' is not a finite number"),
    "no time": (f"{HEAD},top\n", "x.csv:2: time_s: is empty (allowed: a number"),
    "text": (f"{HEAD}soon,top\n", "'soon' is not a finite number"),
    "too few": (f"{HEAD}0.1\n", "x.csv:2: 1 values for 2 columns. (allowed"),
    "bad voltage": ("time_s,membrane,voltage_v\n0.1,top,high\n", "x.csv:2: voltage_v: 'high' is not"),
    "unsorted": (f"{HEAD}0.1,top\n0.3,top\n0.2,top\n", "x.csv:4: time_s: 0.2 s is before that of line 3 (allowed"),
    "twice": (
        f"{HEAD}0.1,top\n0.3,top\n\n0.3,bottom\n",
        "x.csv:5: time_s: 0.3 s is that of line 3 (allowed: ascending",
    ),
    "milliseconds": (
        f"{HEAD}100,top\n300,top\n500,bottom\n",
        "time_s: half of the flights are longer than 400",
    ),
    "microseconds": (f"{HEAD}1e-7,top\n3e-7,top\n5e-7,bottom\n", "half of the flights are shorter than"),
    "zero byte": (f"{HEAD}0.1,top\0\n", "x.csv:2: a zero byte"),
    "open quote": (f'{HEAD}"0.1,top\n', "x.csv:1: unexpected end of data (allowed: CSV with commas)"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_where_it_is_and_what_is_allowed(name: str) -> None:
    text, message = MISTAKES[name]
    with pytest.raises(ScenarioError, match=re.escape(message)) as refused:
        parse_record(text.encode(), "x.csv", 2.0)
    assert all("(" in line for line in refused.value.lines if "stands twice" not in line)


def test_all_mistakes_are_told_at_once_and_a_thousand_not_one_by_one() -> None:
    with pytest.raises(ScenarioError) as refused:
        parse_record(f"{HEAD}x,top\n0.1,topp\n".encode(), "x.csv", 2.0)
    assert [line.split(": ")[0] for line in refused.value.lines] == ["x.csv:2", "x.csv:3"]
    with pytest.raises(ScenarioError) as refused:
        parse_record((HEAD + "x,top\n" * 1000).encode(), "x.csv", 2.0)
    assert len(refused.value.lines) == 21


def test_bytes_that_are_no_text_are_told_by_their_line() -> None:
    with pytest.raises(ScenarioError, match=r"x\.csv:3: byte 0xE9 is not UTF-8"):
        parse_record(f"{HEAD}0.1,top\n".encode() + b"0.2,\xe9\n", "x.csv", 2.0)


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
