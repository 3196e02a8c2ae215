"""Templates that an earlier run has compiled: they say what they say now, whatever is in the folder of that run."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

import vireport.text.templates as module
from vireport.text.formatting import percent
from vireport.text.templates import environment_of

WORDS = "words/verdict.j2"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for temporary files."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    return tmp_path / "temporary"


def said(templates: Path, name: str = "said.j2") -> str:
    """What a template of a folder says to a new process."""
    return environment_of(templates).get_template(name).render(share=0.5)


def test_a_changed_template_and_a_changed_filter_say_what_they_say_now(tmp_path, folder, monkeypatch) -> None:
    template = tmp_path / "said.j2"
    template.write_text("{{ 0.5 | percent }} and {{ share | percent }}", encoding="utf-8")
    before = said(tmp_path)
    assert said(tmp_path) == before == f"{percent(0.5)} and {percent(0.5)}"
    assert list(folder.rglob("vireport-*.cache"))
    # What is constant is written as a template is filled, too: nothing of a filter is in what is kept.
    monkeypatch.setitem(module.FILTERS, "percent", lambda share: "half")
    assert said(tmp_path) == "half and half"
    template.write_text("{{ share | exact }}", encoding="utf-8")
    assert said(tmp_path) == "0.5"


def test_what_is_kept_is_of_one_way_to_read_templates(tmp_path, folder) -> None:
    (tmp_path / "said.j2").write_text("one line\n", encoding="utf-8")
    for _ in range(2):
        assert said(tmp_path) == "one line"
        assert environment_of(tmp_path, keep_trailing_newline=True).get_template("said.j2").render() == "one line\n"


def test_without_a_folder_or_with_a_spoilt_one_templates_are_compiled(tmp_path, folder) -> None:
    (tmp_path / "said.j2").write_text("{{ share }}", encoding="utf-8")
    assert said(tmp_path) == "0.5"
    (kept,) = folder.rglob("vireport-*.cache")
    for spoilt in (b"", b"spoilt", kept.read_bytes()[:-9]):
        kept.write_bytes(spoilt)
        assert said(tmp_path) == "0.5"
    kept.unlink()
    kept.parent.rmdir()
    folder.rmdir()
    folder.write_text("not a folder", encoding="utf-8")
    assert said(tmp_path) == "0.5"
