"""Blocks of keys: values held to their declarations, every mistake told, and records that stay as they are."""

from __future__ import annotations

import pickle

import pytest

from vireport.scenario.blocks import DeviceBlock, HarmonicBlock, RequirementsBlock, Scenario, SweepBlock
from vireport.scenario.declared import REQUIRED, Finding, Kind, read_block, to_dict

SWEEP = {"parameter": "length_m", "from": 1, "to": 2.5}
DEVICE = {"capsule_mass_kg": 0.1, "restitution": 0.5}


def test_a_whole_number_stands_for_a_number_and_a_word_for_its_choice() -> None:
    sweep = SweepBlock(**SWEEP)
    assert (type(sweep.from_), sweep.parameter.symbol, to_dict(sweep)) == (float, "s", SWEEP)


@pytest.mark.parametrize(
    ("values", "wrong"),
    [
        ({"order": 2.0, "percent": 5, "phase_deg": 0}, [("order", Kind.VALUE, 2.0)]),
        ({"order": True, "percent": 5, "phase_deg": 0}, [("order", Kind.VALUE, True)]),
        ({"order": 2, "percent": "5", "phase_deg": 0}, [("percent", Kind.VALUE, "5")]),
        ({"order": 2, "percent": 5, "phase_deg": 10**400}, [("phase_deg", Kind.VALUE, 10**400)]),
        ({"order": 2, "percent": 5, "phase": 0}, [("phase_deg", Kind.MISSING, None), ("phase", Kind.UNKNOWN, 0)]),
    ],
)
def test_every_mistake_of_a_block_is_told(values: dict[str, object], wrong: list[tuple[str, Kind, object]]) -> None:
    findings: list[Finding] = []
    read_block(HarmonicBlock, values, findings, "harmonics.0")
    told = [(own.path, own.kind, None if own.kind is Kind.MISSING else own.value) for own in findings]
    assert told == [(f"harmonics.0.{path}", kind, value) for path, kind, value in wrong]
    with pytest.raises(ValueError, match=wrong[0][0]):
        HarmonicBlock(**values)


@pytest.mark.parametrize(
    ("words", "paths"),
    [(["BT"], []), ([], ["words"]), (["BT"] * 9, ["words"]), (["BX"] * 9, [f"words.{k}" for k in range(9)])],
)
def test_a_list_is_wrong_in_its_values_or_in_their_number(words: list[str], paths: list[str]) -> None:
    findings: list[Finding] = []
    read_block(RequirementsBlock, {"words": words}, findings)
    assert [finding.path for finding in findings] == paths


def test_blocks_are_frozen_and_equal_where_their_values_are() -> None:
    device = DeviceBlock(**DEVICE)
    assert (device, hash(device)) == (DeviceBlock(**DEVICE), hash(DeviceBlock(**DEVICE)))
    assert device != DeviceBlock(**DEVICE, length_m=1.0)
    assert pickle.loads(pickle.dumps(device)) == device
    assert repr(device) == "DeviceBlock(capsule_mass_kg=0.1, restitution=0.5)"
    assert device.replaced({"length_m": 1.0}) == DeviceBlock(**DEVICE, length_m=1.0)
    with pytest.raises(AttributeError, match="frozen"):
        del device.restitution


def test_keys_are_declared_in_the_order_of_the_format_with_those_that_must_be_given() -> None:
    required = [name for name, key in Scenario.keys.items() if key.default is REQUIRED]
    assert required == ["schema_version", "device", "excitation"]
