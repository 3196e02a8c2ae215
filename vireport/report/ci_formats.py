"""A study in the formats of systems that run jobs: JUnit's XML and annotations.

All is the same for the same study: there is no clock in it. What a scenario or a file's name says is text in every
format, and never markup.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote
from xml.etree import ElementTree

from vireport.study.judging.evidence import unmet_criteria
from vireport.text.alerts import Severity

if TYPE_CHECKING:
    from vireport.study.study import Study

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(study: Study, templates: Path | None = None) -> bytes:
    """Each requirement as a test case; without requirements, the one case that the scenario was solved.

    The verdict is in the words of a folder of templates, if there is one.
    """
    failures = str(len(unmet_criteria(study.criteria)))
    counts = {"tests": str(len(study.criteria) or 1), "failures": failures, "errors": "0"}
    name = study.scenario.title or Path(study.loaded.document.name).name
    suites = ElementTree.Element("testsuites", {"name": "vireport", **counts})
    suite = ElementTree.SubElement(suites, "testsuite", {"name": _xml(name), **counts, "skipped": "0"})
    if not study.criteria:
        ElementTree.SubElement(suite, "testcase", {"classname": "vireport", "name": "solved"})
    for criterion in study.criteria:
        title, limit, outcome = criterion.title, criterion.limit.text, criterion.outcome
        case = {"classname": "vireport.requirements", "name": _xml(f"{title}: {limit}")}
        case["file"] = _xml(study.loaded.document.name)
        if criterion.line is not None:
            case["line"] = str(criterion.line)
        element = ElementTree.SubElement(suite, "testcase", case)
        if not criterion.passed:
            message = {"message": _xml(f"{title}: {outcome.text}, required {limit}"), "type": criterion.key}
            ElementTree.SubElement(element, "failure", message).text = _xml(str(outcome.why))
    ElementTree.SubElement(suite, "system-out").text = _xml("\n".join(study.opening.worded(templates).text))
    ElementTree.indent(suites)
    return bytes(ElementTree.tostring(suites, "utf-8", xml_declaration=True)) + b"\n"


def _xml(text: str) -> str:
    """Replace what XML has no way to write."""
    return _NOT_IN_XML.sub("\ufffd", text)


def github(study: Study) -> str:
    """Annotations of GitHub Actions: an error for each requirement that is not met, and alerts by their severity."""
    lines = []
    for criterion in unmet_criteria(study.criteria):
        why = f": {criterion.outcome.why}" if criterion.outcome.why else ""
        message = f"{criterion.outcome.text}, required {criterion.limit.text}{why}"
        lines.append(_annotation("error", _place(study, criterion.line), str(criterion.title), message))
    lines += [
        _annotation(alert.severity, _place(study, None), f"{alert.code} {alert.title}", f"{alert.cause} {alert.remedy}")
        for alert in study.alerts
        if alert.severity is not Severity.NOTE
    ]
    return "".join(f"{line}\n" for line in lines)


def _place(study: Study, line: int | None) -> dict[str, str]:
    """File and line, as far as there are any: standard input has no file, an override no line."""
    name = study.loaded.document.name
    if name.startswith("<"):
        return {}
    file = {"file": _from_root(Path(name)).as_posix()}
    return file if line is None else {**file, "line": str(line)}


def _from_root(path: Path) -> Path:
    """A path as the job's system counts it: from the root of the repository, where that is known."""
    try:
        root, whole = Path(os.environ.get("GITHUB_WORKSPACE") or Path.cwd()).resolve(), path.resolve()
    except FileNotFoundError:  # the current folder has been deleted
        return path
    return whole.relative_to(root) if whole.is_relative_to(root) else path


def _annotation(level: str, place: dict[str, str], title: str, message: str) -> str:
    properties = {**place, "title": title}
    text = ",".join(f"{key}={_escaped(value, ':,')}" for key, value in properties.items())
    return f"::{level} {text}::{_escaped(message, '')}"


def _escaped(text: str, more: str) -> str:
    """Write as %XX what would end an annotation or one of its properties."""
    plain = text.encode("utf-8", "replace").decode()  # a name of bytes that are not UTF-8 cannot be printed
    return "".join(f"%{ord(x):02X}" if x in f"%\r\n{more}" else x for x in plain)


def source_url(study: Study) -> str:
    """Address of the scenario on the site that runs the job, of the commit that is checked out; "" elsewhere."""
    server, repository, commit = map(os.environ.get, ("GITHUB_SERVER_URL", "GITHUB_REPOSITORY", "GITHUB_SHA"))
    place = _place(study, None)
    if not (place and server and repository and commit):
        return ""
    return f"{server}/{repository}/blob/{commit}/{quote(place['file'])}"
