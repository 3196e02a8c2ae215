"""Random scenarios: good ones survive a round trip, damaged ones are loaded or refused and never crash."""

from __future__ import annotations

import json

import pytest
import yaml
from bad_scenarios import GOOD
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import solvable_trees

from vireport.base.errors import ScenarioError
from vireport.scenario.blocks import to_dict
from vireport.scenario.loading import loads
from vireport.scenario.parameters import DRIVING

REPEATABLE = settings(derandomize=True, max_examples=50, deadline=None)


@pytest.mark.slow
@REPEATABLE
@given(solvable_trees(), st.sampled_from([yaml.safe_dump, json.dumps]))
def test_loading_the_plain_data_gives_the_same_scenario(tree, dump):
    scenario = loads(dump(tree)).scenario
    plain = to_dict(scenario)
    assert loads(dump(plain)).scenario == scenario
    assert to_dict(loads(dump(plain)).scenario) == plain
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain


ROWS = GOOD.splitlines()
PIECES = st.sampled_from([*ROWS, *(row.strip() for row in ROWS), *":-?[]{},#&*!|>'\"%@ \t\\~.", "1e-3", "null", "{}"])


@REPEATABLE
@given(st.lists(st.tuples(st.integers(0, len(GOOD)), st.integers(0, 30), PIECES | st.text(max_size=5)), max_size=4))
def test_a_damaged_scenario_is_loaded_or_refused(damages):
    text = GOOD
    for start, count, piece in damages:
        text = text[:start] + piece + text[start + count :]
    assert_loaded_or_refused(text, ())


@REPEATABLE
@given(st.lists(st.text(max_size=20) | st.builds("{}={}".format, st.sampled_from(ROWS), PIECES), max_size=3))
def test_any_override_is_taken_or_refused(overrides):
    assert_loaded_or_refused(GOOD, overrides)


TREES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda parts: st.lists(parts, max_size=2) | st.dictionaries(st.text(max_size=5), parts, max_size=2),
    max_leaves=4,
)
PATHS = st.sampled_from(sorted(loads(GOOD).stated_keys | {parameter.path for parameter in DRIVING}))


@REPEATABLE
@given(st.dictionaries(PATHS, TREES, max_size=4))
def test_any_value_anywhere_is_taken_or_refused(overrides):
    assert_loaded_or_refused(GOOD, overrides)


def assert_loaded_or_refused(text, overrides):
    mistakes = mistakes_of(text, overrides)
    assert mistakes != ()
    for mistake in mistakes or ():
        assert 0 <= mistake.line <= len(text.splitlines()) + 1
        assert mistake.message.isprintable()
        assert mistake.message.endswith(")")


def mistakes_of(text, overrides):
    """Return the mistakes, or None where the scenario is loaded; any other exception fails the test."""
    try:
        loads(text, "s.yaml", overrides)
    except ScenarioError as error:
        return error.mistakes
    return None
