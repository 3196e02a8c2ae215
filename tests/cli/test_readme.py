"""What the README says is true: its Python runs, its YAML is valid, its files and commands exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from vireport import loads
from vireport.cli.app import app

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


def test_the_python_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {})
    out = capsys.readouterr().out
    assert "B1 period_doubling 0.6294571410117573" in out
    assert "stable node" in out


def test_the_scenario_is_valid() -> None:
    scenario, simulation = blocks("yaml")
    assert loads(scenario).scenario.simulation is None
    asked = loads(scenario + simulation.replace("5.31", "0.69")).scenario.simulation
    assert asked is not None
    assert asked.portraits == (0.69,)


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)]+)\)", TEXT):
        assert target.startswith("http") or (ROOT / target).exists(), target


def test_every_command_is_named() -> None:
    for command in app.registered_commands:
        name = command.name or (command.callback.__name__ if command.callback else "")
        assert f"vireport {name}" in TEXT, name
