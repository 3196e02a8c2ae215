"""Every broken scenario is refused with all its mistakes, by line and key, in one go."""

from __future__ import annotations

import pytest
from bad_scenarios import BAD_SCENARIOS, GOOD, Bad

from vireport.base.errors import ScenarioError
from vireport.scenario import loads


def refusal(text: str | bytes) -> ScenarioError:
    with pytest.raises(ScenarioError) as caught:
        loads(text, "bad.yaml")
    return caught.value


def test_the_scenario_that_is_broken_is_good():
    assert loads(GOOD).scenario.title == "Good"


def test_names_are_unique_and_cases_many():
    assert len({case.name for case in BAD_SCENARIOS}) == len(BAD_SCENARIOS) >= 60


@pytest.mark.parametrize("case", BAD_SCENARIOS, ids=lambda case: case.name)
def test_every_mistake_is_named_by_line_and_key_in_one_line_of_our_words(case: Bad):
    error = refusal(case.text)
    assert error.exit_code == 2
    assert [(mistake.line, mistake.path) for mistake in error.mistakes] == [found[:2] for found in case.expected]
    for mistake, (line, path, fragment) in zip(error.mistakes, case.expected, strict=True):
        assert fragment in mistake.message
        assert mistake.render("bad.yaml").startswith(f"bad.yaml:{line}: {path}: " if path else f"bad.yaml:{line}: ")
    rows = str(error).split("\n")
    assert len(rows) == len(case.expected)
    for row in rows:
        assert row.isprintable()
        assert len(row) < 400
        assert not any(foreign in row for foreign in ("Input should", "pydantic", "while scanning", "<block end>"))
        assert row.endswith(")")


def test_a_mistake_in_every_line_is_found_in_every_line():
    keys = [f"key_{i}: {i}" for i in range(200)]
    mistakes = refusal(GOOD + "\n".join(keys)).mistakes
    assert [mistake.line for mistake in mistakes] == list(range(20, 220))
