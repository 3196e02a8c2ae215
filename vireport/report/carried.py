"""Reads the scenario and the results that a report carries. They are data: nothing of a report is run."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from io import BytesIO
from typing import Any

from msgspec import Struct

from vireport.base import UsageError, json_text
from vireport.text import visible

LARGEST = 1 << 25
"""Bytes beyond which a file is not read: reports have less than a tenth of it, and read as JSON it takes 25 times as
much memory."""


class Carried(Struct, frozen=True):
    """What a report was made of, and the results in it.

    Attributes
    ----------
    report : str
        Name of the report, for messages.
    scenario : str
        The scenario file.
    name : str
        Of that file.
    overrides : tuple of str
        What was set over it, as ``path=value``.
    results : mapping
        results.json, as data.
    """

    report: str
    scenario: str
    name: str
    overrides: tuple[str, ...]
    results: Mapping[str, Any]


def read_carried(path: str) -> Carried:
    """Read what a report in HTML or PDF carries.

    Raises
    ------
    UsageError
        Where the file cannot be read, or is no report of one scenario with its results.
    """
    shown = visible(path)
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST + 1)
    except OSError as error:
        raise UsageError(f"{shown}: cannot be read ({error.strerror})") from error
    if len(data) > LARGEST:
        raise UsageError(f"{shown}: is larger than {LARGEST >> 20} MiB, and no report")
    scenario, text = _of_pdf(data, shown) if data.startswith(b"%PDF-") else _of_page(data)
    if not scenario or not text:
        raise UsageError(
            f"{shown}: carries no scenario with its results (a report of 'vireport run' does, of this version or "
            "later; that of a comparison has several scenarios: run each from its file)"
        )
    try:
        results = json.loads(text)
        texts = (json.loads(scenario), results["provenance"]["scenario_name"], *results["overrides"])
        if not all(isinstance(text, str) for text in texts):
            raise TypeError("a text is none")
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise UsageError(f"{shown}: what it carries is damaged ({visible(str(error))})") from error
    return Carried(shown, texts[0], visible(texts[1]), texts[2:], results)


def _of_page(page: bytes) -> tuple[bytes, bytes]:
    """The scenario and the results of a page, as JSON; empty where there are none."""
    # Between these tags there is no other, as our JSON has no "<": a parser of HTML would read megabytes for two texts.
    opening = '<script type="application/json" id="%s-data">'
    after = (page.partition((opening % name).encode())[2] for name in ("scenario", "results"))
    scenario, results = (rest.partition(b"</script>")[0] for rest in after)
    return scenario, results


def _of_pdf(data: bytes, shown: str) -> tuple[bytes, bytes]:
    """The scenario and the results of a PDF, as JSON; empty where there are none."""
    import pypdf

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)  # what it mends in a damaged file is not for the user
    try:
        reader = pypdf.PdfReader(BytesIO(data))
        if reader.is_encrypted:
            raise UsageError(f"{shown}: is encrypted (a report as written is not)")
        files = reader.attachments
        if not {"scenario.yaml", "results.json"} <= set(files):
            return b"", b""
        return json_text(files["scenario.yaml"][0].decode()).encode(), files["results.json"][0]
    except UsageError:
        raise
    except Exception as error:  # a damaged file makes pypdf fail in any way
        raise UsageError(f"{shown}: is no PDF that can be read ({visible(str(error))})") from error
