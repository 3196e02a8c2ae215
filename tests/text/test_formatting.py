"""Numbers, bounds and tables in print: what is shown is the number to its digits; text of others gives no commands."""

from __future__ import annotations

import os
from decimal import Decimal
from itertools import combinations
from math import log10

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from vireport.scenario.blocks import is_printable
from vireport.text.enclosed import plus_minus
from vireport.text.foreign import inert_cell, visible, without_joins
from vireport.text.formatting import (
    ABSENT,
    MINUS,
    OF_A_MODEL,
    ROUGHLY,
    Exactness,
    apart,
    error_bound,
    exact,
    measured,
    percent,
    quantity,
    rounded_text,
    words,
)
from vireport.text.tables import LINE, Column, Table, broken, markdown_text, numbers, plain_table, plain_text, texts

FINITE = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e300, max_value=1e300)
NONZERO = FINITE.filter(lambda value: abs(value) > 1e-300)
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
POWERS = {"n": -9, "µ": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}


def parse(text: str) -> Decimal:
    """Read a printed number back."""
    mantissa, _, exponent = text.replace(MINUS, "-").partition(" × 10")
    return Decimal(mantissa).scaleb(int(exponent.translate(SUPERSCRIPTS) or 0) if exponent else 0)


def half_a_unit(text: str) -> Decimal:
    """Half a unit of the last printed digit."""
    return Decimal((0, (5,), parse(text).as_tuple().exponent - 1))


def significand(text: str) -> str:
    """The digits of a printed number, from the first that is not nought."""
    return text.partition(" ×")[0].strip(MINUS).replace(".", "").lstrip("0")


def close(printed: Decimal, value: Decimal, half: Decimal) -> bool:
    """Whether a print is a rounding, or differs from the number by rounding errors only."""
    return abs(printed - value) <= max(half, abs(value) * Decimal("1e-14"))


@given(NONZERO, st.integers(1, 15))
def test_no_number_is_shown_as_zero_or_one_that_is_neither(value: float, digits: int) -> None:
    text = rounded_text(value, Exactness(0.5 * 10.0 ** (1 - digits)))
    assert parse(text) != 0
    if abs(value) != 1:
        assert abs(parse(text)) != 1


@example(9.5e243, 1.0)  # one digit, which is rounded up to two
@given(NONZERO, st.floats(1e-14, 1e2))
def test_a_number_is_rounded_within_its_error_and_one_digit_more_would_be_noise(value: float, share: float) -> None:
    error = abs(value) * share
    text = rounded_text(value, error)
    off, last = abs(parse(text) - Decimal(repr(value))), 2 * half_a_unit(text)
    assert off <= Decimal(error) * Decimal("1.000001") or len(significand(text)) == 1
    short, whole = off <= abs(Decimal(value)) * Decimal("1e-14"), "." not in text and text.endswith("0")
    # It ends earlier where it is short, and later where it would seem to be one.
    if not (short or whole) and not 0.5 < abs(value) < 2:
        assert last / 2 <= Decimal(error) * Decimal("1.000001")
        assert Decimal(error) <= 5 * last or significand(text) == "10" or len(significand(text)) == 1


@given(NONZERO, st.floats(1e-12, 0.4))
def test_all_numbers_of_a_study_have_the_digits_of_its_largest_error(value: float, relative: float) -> None:
    exactness = Exactness(relative)
    text = rounded_text(value, exactness)
    assert abs(parse(text) - Decimal(value)) <= abs(Decimal(value)) * Decimal(relative) * Decimal("1.000001")
    if abs(value) < 0.5 and "×" not in text:
        assert len(significand(text)) <= exactness.digits <= 2 - log10(2 * relative)


@given(st.lists(st.floats(0.1, 10), min_size=2, max_size=4))
def test_numbers_that_differ_are_told_apart_by_what_they_differ_by(values: list[float]) -> None:
    texts = apart(values)
    for one, other in combinations(range(len(values)), 2):
        difference = Decimal(repr(values[one])) - Decimal(repr(values[other]))
        if abs(difference) > Decimal("1e-13"):
            assert texts[one] != texts[other]
            assert abs(parse(texts[one]) - parse(texts[other]) - difference) <= abs(difference)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.62945714101, OF_A_MODEL, "0.629"),
        (0.62945714101, ROUGHLY, "0.63"),
        (0.62945714101, 3e-6, "0.629457"),
        (0.62945714101, 0.0, "0.62945714101"),
        (0.62945714101, 8.0, "0.6"),
        (9.996, 0.03, "10.00"),
        (9.996, OF_A_MODEL, "10.0"),
        (42836.2, OF_A_MODEL, "42800"),
        (12345678.9, OF_A_MODEL, "1.23 × 10⁷"),
        (0.5, 1e-6, "0.5"),
        (0.99999, OF_A_MODEL, "0.99999"),
        (0.999961, OF_A_MODEL, "0.99996"),
        (-1 - 1e-9, OF_A_MODEL, f"{MINUS}1.000000001"),
        (1.0, OF_A_MODEL, "1"),
        (0.39175999999999994, 1e-12, "0.39176"),
        (float("inf"), OF_A_MODEL, ABSENT),
        (-0.0, OF_A_MODEL, "0"),
        (0.1 + 0.2, 1e-9, "0.3"),
        (-1e-7, OF_A_MODEL, f"{MINUS}1 × 10⁻⁷"),
        (0.0, 1.0, "0"),
        (None, 1.0, ABSENT),
        (float("nan"), 1.0, ABSENT),
    ],
)
def test_numbers_are_shown(value: float | None, error: float | Exactness, text: str) -> None:
    assert rounded_text(value, error) == text


@given(FINITE)
def test_exact_reads_back(value: float) -> None:
    assert float(parse(exact(value))) == value


@given(st.floats(1e-300, 1e300))
def test_a_printed_bound_is_one(bound: float) -> None:
    assert Decimal(bound) <= parse(error_bound(bound)) <= Decimal(bound) * Decimal("1.1")


@given(st.floats(-1e6, 1e6))
def test_percent_is_honest_about_nothing_and_all(fraction: float) -> None:
    text = percent(fraction)
    number, _, sign = text.rpartition(" ")
    assert sign == "%"
    assert (parse(number) == 0) == (fraction == 0)
    if abs(parse(number)) == 100:
        assert abs(fraction) == 1


def test_percent_signs() -> None:
    assert percent(0.0922, signed=True) == "+9.2 %"
    assert percent(-0.0922, signed=True) == f"{MINUS}9.2 %"
    assert percent(None) == ABSENT


@given(st.floats(1e-12, 1e12), st.floats(1e-12, 0.05))
def test_quantity_keeps_the_value(value: float, relative: float) -> None:
    number, _, unit = quantity(value, "V", Exactness(relative)).rpartition(" ")
    back = parse(number).scaleb(POWERS[unit.removesuffix("V")])
    assert abs(back - Decimal(value)) <= Decimal(value) * Decimal(relative) * Decimal("1.000001")
    if 1e-9 <= value < 1e11:
        assert Decimal("0.99") <= parse(number) <= 1000


@given(st.floats(1e-9, 1e9), st.integers(-6, 6), st.floats(1e-14, 0.4))
def test_a_number_times_a_power_of_ten_is_rounded_once(value: float, power: int, relative: float) -> None:
    text, expected = rounded_text(value, Exactness(relative), power), Decimal(value).scaleb(power)
    assert abs(parse(text) - expected) <= expected * Decimal(relative) * Decimal("1.000001") + expected / 10**14


@given(st.floats(1e-9, 1e9), st.floats(1e-6, 1e-1))
def test_a_measured_number_is_shown_to_two_digits_of_its_standard_error(value: float, share: float) -> None:
    text, error = measured(value, share * value), Decimal(share * value)
    assert abs(parse(text) - Decimal(value)) <= error / 20 * Decimal("1.000001")


def test_words_set_our_messages_and_leave_keys_alone() -> None:
    assert words("Delta < 0 and |lambda_i| < 1 for beta > 0") == "Δ < 0 and |λ_i| < 1 for β > 0"
    assert (
        words("G1 is -0.41 % away in amplitude_n, by 4.58e+04 V")
        == "G1 is −0.41 % away in amplitude_n, by 4.58 × 10⁴ V"
    )
    assert words("Eqs. (5.3)-(5.5), 1:1") == "Eqs. (5.3)-(5.5), 1:1"
    assert words("alphabeta deltas") == "alphabeta deltas"


def test_plus_minus_holds_its_bounds() -> None:
    rng = np.random.default_rng(8)
    for low, width in zip(rng.integers(-(10**9), 10**9, 50), rng.integers(1, 10**4, 50), strict=True):
        pair = (f"{Decimal(int(low)).scaleb(-12)}", f"{Decimal(int(low + width)).scaleb(-12)}")
        middle, off = map(Decimal, plus_minus(pair).split(" ± "))
        assert middle - off <= Decimal(pair[0])
        assert middle + off >= Decimal(pair[1])


TABLE = Table(
    "Motions", (*texts("Name"), *numbers("Ż [y_c]")), (("B1 | G1", "−0.5"), ("C1", "1 × 10⁻⁶")), "Velocities."
)


def test_columns_are_aligned_by_their_kind() -> None:
    assert plain_table(TABLE).splitlines() == ["Name       Ż [y_c]", "B1 | G1       −0.5", "C1        1 × 10⁻⁶"]


def test_a_cell_is_broken_at_the_width_of_its_column_but_not_at_a_minus() -> None:
    table = Table("", (Column("a", width=9), Column("b")), (("below 1e-12 or 1e-9", "x"),))
    assert plain_table(table).splitlines() == ["a         b", "below     x", "1e-12 or", "1e-9"]


def test_a_table_without_rows_has_its_head() -> None:
    empty = Table("", texts("a", "b"), ())
    assert plain_table(empty) == "a    b"


def test_text_has_paragraphs_captions_and_notes() -> None:
    text = plain_text(("word " * 40, TABLE))
    assert max(map(len, text.splitlines())) <= 110
    assert "\n\nMotions\nName" in text
    assert text.endswith("\nVelocities.")


def test_no_line_of_a_paragraph_begins_with_a_unit() -> None:
    for start in range(LINE):
        lines = broken(f"{'x' * start} margin 4.7 % in frequency, 42.84 kV").splitlines()
        assert not [line for line in lines if line.startswith(("%", "kV"))]


ANY = st.text(st.characters(exclude_categories=()), max_size=60)


@given(ANY, st.integers(4, 80))
def test_it_is_one_printable_line(text: str, most: int) -> None:
    shown = visible(text, most)
    assert without_joins(shown).isprintable()
    assert "::" not in shown
    assert "##[" not in shown
    assert len(shown) <= 10 * most  # an escape has up to ten characters
    shown.encode()


@given(st.text(st.characters(categories=("L", "N"), max_codepoint=0x2FF), max_size=30))
def test_what_is_harmless_stays_as_it_is(text: str) -> None:
    assert visible(text) == text


def test_bytes_of_a_name_are_told_from_one_another() -> None:
    assert visible(os.fsdecode(b"\xff\xfe.yaml")) == r"\xff\xfe.yaml"


def test_nothing_is_executed_called_or_linked() -> None:
    assert [inert_cell(text)[0] for text in ("=1+1", "+1", "-1", "@SUM(1)", "\tx", "\rx")] == ["'"] * 6
    for text, active in (("@octocat", "@o"), ("http://x.org", "http://"), ("www.x.org", "www."), ("#12", "#1")):
        assert active not in markdown_text(text)
        assert markdown_text(text).replace("\u2060", "") == text
    assert markdown_text("a@b.org") != "a@b.org"
    assert "\n" not in markdown_text("a\n# b")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("5\u00a0mm", True),
        ("\U0001f469\u200d\U0001f52c", True),
        ("\u2764\ufe0f\u200d\U0001f525", True),
        ("a\u200db", False),
        ("\u200d", False),
        ("\u202ea", False),
        ("a\u200b", False),
    ],
)
def test_what_joins_words_or_pictographs_is_shown_as_it_is(text: str, shown: bool) -> None:
    assert (visible(text) == text) is shown
    assert is_printable(text) is shown
