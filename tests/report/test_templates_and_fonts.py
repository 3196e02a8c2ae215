"""Templates of a user, which may fail in any way, and text that the fonts of the PDF do not have."""

from __future__ import annotations

import io
import os
import socket
import threading
from pathlib import Path

import pytest
from msgspec.structs import replace
from pages import render_html

from vireport import analyse, load
from vireport.base.errors import RenderError
from vireport.cli.app import main
from vireport.report.context import Report
from vireport.study.provenance import provenance_of

ROOT = Path(__file__).resolve().parents[2]
DESIGN = ROOT / "examples" / "design-point.yaml"

ALERTS = "sections/alerts.typ.j2"
MISTAKES = {
    "recursion": ("a\n{% macro f() %}{{ f() }}{% endmacro %}\n{{ f() }}", "report.typ.j2:2: RecursionError"),
    "filter": ("a\n{{ report.title | nofilter }}", "report.typ.j2:2: No filter named 'nofilter'"),
    "name": ("a\n\n{{ report.nothing.more }}", "report.typ.j2:3: "),
    "encoding": (b"a\n\xff", "report.typ.j2:2: has the byte 0xFF, which is not UTF-8"),
    "syntax": ("{{ ", "report.typ.j2:1: "),
    "arithmetic": ("{{ 1 / 0 }}", "report.typ.j2:1: ZeroDivisionError"),
    "other template": ("a\n{% include 'none.j2' %}", "report.typ.j2:2: no template 'none.j2'"),
    "itself": ("{% include 'report.typ.j2' %}", "report.typ.j2:1: RecursionError"),
    "name in a section": ("\n\n{{ nonsense }}", f"{ALERTS}:3: 'nonsense'"),
    "typst": ("a\n#nonsense", "report.typ.j2:2: unknown variable: nonsense"),
    "typst in a section": ("\n{{ report.title }}\n#nonsense", f"{ALERTS}:3: unknown variable: nonsense"),
    "typst in a loop": ("{% for k in [1, 2] %}\n{{ k }}\n\n#nonsense\n{% endfor %}", f"{ALERTS}:4: unknown variable"),
    "typst of ours called amiss": ("\n\n#tabular(3)", f"{ALERTS}:3: missing argument"),
    "typst after a text that decides": (
        "{% set x %}\n{% endset %}{% if x | trim %}a\nb\n{% endif %}\n#nonsense",
        f"{ALERTS}:5: unknown variable",
    ),
    "syntax in a section": ("\n\n{% if %}", f"{ALERTS}:3: Expected"),
}


@pytest.fixture(scope="module")
def report() -> Report:
    study = analyse(load(DESIGN))
    return Report(study, {}, provenance_of(study.loaded, "run"))


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_template_that_fails_is_named_with_its_line(mistake: str, report: Report, tmp_path: Path) -> None:
    text, message = MISTAKES[mistake]
    file = tmp_path / message.partition(":")[0]
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(RenderError) as caught:
        render_html(replace(report, templates=tmp_path))
    assert str(caught.value).startswith(message)
    assert "filled" not in str(caught.value)
    assert caught.value.exit_code == 3


@pytest.mark.slow
def test_nothing_is_written_where_a_template_fails(tmp_path: Path, capsys) -> None:
    text, message = MISTAKES["recursion"]
    (tmp_path / "report.typ.j2").write_text(text)
    out = tmp_path / "out"
    assert main(["run", str(DESIGN), "--templates", str(tmp_path), "-o", str(out), "--format", "html"]) == 3
    err = capsys.readouterr().err
    assert err.startswith(f"vireport: error: {message}")
    assert "fault of ours" not in err
    assert not out.exists()


@pytest.mark.slow
def test_typst_reaches_no_network(tmp_path: Path, capsys, monkeypatch) -> None:
    """A proxy on this machine, which everything would go through, is not asked."""
    asked = []
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(10)

        def answer() -> None:
            try:
                connection, _ = server.accept()
            except OSError:
                return
            asked.append(connection.recv(100))
            connection.close()

        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        for name in ("HTTPS_PROXY", "https_proxy", "ALL_PROXY"):
            monkeypatch.setenv(name, f"http://127.0.0.1:{server.getsockname()[1]}")
        before = dict(os.environ)
        (tmp_path / "report.typ.j2").write_text('a\n#import "@preview/none-such:9.9.9"')
        arguments = ["run", str(DESIGN), "--templates", str(tmp_path), "-o", str(tmp_path / "out"), "--format", "pdf"]
        assert main(arguments) == 3
        assert dict(os.environ) == before
        with socket.create_connection(server.getsockname()):  # let the thread go
            pass
        thread.join()
    assert asked == [b""]
    assert "packages are not loaded from the network" in capsys.readouterr().err


@pytest.mark.slow
def test_characters_that_the_fonts_lack_and_long_words(tmp_path: Path) -> None:
    pypdf = pytest.importorskip("pypdf")
    text = DESIGN.read_text(encoding="utf-8")
    title, word = "中 ☃ Ω", "w" * 300
    lines = [f"# 注 {word}"] + [
        f'title: "{title} {word[:90]}"' if x.startswith("title") else x for x in text.splitlines()
    ]
    path = tmp_path / "x.yaml"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert main(["run", str(path), "-o", str(tmp_path), "--format", "pdf", "-q"]) == 0
    reader = pypdf.PdfReader(io.BytesIO((tmp_path / "report.pdf").read_bytes()))
    pages = [page.extract_text() for page in reader.pages]
    assert pages[0].splitlines()[1].startswith("⟨U+4E2D⟩ ☃ Ω")
    assert "lack are given by their numbers" in " ".join(pages[0].split())
    assert any("⟨U+6CE8⟩" in page for page in pages)
    assert max(len(line) for page in pages for line in page.splitlines()) < 200
    assert reader.attachments["scenario.yaml"][0] == path.read_bytes()
