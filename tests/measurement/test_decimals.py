"""Rows of plain decimal numbers, read at once: to the same bits as digit by digit, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vireport.measurement.decimals import decimal_rows

from vireport.measurement import decimals

NUMBERS = st.from_regex(r"[+-]?([0-9]{1,9}(\.[0-9]{0,6})?|\.[0-9]{1,9})", fullmatch=True)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.integers(1, 4).flatmap(lambda k: st.lists(st.lists(NUMBERS, min_size=k, max_size=k), min_size=1, max_size=9)))
def test_numbers_are_those_of_a_general_reader(rows: list[list[str]]) -> None:
    text = "\n".join(map(",".join, rows)).encode()
    expected = np.array([[float(x) for x in row] for row in rows])
    for ending in (b"", b"\n", b"\r\n\r\n"):
        read = decimal_rows(b"names\n" + text + ending, 6, len(rows[0]))
        assert np.array_equal(read.view(np.int64), expected.view(np.int64))


def test_blocks_and_the_ends_of_lines_of_other_systems_make_no_difference(monkeypatch) -> None:
    values = np.random.default_rng(0).standard_normal((400, 3)).round(7)
    text = "\r\n".join(",".join(map("{:.7f}".format, row)) for row in values.tolist()).encode()
    for size in (1, 64, 1 << 20):
        monkeypatch.setattr(decimals, "BLOCK", size)
        assert np.array_equal(decimal_rows(text, 0, 3), values)


@pytest.mark.parametrize(
    "text",
    [
        *("1,2\n3", "1,2\n3,,4", "1,2\n,3", "1.2.3,4", "1-2,3", "1 ,2", "1e3,2", "nan,2", "1,2\n\n3,4", "-,1", ".,1"),
        *("1,2;3", '"1",2', "1,2\n3,4,5", "9007199254740993,1", "0x10,2", "1\r2,3", "é,1", "--1,2", "1\0,2", ""),
        "1," + "0" * 19,
    ],
)
def test_whatever_else_is_there_is_left_to_a_general_reader(text: str) -> None:
    assert decimal_rows(text.encode(), 0, 2) is None
