"""What `--format` of each command allows, and what it says of the rest."""

from __future__ import annotations

from pathlib import Path

import pytest

from vireport.base.errors import UsageError
from vireport.chart import outputs as charts
from vireport.cli import outputs
from vireport.cli.app import main
from vireport.cli.formats import FORMATS, formats_of
from vireport.comparison.outputs import COMPARISON_FILES
from vireport.maps.outputs import MAP_FILES
from vireport.optimise import outputs as searches
from vireport.study.plan import ALL_FORMATS
from vireport.study.plan import FORMATS as OF_RUNS

FILES = {
    "run": outputs.NAMES,
    "compare": COMPARISON_FILES,
    "map --over": charts.CHART_FILES,
    "map": MAP_FILES,
    "optimise": searches.OPTIMISE_FILES,
}
LINES = {
    "run": ["design-point.yaml"],
    "check": ["design-point.yaml"],
    "compare": ["design-point.yaml", "--vary", "inclination_deg=30,40"],
    "map --over": ["inclined.yaml", "--over", "length_m,inclination_deg"],
    "map": ["maps/map.yaml"],
    "optimise": ["best-design.yaml"],
}
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def test_a_command_allows_what_it_has_files_for() -> None:
    for command, files in FILES.items():
        assert set(files) == set(FORMATS[command].allowed) - {"github"}, command
        assert set(FORMATS[command].usual) <= set(files)
    assert set(FORMATS["run"].allowed) == set(ALL_FORMATS)
    assert FORMATS["run"].usual == OF_RUNS


@pytest.mark.parametrize("command", FORMATS)
def test_every_format_that_a_command_lacks_is_refused_with_those_that_it_has(command, tmp_path, capsys) -> None:
    file, *others = LINES[command]
    lacking = set(ALL_FORMATS) - set(FORMATS[command].allowed)
    for word in sorted(lacking):
        line = [command.split()[0], str(EXAMPLES / file), *others, "--format", f"html,{word}"]
        out = [] if command == "check" else ["-o", str(tmp_path / "out")]
        assert main([*line, *out]) == 2
        said = capsys.readouterr().err
        assert f"vireport {command} has no {word}" in said
        assert f"(allowed: {', '.join(FORMATS[command].allowed)}; " in said
        assert "vireport run" in said
    assert not (tmp_path / "out").exists()


def test_a_word_that_is_no_format_and_no_word_at_all_are_refused() -> None:
    with pytest.raises(UsageError, match=r"unknown 'docx' \(allowed: html, pdf, png, svg, figure-pdf, json, markdown"):
        formats_of("map --over", ["html,docx"])
    with pytest.raises(UsageError, match="no format is named"):
        formats_of("run", [","])


def test_formats_come_in_the_order_of_the_table_and_once() -> None:
    assert formats_of("run", ["json , html", "html"]) == ("html", "json")
    assert formats_of("map", None) == ("html", "pdf", "png")
