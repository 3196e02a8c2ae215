"""Text that is not ours can neither move a terminal's cursor nor give a command to the log of a job."""

from __future__ import annotations

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vireport.scenario.blocks import is_printable
from vireport.text.foreign import inert_cell, visible, without_joins
from vireport.text.tables import markdown_text

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
