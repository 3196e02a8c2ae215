"""Tables as text: aligned, and broken where a column has a width."""

from __future__ import annotations

from vireport.text.tables import LINE, Column, Table, broken, numbers, plain_table, plain_text, texts

TABLE = Table(
    "Motions", (*texts("Name"), *numbers("Ż [y_c]")), (("B1 | G1", "−0.5"), ("C1", "1 × 10⁻⁶")), "Velocities."
)


def test_columns_are_aligned_by_their_kind() -> None:
    assert plain_table(TABLE).splitlines() == ["Name       Ż [y_c]", "B1 | G1       −0.5", "C1        1 × 10⁻⁶"]


def test_a_cell_is_broken_at_the_width_of_its_column_but_not_at_a_minus() -> None:
    table = Table("", (Column("a", width=9), Column("b")), (("below 1e-12 or 1e-9", "x"),))
    assert plain_table(table).splitlines() == ["a         b", "below     x", "1e-12 or", "1e-9"]


def test_a_table_without_rows_has_its_head() -> None:
    empty = Table("", texts("a", "b"), ())
    assert plain_table(empty) == "a    b"


def test_text_has_paragraphs_captions_and_notes() -> None:
    text = plain_text(("word " * 40, TABLE))
    assert max(map(len, text.splitlines())) <= 110
    assert "\n\nMotions\nName" in text
    assert text.endswith("\nVelocities.")


def test_no_line_of_a_paragraph_begins_with_a_unit() -> None:
    for start in range(LINE):
        lines = broken(f"{'x' * start} margin 4.7 % in frequency, 42.84 kV").splitlines()
        assert not [line for line in lines if line.startswith(("%", "kV"))]
