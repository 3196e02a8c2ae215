"""What is said of proofs of the critical points."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace

from branches import say_every_branch

from vireport.cli.app import main


def thing(**of: object) -> SimpleNamespace:
    return SimpleNamespace(**of)


def point(label: str, **of: object) -> SimpleNamespace:
    return thing(**{"label": label, "proved": True, "bound_holds": True, "mirror_proved": None, "beyond": ()} | of)


def points(*of: SimpleNamespace) -> tuple[list[SimpleNamespace]]:
    return (list(of),)


SAID: list[tuple[str, tuple[object, ...]]] = [
    ("between", (None,)),
    ("unproved", (thing(reason="it is degenerate"),)),
    ("notes", (thing(radius=1e-10, side="stable above", admissible=True),)),
    ("notes", (thing(radius=1e-10, side="", admissible=False),)),
    ("summary", points()),
    ("summary", points(point("B1"))),
    ("summary", points(point("B1", proved=False))),
    (
        "summary",
        points(point("B1", bound_holds=False, mirror_proved=False), point("C1", mirror_proved=True, beyond=("d", "q"))),
    ),
    ("summary", points(point("B1", beyond=("d",)), point("C1", beyond=("q",)))),
]


def test_every_branch_of_the_words_is_said() -> None:
    say_every_branch(*(("certificates", *row) for row in SAID))


def test_a_proof_that_cannot_be_made_is_refused_before_work_begins(example, monkeypatch, capsys) -> None:
    monkeypatch.setattr(import_module("vireport.study.plan"), "find_spec", lambda name: None)
    monkeypatch.setattr("vireport.cli.outputs.analyse", None)
    assert main(["run", str(example("inclined")), "--json", "--certify"]) == 3
    said = "vireport: error: --certify: the package python-flint is missing: pip install 'vireport[certify]'\n"
    assert capsys.readouterr().err == said
