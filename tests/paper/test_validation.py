"""What others have published is computed again, to its last digit; and a digit that is wrong is not taken for right."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vireport.cli.app import main
from vireport.paper import validation
from vireport.paper.validation import RESULTS, THE_PAPER, ValidatedNumber, ValidationRow, validation_table

COMPUTED = {
    "bouncing ball": (
        *(2.322046743958, 2.789800610801, 1.691626813471, 2.127333687233, 1.047197551197, 1.526823700519),
        *(0.3490658503989, 1.070836468248, 0.6981317007977, 1.229728281156, 0.4960409453037, 1.118751294517),
    ),
    "Mehta, Luck": (3.296908309476, 3.724191778237),
    "course FI3104B": (1.670269622187, 1.729801445692, 1.743244262980),
    "energy sink": (0.2075841303858, 0.1338258496932, 0.07055922843267, 0.03348751132952),
    "(5.2)-(5.5)": (105363.0384636, 27085.18678603, 122445.5190255, 48470.53158401, 148154.7078838, 40189.45664228),
    "fixed steps": tuple(ours for ours in (0.7152606358998, 1.004004740628, 0.8027403076062) for _ in range(2)),
}
"""Our numbers, by their sources, where a result is a single one; lists are compared with as many digits."""

LISTED = {"(1.8, 0.75, 1.5)": 32, "(2, 0.5, 2)": 40, "(2, 0.778, 1)": 21, "(2, 0.80, 1)": 47, "(2, 0.81, 1)": 20}
LISTED |= {"(2, 0.89, 1)": 10}
"""How many motions there are in each list."""

PASSING = 5
"""Of the fourth list, those that are none."""


RECORDED = json.loads((Path(__file__).parents[2] / "benchmarks/results/validation.json").read_text(encoding="utf-8"))
"""What docs/validation.md is made from."""


def rows_of(name: str) -> list[ValidationRow]:
    ((source, results),) = (pair for pair in RESULTS if pair[0].name == name)
    return [ValidationRow(source, what, numbers) for what, numbers in results()]


def require_agreement_as_recorded(name: str, rows: list[ValidationRow]) -> None:
    assert [row.what for row in rows if not row.agrees] == []
    recorded = [tuple(cells[1:4]) for cells in RECORDED["rows"] if cells[0] == name]
    assert [(row.what, row.published, row.computed) for row in rows] == recorded


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("Mehta, Luck", "fixed steps") else pytest.param(name, marks=pytest.mark.slow)
        for name in COMPUTED
    ],
)
def test_what_is_published_is_computed_again(name: str) -> None:
    rows = rows_of(name)
    require_agreement_as_recorded(name, rows)
    single = [row.numbers[0].ours for row in rows if len(row.numbers) == 1]
    assert single == pytest.approx(COMPUTED[name], rel=1e-12)


@pytest.mark.slow
def test_every_listed_motion_is_one_of_ours_but_for_those_that_pass_through_the_table() -> None:
    rows = rows_of("Church, Fortin")
    require_agreement_as_recorded("Church, Fortin", rows)
    whole = {row.what.partition("list ")[2]: len(row.numbers) for row in rows if len(row.numbers) > 1}
    assert whole == {name: 4 * count for name, count in LISTED.items()}
    (passing,) = (row.numbers[0] for row in rows if len(row.numbers) == 1)
    assert (passing.published, passing.ours) == (str(PASSING), PASSING)


def test_a_sink_has_two_motions_at_the_small_amplitude_and_one_at_the_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(validation, "SINK_RESTITUTIONS", (0.65,))
    motions, _ = rows_of("energy sink")
    assert len(motions.numbers) == 2 * 3
    assert motions.agrees


def test_readings_of_fixed_steps_come_nearer_as_the_steps_do() -> None:
    """An impact is read up to a step too early: a tenth of the step leaves a tenth of the difference."""
    numbers = [row.numbers[0] for row in rows_of("fixed steps")]
    for coarse, fine in zip(numbers[::2], numbers[1::2], strict=True):
        assert 8 < coarse.difference / fine.difference < 11.5
        assert max(coarse.value, fine.value) < fine.ours


def test_a_wrong_digit_of_a_list_is_noticed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    head = "list,restitution,amplitude_m,t0_s,w0_m_s,t1_s,w1_m_s,periods\n"
    right = "one,0.81,1.0,0.236943055,-4.905,1.236943055,-4.905,2\n"
    monkeypatch.setattr(validation, "LISTED_MOTIONS", tmp_path / "list.csv")
    validation.LISTED_MOTIONS.write_text(head + right + right.replace("55,", "56,", 1), encoding="utf-8")
    (row,) = rows_of("Church, Fortin")
    assert [number.agrees for number in row.numbers] == [True, True, True, True, False, True, True, True]


def test_a_number_agrees_to_its_last_digit() -> None:
    assert ValidatedNumber.printed("0.7153", 0.71526064).agrees
    assert not ValidatedNumber.printed("0.7153", 0.71524).agrees
    assert ValidatedNumber.printed("-13.8337596", -13.83375964).agrees
    assert ValidatedNumber.of_formula(2.0, 2.0 * (1 + 5e-13)).agrees
    assert not ValidatedNumber.of_formula(2.0, 2.0 * (1 + 2e-12)).agrees
    assert ValidatedNumber.between("1.6700", "1.6705", 1.6705).agrees
    assert not ValidatedNumber.between("1.6700", "1.6705", 1.6706).agrees
    assert not ValidatedNumber.printed("1", float("inf")).agrees


def test_the_table_has_a_row_for_each_result() -> None:
    source = RESULTS[0][0]
    one, wrong = ValidatedNumber.printed("0.7153", 0.71526064), ValidatedNumber.between("1.67", "1.68", 1.69)
    rows = [
        ValidationRow(source, "v", (one,)),
        ValidationRow(source, "w", (wrong,)),
        ValidationRow(source, "x", (one, wrong)),
        ValidationRow(THE_PAPER, "y", (wrong,)),
    ]
    table = validation_table(rows)
    assert table.caption == "Published results: 1 of 4 agree"
    assert table.rows == (
        (source.name, "v", "0.7153", "0.71526", "0.000039", "agrees"),
        (source.name, "w", "1.67 to 1.68", "1.69", "0.01", "differs"),
        (source.name, "x", "2 numbers", "1 agree", "0.01", "differs"),
        ("the paper", "y", "1.67 to 1.68", "1.69", "0.01", "misprint"),
    )


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [False, True])
def test_the_command_prints_the_paper_first_and_fails_where_anything_else_differs(
    wrong: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    number = ValidatedNumber.printed("0.7153", 0.72 if wrong else 0.71526064)
    monkeypatch.setattr(validation, "RESULTS", ((RESULTS[0][0], lambda: iter([("v", (number,))])),))
    assert main(["paper", "--validate"]) == 3 * wrong
    said = capsys.readouterr()
    lines = said.out.splitlines()
    assert lines[0] == f"Published results: {22 if wrong else 23} of 32 agree"
    assert lines[2].split()[:3] == ["the", "paper", "C1"]
    assert sum(line.endswith("misprint") for line in lines) == 9
    assert lines[-1].split()[0] == "Church,"
    assert ("not as published: Church, Fortin, v" in said.err) is wrong


def test_validation_prints_a_table_and_writes_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "--validate", "-o", "out"]) == 2
    assert "--validate prints a table: leave out --output" in capsys.readouterr().err
