"""Reading of YAML: the types of its core schema and no others, and the line of everything."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vireport.base.errors import Mistake, ScenarioError
from vireport.scenario.document import (
    DEEPEST,
    LARGEST_FILE,
    explain,
    join,
    read,
    scalar,
)

REPEATABLE = settings(derandomize=True, max_examples=50, deadline=None)


def data(text: str | bytes) -> object:
    document = read(text, "text")
    assert not document.mistakes
    return document.data


NUMBERS = [
    *[("0", 0), ("-1", -1), ("+1", 1), ("017", 17), ("0o17", 15), ("0x1F", 31), ("00", 0), ("-0", 0)],
    *[
        ("1e3", 1e3),
        ("1e-3", 1e-3),
        ("+1E+3", 1e3),
        (".5", 0.5),
        ("5.", 5.0),
        ("-.5e1", -5.0),
        ("6.3e-3", 6.3e-3),
    ],
    *[(".inf", math.inf), ("-.Inf", -math.inf), ("+.INF", math.inf), ("1e999", math.inf)],
    *[("9" * 5000, math.inf), ("-" + "9" * 5000, -math.inf), ("0x" + "9" * 5000, math.inf)],
]
TEXTS = [
    *("yes", "no", "on", "off", "y", "Yes", "tRUE", "nan", "NaN", "inf", ".iNF", "nULL", "none", "None"),
    *(
        "1_000",
        "1:30",
        "1:30:00",
        "2024-01-01",
        "0b11",
        "0O17",
        "0X1F",
        "-0x1F",
        "+0o7",
        "0o8",
        "1e",
        "e3",
        ".",
    ),
    *(
        "1,5",
        "45°",
        "5e-3 m",
        "+",
        "-x",
        "1.2.3",
        "1e3.5",
        "\uff11",
        "\u0661",
        "0.7 \xa0m",
        "=",
        "..",
        "+.nan",
    ),
]


@pytest.mark.parametrize(("text", "value"), NUMBERS)
def test_numbers(text, value):
    assert data(f"a: {text}") == {"a": value}
    assert type(scalar(text)) is type(value)


@pytest.mark.parametrize("text", TEXTS)
def test_texts_that_others_read_as_something_else(text):
    assert data(f"a: {text}") == {"a": text}


@pytest.mark.parametrize("text", ["", "~", "null", "Null", "NULL"])
def test_null(text):
    assert data(f"a: {text}") == {"a": None}


@pytest.mark.parametrize("text", ["true", "True", "TRUE", "false", "False", "FALSE"])
def test_booleans(text):
    assert data(f"a: {text}") == {"a": text.lower() == "true"}


def test_nan():
    assert math.isnan(scalar(".nan"))


@pytest.mark.parametrize("quote", ["'", '"'])
def test_what_is_quoted_is_text(quote):
    document = read(f"a: {quote}1e-3{quote}", "text")
    assert document.data == {"a": "1e-3"}
    assert document.written == {"a": f"{quote}1e-3{quote}"}


def test_keys_that_others_read_as_booleans():
    assert data("on: 1\nyes: 2\nn: 3\n") == {"on": 1, "yes": 2, "n": 3}


TREE = """\
# comment

a: 1
b:
  # comment

  c: 2
  d: {e: 3,
      f: 4}
"g h":
- x
-
  i: 5
"""
LINES = {"": 3, "a": 3, "b": 4, "b.c": 7, "b.d": 8, "b.d.e": 8, "b.d.f": 9, "'g h'": 10}
LINES |= {"'g h'.0": 11, "'g h'.1": 13, "'g h'.1.i": 13}


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("encode", [str, str.encode])
def test_lines_whatever_the_line_ends_and_the_encoding(end, mark, encode):
    text = mark + TREE.replace("\n", end)
    document = read(encode(text), "text")
    assert document.data == {"a": 1, "b": {"c": 2, "d": {"e": 3, "f": 4}}, "g h": ["x", {"i": 5}]}
    assert document.lines == LINES
    assert document.text == text


def test_one_document_marked_as_such():
    assert data("%YAML 1.2\n---\na: 1\n...\n") == {"a": 1}


def test_json_with_escaped_characters():
    assert data(json.dumps({"title": "caf\xe9 \U0001f600"})) == {"title": "caf\xe9 \U0001f600"}
    assert data(json.dumps({"\U0001f600": [None, True, 1e-300]}, indent=1)) == {"\U0001f600": [None, True, 1e-300]}


def test_first_of_two_values_is_kept_and_the_other_is_a_mistake():
    document = read("a: 1\na: {b: [2, {c: 3}]}\nd: 4\n", "text")
    assert document.data == {"a": 1, "d": 4}
    assert [(mistake.line, mistake.path) for mistake in document.mistakes] == [(2, "a")]
    assert document.unread == {"a"}


@pytest.mark.slow
def test_depth_and_size_at_the_limit():
    deepest = "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1)
    assert data(f"a: {deepest}")
    with pytest.raises(ScenarioError, match="levels deep"):
        read(f"a: [{deepest}]", "text")
    assert data("a: 1 #".ljust(LARGEST_FILE, "#")) == {"a": 1}
    with pytest.raises(ScenarioError, match="larger than 1 MB"):
        read("a: 1 #".ljust(LARGEST_FILE + 1, "#"), "text")


@pytest.mark.parametrize(("path", "key", "joined"), [("", "a", "a"), ("a", "b", "a.b"), ("a", 3, "a.3")])
def test_join(path, key, joined):
    assert join(path, key) == joined


@pytest.mark.parametrize("key", ["a.b", "", "1", "a b", "a\n", "\x1b[31m", "\ud800", "x" * 1000])
def test_join_keeps_strange_keys_on_one_line(key):
    assert join("a", key).isprintable()
    assert join("a", key).startswith("a.'")
    assert len(join("a", key)) < 80


def test_errors_without_a_place_are_explained_too():
    assert explain(yaml.YAMLError("?"), "a: 1")[0] == 1
    assert explain(yaml.MarkedYAMLError(problem="new words"), "a: 1") == (
        1,
        "this is not YAML (write 'key: value', one to a line)",
    )


def mistakes_of(text: str | bytes) -> tuple[Mistake, ...]:
    """Return the mistakes, fatal or not; any other exception fails the test."""
    try:
        return read(text, "text").mistakes
    except ScenarioError as error:
        return error.mistakes


SYNTAX = list("abcde:-?[]{},#&*!|>'\"%@` \t\n\\~.019+<=")


@pytest.mark.slow
@REPEATABLE
@given(st.text() | st.text(SYNTAX, max_size=60) | st.binary())
@example("a: &a\n")
@example('"\\U00110000": 1')
@example("? - ? - a\n  :")
def test_any_text_is_read_or_refused_by_line(text):
    mistakes = mistakes_of(text)
    rows = text if isinstance(text, str) else text.decode("latin-1")
    assert all(1 <= mistake.line <= len(rows.splitlines()) + 1 for mistake in mistakes)
    assert all(first.line <= second.line for first, second in pairwise(mistakes))
    assert all(mistake.render("text").isprintable() for mistake in mistakes)


NAMES = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
LEAVES = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | NAMES
TREES = st.recursive(
    LEAVES,
    lambda parts: st.lists(parts, max_size=4) | st.dictionaries(NAMES, parts, max_size=4),
    max_leaves=12,
)


@pytest.mark.slow
@REPEATABLE
@given(st.dictionaries(NAMES, TREES, max_size=4), st.sampled_from([None, 1]))
def test_every_json_document_reads_as_json_does(tree, indent):
    assert data(json.dumps(tree, indent=indent)) == tree
