"""What `--format` of each command allows, and what it says of the rest."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

from vireport.base.additions import adding
from vireport.base.errors import UsageError
from vireport.cli import outputs
from vireport.cli.app import main
from vireport.cli.commands import CHECK
from vireport.cli.declared import declared_command, formats_of
from vireport.cli.formats import RUN
from vireport.study.plan import ALL_FORMATS
from vireport.study.plan import FORMATS as OF_RUNS

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
FILES = {
    "compare": ("comparison", "COMPARISON_FILES"),
    "map --over": ("map", "CHART_FILES"),
    "map": ("map", "CELL_FILES"),
    "identify": ("identify", "IDENTIFY_FILES"),
    "paper": ("paper", "PAPER_FILES"),
    "optimise": ("optimise", "OPTIMISE_FILES"),
}
LINES = {
    "run": ["design-point.yaml"],
    "check": ["design-point.yaml"],
    "compare": ["design-point.yaml", "--vary", "inclination_deg=30,40"],
    "map --over": ["inclined.yaml", "--over", "length_m,inclination_deg"],
    "map": ["maps/map.yaml"],
    "identify": ["measured.yaml", "--impacts", str(EXAMPLES / "measured-impacts.csv")],
    "optimise": ["best-design.yaml"],
    "paper": [],
}
DECLARED = {formats.command: formats for name in adding("command") for formats in declared_command(name).formats}
FORMATS = {"run": RUN, "check": CHECK, **DECLARED}


def test_a_command_allows_what_it_has_files_for() -> None:
    assert set(RUN.allowed) == set(ALL_FORMATS) == set(outputs.NAMES) | {"github"}
    assert RUN.usual == OF_RUNS
    for command, formats in DECLARED.items():
        package, name = FILES[command]
        files = getattr(import_module(f"vireport.{package}.outputs"), name)
        assert set(files) == set(formats.allowed), command
        assert set(formats.usual) <= set(files)


@pytest.mark.parametrize("command", FORMATS)
def test_every_format_that_a_command_lacks_is_refused_with_those_that_it_has(command, tmp_path, capsys) -> None:
    words = LINES[command]
    arguments = [str(EXAMPLES / words[0]), *words[1:]] if words else []
    lacking = set(ALL_FORMATS) - set(FORMATS[command].allowed)
    for word in sorted(lacking):
        line = [command.split()[0], *arguments, "--format", f"html,{word}"]
        out = [] if command == "check" else ["-o", str(tmp_path / "out")]
        assert main([*line, *out]) == 2
        said = capsys.readouterr().err
        assert f"vireport {command} has no {word}" in said
        assert f"(allowed: {', '.join(FORMATS[command].allowed)}; " in said
        assert "vireport run" in said
    assert not (tmp_path / "out").exists()


def test_a_word_that_is_no_format_and_no_word_at_all_are_refused() -> None:
    with pytest.raises(
        UsageError, match=r"unknown 'docx' \(allowed: html, pdf, png, json, csv, svg, figure-pdf, junit"
    ):
        formats_of(RUN, ["html,docx"])
    with pytest.raises(UsageError, match="no format is named"):
        formats_of(RUN, [","])


def test_formats_come_in_the_order_of_the_table_and_once() -> None:
    assert formats_of(RUN, ["json , html", "html"]) == ("html", "json")
    assert formats_of(RUN, None) == OF_RUNS
