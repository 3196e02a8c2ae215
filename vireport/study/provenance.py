"""Where results come from: enough to make them again, and nothing that differs between two runs of one input.

There is no clock, no folder and no name of the machine in it.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from pathlib import PurePath
from typing import TYPE_CHECKING

from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.base.records import ResultsBlock
from vireport.base.version import __version__

if TYPE_CHECKING:
    from vireport.scenario.loading import Loaded, LoadedMap

NUMBERS = ("numpy", "pydantic_core", "yaml")
"""Libraries that the numbers pass through."""

COMPILER = "numba"
"""Compiles the simulation, where one is run."""

PAGES, DRAWINGS = ("jinja2", "typst"), ("matplotlib",)
"""Further ones that a report and its figures are made with."""


class Provenance(ResultsBlock, frozen=True):
    """What made the results: versions, scenario and command.

    Attributes
    ----------
    version, python
        versions of vireport and of Python
    scenario_name, scenario_sha256
        name of the scenario's file without its folder, and the SHA-256 of the file and of the overrides
    libraries
        versions of the libraries that the results depend on, by their names
    command
        the command that gives these results again
    timestamp
        ISO 8601, of `SOURCE_DATE_EPOCH`; null where that is not set
    """

    version: str
    scenario_name: str
    scenario_sha256: str
    python: str
    libraries: Mapping[str, str]
    command: str
    timestamp: str | None = None

    @property
    def epoch(self) -> int:
        """The timestamp in seconds since 1970; 0 where there is none."""
        return int(datetime.fromisoformat(self.timestamp).timestamp()) if self.timestamp else 0


def provenance_of(loaded: Loaded | LoadedMap, command: str) -> Provenance:
    """Record where the results of a scenario or a map come from.

    Parameters
    ----------
    loaded : Loaded or LoadedMap
    command : str
        As given, without folders.
    """
    compiled = loaded.scenario.simulation is not None and find_spec(COMPILER) is not None
    return Provenance(
        version=__version__,
        scenario_name=PurePath(loaded.document.name).name,
        scenario_sha256=loaded.sha256,
        python=".".join(map(str, sys.version_info[:3])),
        libraries=_versions((*NUMBERS, COMPILER) if compiled else NUMBERS),
        command=command,
        timestamp=_timestamp(),
    )


def provenance_of_several(scenarios: Sequence[Loaded], command: str, most_named: int) -> Provenance:
    """Record where the results of several scenarios come from; the hash is that of their hashes, each on a line.

    Parameters
    ----------
    scenarios : sequence of Loaded
    command : str
        As given, without folders.
    most_named : int
        Files up to which each is named; more are counted.
    """
    origins = [provenance_of(loaded, command) for loaded in scenarios]
    files = list(dict.fromkeys(origin.scenario_name for origin in origins))
    name = ", ".join(files) if len(files) <= most_named else f"{len(files)} files"
    hashes = "".join(f"{origin.scenario_sha256}\n" for origin in origins)
    libraries = dict(sorted(item for origin in origins for item in origin.libraries.items()))
    digest = sha256(hashes.encode()).hexdigest()
    return replace(origins[0], scenario_name=name, scenario_sha256=digest, libraries=libraries)


def with_pages(provenance: Provenance, drawn: bool) -> Provenance:
    """Add the libraries that a report is made with, with figures or without."""
    used = PAGES + DRAWINGS if drawn else PAGES
    return replace(provenance, libraries=dict(sorted({**provenance.libraries, **_versions(used)}.items())))


def _versions(names: tuple[str, ...]) -> dict[str, str]:
    """Versions as the modules state them: in the metadata of the packages, finding them takes far longer."""
    return {name: str(import_module(name).__version__) for name in names}


def _timestamp() -> str | None:
    text = os.environ.get("SOURCE_DATE_EPOCH")
    if not text:
        return None
    try:
        return datetime.fromtimestamp(int(text), UTC).isoformat()
    except (ValueError, OverflowError, OSError) as error:
        raise UsageError(f"SOURCE_DATE_EPOCH: {text!r} is not a number of seconds since 1970") from error
