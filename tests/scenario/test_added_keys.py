"""Keys that an addition brings stand in a scenario behind the others; a map refuses the blocks that it cannot have."""

from __future__ import annotations

import copy

import pytest
from pydantic import ValidationError

from vireport.scenario import keys
from vireport.scenario.keys import Block, WhenGiven, block_of, key, names_in_order, value_at
from vireport.study.plan import AddedTask


class SpringsBlock(Block):
    count: int = key(2, "Count", "1", "How many.", ge=1)


class Sheet(Block):
    title: str | None = key(None, "Title", "", "Free text.")
    author: str | None = key(None, "Author", "", "Free text.")


@pytest.fixture
def springs(monkeypatch: pytest.MonkeyPatch) -> None:
    springs = key(None, "Springs", "", "Left out, there are none.", in_map="a map has no springs (delete them)")
    known = {
        "springs": (WhenGiven[SpringsBlock] | None, springs),
        "sheet.count": (int | None, key(None, "Count", "1", "How many.", behind="title", ge=1)),
    }
    monkeypatch.setattr(keys, "declared", lambda what: [known] if what == "keys" else [])


def test_a_block_of_an_addition_stands_behind_those_of_the_scenario(springs) -> None:
    sheet = keys.with_added_keys(Sheet)
    assert list(sheet.model_fields) == ["title", "author", "springs"]
    assert (sheet.__name__, sheet.__doc__) == (Sheet.__name__, Sheet.__doc__)
    assert block_of(sheet.model_validate({"springs": {"count": 3}}), "springs", SpringsBlock).count == 3
    assert block_of(sheet.model_validate({}), "springs", SpringsBlock) is None
    for wrong in ({"springs": {"count": 0}}, {"springs": {"number": 1}}):
        with pytest.raises(ValidationError):
            sheet.model_validate(wrong)


def test_a_key_of_an_addition_stands_behind_the_one_that_it_names(springs) -> None:
    sheet = keys.with_added_keys(Sheet, "sheet")
    assert names_in_order(sheet) == ["title", "count", "author"]
    assert value_at(sheet.model_validate({"count": 3}), "count") == 3
    assert value_at(Sheet.model_validate({}), "count") is None
    with pytest.raises(ValidationError):
        sheet.model_validate({"count": 0})


def test_a_map_refuses_the_block_of_an_addition(springs) -> None:
    of_map = keys.without_added_keys(keys.with_added_keys(Sheet))
    assert of_map.model_fields["springs"].description == "a map has no springs (delete them)"
    with pytest.raises(ValidationError):
        of_map.model_validate({"springs": {"count": 3}})


def test_without_additions_a_block_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keys, "declared", lambda what: [])
    assert keys.with_added_keys(Sheet) is Sheet
    assert keys.without_added_keys(Sheet) is Sheet


def test_a_copy_of_a_step_knows_what_it_is() -> None:
    task = copy.deepcopy(AddedTask("springs", "how many springs there are"))
    assert (task, task.what) == ("springs", "how many springs there are")
