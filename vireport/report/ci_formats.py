"""A study in the formats of systems that run jobs: JUnit's XML, annotations, and Markdown for the page of a job.

All is the same for the same study: there is no clock in it. What a scenario or a file's name says is text in every
format, and never markup.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from vireport.text import words

if TYPE_CHECKING:
    from vireport.gate import Criterion
    from vireport.study import Provenance, Study

OUTCOMES = {True: "met", False: "**NOT MET**"}

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_MARKS = re.compile(r"([\\`*_\[\]|~$])")
_BEFORE = {"&": "&amp;", "<": "&lt;", ">": "&gt;"}


def junit(study: Study) -> bytes:
    """Each requirement as a test case; without requirements, the one case that the scenario was solved."""
    failed = sum(not one.passed for one in study.criteria)
    counts = {"tests": str(len(study.criteria) or 1), "failures": str(failed), "errors": "0"}
    suites = ElementTree.Element("testsuites", {"name": "vireport", **counts})
    name = study.scenario.title or Path(study.loaded.document.name).name
    suite = ElementTree.SubElement(suites, "testsuite", {"name": _xml(name), **counts, "skipped": "0"})
    if not study.criteria:
        ElementTree.SubElement(suite, "testcase", {"classname": "vireport", "name": "solved"})
    for one in study.criteria:
        case = {"classname": "vireport.requirements", "name": _xml(f"{one.title}: {one.limit}")}
        case["file"] = _xml(study.loaded.document.name)
        if one.line is not None:
            case["line"] = str(one.line)
        element = ElementTree.SubElement(suite, "testcase", case)
        if not one.passed:
            message = {"message": _xml(f"{one.title}: {one.value_text}, required {one.limit}"), "type": one.key}
            ElementTree.SubElement(element, "failure", message).text = _xml(one.why)
    ElementTree.SubElement(suite, "system-out").text = _xml(study.verdict.headline)
    ElementTree.indent(suites)
    return bytes(ElementTree.tostring(suites, "utf-8", xml_declaration=True)) + b"\n"


def _xml(text: str) -> str:
    """Replace what XML has no way to write."""
    return _NOT_IN_XML.sub("\ufffd", text)


def github(study: Study) -> str:
    """Annotations of GitHub Actions: an error for each requirement that is not met, a warning for each such alert."""
    failed = (one for one in study.criteria if not one.passed)
    lines = [_annotation("error", _place(study, one), one.title, _message(one)) for one in failed]
    lines += [
        _annotation("warning", _place(study, None), f"{alert.code} {alert.title}", f"{alert.cause} {alert.remedy}")
        for alert in study.alerts
        if alert.severity == "warning"
    ]
    return "".join(f"{line}\n" for line in lines)


def _message(one: Criterion) -> str:
    return f"{one.value_text}, required {one.limit}{f': {one.why}' if one.why else ''}"


def _place(study: Study, one: Criterion | None) -> dict[str, str]:
    """File and line, as far as there are any: standard input has no file, what was set over a file no line."""
    name = study.loaded.document.name
    if name.startswith("<"):
        return {}
    line = one.line if one is not None else None
    file = _from_root(Path(name)).as_posix()
    return {"file": file} if line is None else {"file": file, "line": str(line)}


def _from_root(path: Path) -> Path:
    """A path as the job's system counts it: from the root of the repository, where that is known."""
    root, whole = Path(os.environ.get("GITHUB_WORKSPACE") or Path.cwd()).resolve(), path.resolve()
    return whole.relative_to(root) if whole.is_relative_to(root) else path


def _annotation(level: str, place: dict[str, str], title: str, message: str) -> str:
    properties = {**place, "title": title}
    given = ",".join(f"{key}={_escape(value, ':,')}" for key, value in properties.items())
    return f"::{level} {given}::{_escape(message, '')}"


def _escape(text: str, more: str) -> str:
    """Write as %XX what would end an annotation or one of its properties."""
    plain = text.encode("utf-8", "replace").decode()
    return "".join(f"%{ord(x):02X}" if x in f"%\r\n{more}" else x for x in plain)


def markdown(study: Study, provenance: Provenance) -> str:
    """The verdict, the acceptance table and the alerts."""
    return "\n".join(_markdown(study, provenance))


def _markdown(study: Study, provenance: Provenance) -> Iterator[str]:
    verdict = study.verdict
    title = study.scenario.title or Path(study.loaded.document.name).name
    yield f"## {_text(verdict.word)}: {_text(title)}\n"
    yield f"{_text(verdict.headline)}\n"
    if study.criteria:
        yield "| Requirement | Limit | Value | Margin | Outcome | Remark |"
        yield "|---|---|---|---|---|---|"
        for one in study.criteria:
            cells = [_text(words(cell)) for cell in (one.title, one.limit, one.value_text, one.margin_text)]
            yield f"| {' | '.join((*cells, OUTCOMES[one.passed], _text(words(one.why))))} |"
        yield ""
    for alert in study.alerts:
        cause = _text(words(f"{alert.cause} {alert.remedy}"))
        yield f"- **{alert.severity.capitalize()} {alert.code}: {_text(words(alert.title))}.** {cause}"
    if study.alerts:
        yield ""
    name, digest = _text(provenance.scenario_name), provenance.scenario_sha256
    yield f"vireport {_text(provenance.version)}, {name}, SHA-256 `{digest}`\n"


def _text(text: str) -> str:
    """Plain text on one line, with nothing in it that Markdown or HTML would read as markup."""
    plain = " ".join(text.encode("utf-8", "replace").decode().split())
    return _MARKS.sub(r"\\\1", "".join(_BEFORE.get(x, x) for x in plain))
