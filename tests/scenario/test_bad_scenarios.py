"""Every broken scenario is refused with all its mistakes, by line and key, in one go."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from bad_scenarios import BAD_SCENARIOS, GOOD, Bad

from vireport.base.errors import ScenarioError
from vireport.scenario import hints
from vireport.scenario.blocks import MapFile, Scenario
from vireport.scenario.declared import Block, Finding, Key, Kind, read_value
from vireport.scenario.loading import loads


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
    assert [(mistake.line, mistake.path) for mistake in error.mistakes] == [place[:2] for place in case.expected]
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


@pytest.mark.parametrize("model", [Scenario, MapFile])
def test_every_key_that_holds_free_text_is_held_to_printable_text(model: type):
    """By its type, so that a new one cannot be forgotten; words, labels and choices are held to their patterns."""
    free = list(texts_of(model))
    assert free
    for key in free:
        assert mistakes_in(key, "caf\xe9: \U0001f600") == []
        for text in ("a\u202eb", "a\x1b[31mb", "two\nlines", " \xa0", "", 201 * "a"):
            assert mistakes_in(key, text) == [Finding("key", Kind.VALUE, text)]


def mistakes_in(key: Key, value: object) -> list[Finding]:
    findings: list[Finding] = []
    read_value(key, value, findings, "key")
    return findings


def texts_of(block: type[Block]) -> Iterator[Key]:
    """The keys of text in a block and in those within it; not those with patterns."""
    for key in block.keys.values():
        if issubclass(key.type.kind, Block):
            yield from texts_of(key.type.kind)
        elif key.type.kind is str and not key.type.text.pattern:
            assert not key.type.many
            yield key


def test_of_a_mistake_in_every_line_the_first_ones_are_told_and_the_others_counted():
    keys = [f"key_{i}: {i}" for i in range(200)]
    refused = refusal(GOOD + "\n".join(keys))
    assert [mistake.line for mistake in refused.mistakes] == list(range(20, 40))
    assert (refused.more, refused.lines[-1]) == (180, f"{refused.name}: and 180 more (mend these first)")


def test_what_was_meant_is_looked_for_of_the_first_unknown_keys_alone(monkeypatch):
    asked = []
    monkeypatch.setattr(hints, "for_key", lambda block, key, *_: asked.append(key) or "; is it not?")
    mistakes = refusal(GOOD + "\n".join(f"key_{i}: {i}" for i in range(200))).mistakes
    assert asked == [f"key_{i}" for i in range(20)]
    assert all("is it not?" in mistake.message for mistake in mistakes)
