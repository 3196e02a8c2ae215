"""Scenarios as text: writes a scenario that a program has changed as a file that can be run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import yaml

from vireport.scenario.blocks import Scenario, to_dict

OF_DEVICE = "schema_version", "title", "device", "excitation", "inclination_deg", "gravity_m_s2", "period_ratio"
"""Keys of a scenario that describe the device; the others ask for results."""


def as_yaml(data: Mapping[str, object]) -> str:
    """Write the data of a scenario as YAML, in its order and without what is absent.

    Parameters
    ----------
    data : mapping
        Values by the names of the file, as `to_dict` returns them; None is left out.
    """
    return str(yaml.safe_dump(_present(data), sort_keys=False, allow_unicode=True))


def _present(data: Mapping[str, object]) -> dict[str, object]:
    kept = {key: value for key, value in data.items() if value is not None}
    return {key: _present(value) if isinstance(value, Mapping) else value for key, value in kept.items()}


def names_records(scenario: Scenario) -> bool:
    """Whether a scenario names files with records."""
    return scenario.excitation.record is not None or scenario.measured is not None


def with_paths(data: Mapping[str, Any], moved: Callable[[str], str]) -> dict[str, object]:
    """The data of a scenario, as `to_dict` returns it, with the paths of its records changed by a function."""
    tree = dict(data)
    if tree["excitation"]["record"] is not None:
        tree["excitation"] = tree["excitation"] | {"record": moved(tree["excitation"]["record"])}
    if tree["measured"] is not None:
        tree["measured"] = [record | {"impacts": moved(record["impacts"])} for record in tree["measured"]]
    return tree


def device_tree(scenario: Scenario, values: Mapping[str, object]) -> dict[str, object]:
    """The scenario of a device alone, with other values of some keys, which are given by their paths."""
    all_keys = to_dict(scenario)
    tree = {name: all_keys[name] for name in OF_DEVICE} | {"excitation": all_keys["excitation"] | {"record": None}}
    for path, value in values.items():
        block, _, key = path.rpartition(".")
        (tree[block] if block else tree)[key] = value
    return tree
