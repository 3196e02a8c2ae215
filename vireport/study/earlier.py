"""Reads an earlier run from its results.json, or from a report in HTML or PDF: its scenario and its results.

They are data: nothing of a report is run.
"""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path

from msgspec import Struct

from vireport.base.encoding import json_text
from vireport.base.errors import UsageError
from vireport.base.reading import ReadingPlace
from vireport.scenario.loading import Loaded, loads
from vireport.text.foreign import visible

LARGEST = 1 << 26
"""Bytes beyond which a file is not read: results.json of over a thousand families has half as many."""

WHAT = "results.json or a report of 'vireport run'"


class Earlier(Struct, frozen=True):
    """What an earlier run was made of, and its results.

    Attributes
    ----------
    path : str
        The file that it was read from.
    scenario : str
        The scenario file; of results.json, the scenario as it was understood, as JSON.
    name : str
        Of the scenario file.
    overrides : tuple of str
        Values that replaced those of its scenario, as ``path=value``.
    results : mapping
        results.json, as data.
    """

    path: str
    scenario: str
    name: str
    overrides: tuple[str, ...]
    results: Mapping[str, object]

    @property
    def file(self) -> str:
        """Name of the file for messages."""
        return _printable(self.path)

    def loaded(self, overrides: Sequence[str] = (), allow_outside: bool = False) -> Loaded:
        """The scenario of the run, with more set over it; records that it names are beside the file.

        Parameters
        ----------
        overrides : sequence of str
            As ``path=value``.
        allow_outside : bool
            Whether its records may be outside of the folder of the file.

        Raises
        ------
        ScenarioError
            Where it cannot be used.
        """
        place = ReadingPlace(str(Path(self.path).parent), allow_outside)
        return loads(self.scenario, f"{self.file}/{self.name}", (*self.overrides, *overrides), place)


def earlier_run(path: str) -> Earlier | None:
    """Read an earlier run where a scenario may be named as well; None where the path is none of results or a report.

    Raises
    ------
    UsageError
        As `read_earlier` does.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".json", ".html", ".pdf") or not Path(path).is_file():
        return None
    if suffix == ".json" and b'"branches"' not in _contents(path):
        return None  # a scenario may be written in JSON
    return read_earlier(path)


def read_earlier(path: str) -> Earlier:
    """Read an earlier run from its results.json or its report, or from standard input where the path is "-".

    Raises
    ------
    UsageError
        Where the file cannot be read, or is none of a run of one scenario with its results.
    """
    file, data = _printable(path), _contents(path)
    if data.startswith(b"%PDF-"):
        return _carried(path, *_of_pdf(data, file))
    if data.lstrip().startswith(b"<"):
        return _carried(path, *_of_page(data))
    try:
        results = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file}: is no JSON ({visible(str(error))}); {WHAT} is meant") from error
    if not isinstance(results, dict):
        raise UsageError(f"{file}: is no results.json (a block of keys)")
    origin = results.get("provenance")
    name = origin.get("scenario_name") if isinstance(origin, dict) else None
    # Overrides are in the scenario already.
    return Earlier(path, json_text(results.get("scenario")), visible(str(name or "scenario")), (), results)


def _contents(path: str) -> bytes:
    try:
        if path == "-":
            data = sys.stdin.buffer.read(LARGEST + 1)
        else:
            with open(path, "rb") as file:
                data = file.read(LARGEST + 1)
    except OSError as error:
        raise UsageError(f"{_printable(path)}: cannot be read ({error.strerror})") from error
    if len(data) > LARGEST:
        raise UsageError(f"{_printable(path)}: is larger than {LARGEST >> 20} MiB, and neither {WHAT}")
    return data


def _printable(path: str) -> str:
    return "standard input" if path == "-" else visible(path)


def _carried(path: str, scenario: bytes, text: bytes) -> Earlier:
    """An earlier run from the scenario and the results that a report carries, as JSON."""
    file = _printable(path)
    if not scenario or not text:
        raise UsageError(
            f"{file}: carries no scenario with its results (a report of 'vireport run' does, of this version or "
            "later; that of a comparison has several scenarios: run each from its file)"
        )
    try:
        results = json.loads(text)
        texts = (json.loads(scenario), results["provenance"]["scenario_name"], *results["overrides"])
        if not all(isinstance(text, str) for text in texts):
            raise TypeError("a text is none")
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise UsageError(f"{file}: what it carries is damaged ({visible(str(error))})") from error
    return Earlier(path, texts[0], visible(texts[1]), texts[2:], results)


def _of_page(page: bytes) -> tuple[bytes, bytes]:
    """The scenario and the results of a page, as JSON; empty where there are none."""
    # Between these tags there is no other, as our JSON has no "<": a parser of HTML would read megabytes for two texts.
    opening = '<script type="application/json" id="%s-data">'
    after = (page.partition((opening % name).encode())[2] for name in ("scenario", "results"))
    scenario, results = (rest.partition(b"</script>")[0] for rest in after)
    return scenario, results


def _of_pdf(data: bytes, file: str) -> tuple[bytes, bytes]:
    """The scenario and the results of a PDF, as JSON; empty where there are none."""
    import pypdf

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)  # what it mends in a damaged file is not for the user
    try:
        reader = pypdf.PdfReader(BytesIO(data))
        if reader.is_encrypted:
            raise UsageError(f"{file}: is encrypted (a report as written is not)")
        files = reader.attachments
        if not {"scenario.yaml", "results.json"} <= set(files):
            return b"", b""
        return json_text(files["scenario.yaml"][0].decode()).encode(), files["results.json"][0]
    except UsageError:
        raise
    except Exception as error:  # a damaged file makes pypdf fail in any way
        raise UsageError(f"{file}: is no PDF that can be read ({visible(str(error))})") from error
