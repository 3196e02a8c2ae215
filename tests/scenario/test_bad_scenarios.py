"""Every broken scenario is refused with all its mistakes, by line and key, in one go."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, get_args, get_origin

import pytest
from bad_scenarios import BAD_SCENARIOS, GOOD, Bad
from pydantic import BaseModel, TypeAdapter, ValidationError

from vireport.base.errors import ScenarioError
from vireport.scenario import hints
from vireport.scenario.blocks import Scenario
from vireport.scenario.loading import loads
from vireport.scenario.map_file import MapFile


def refusal(text: str | bytes) -> ScenarioError:
    with pytest.raises(ScenarioError) as caught:
        loads(text, "bad.yaml")
    return caught.value


def test_the_scenario_that_is_broken_is_good():
    assert loads(GOOD).scenario.title == "Good"


def test_each_case_is_another_and_there_are_many():
    assert len({case.text for case in BAD_SCENARIOS}) == len(BAD_SCENARIOS) >= 60


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
    free = [TypeAdapter(type_) for type_ in texts_of(model)]
    assert free
    for key in free:
        assert key.validate_python("caf\xe9: \U0001f600") == "caf\xe9: \U0001f600"
        for text in ("a\u202eb", "a\x1b[31mb", "two\nlines", " \xa0", "", 201 * "a"):
            with pytest.raises(ValidationError):
                key.validate_python(text)


def texts_of(kind: Any) -> Iterator[Any]:
    """The types of text, with what they are held to, that a type is made of; not the patterns and enumerations."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated and parts[0] is str:
        # Where a key has such a type by itself, pydantic keeps what it is held to beside the type.
        held = [own for field in parts[1:] for own in (field, *getattr(field, "metadata", []))]
        if not any(getattr(own, "pattern", None) for own in held):
            yield kind
    elif kind is str:
        yield kind
    elif isinstance(kind, type) and issubclass(kind, BaseModel):
        for field in kind.model_fields.values():
            yield from texts_of(Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation)
    else:
        for part in parts:
            yield from texts_of(part)


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
