"""Turns `equations.typ` into what the templates read: `templates/equations.json` and `templates/math.woff2`.

    python tools/make_equations.py                     the equations
    python tools/make_equations.py --font FILE.ttf     also the font: the part of it that they need
    python tools/make_equations.py --check             writes nothing; exit code 1 where it would

The font is STIX Two Math; its STIXTwoMath-Regular.ttf comes with the package `ziamath`, among others. It is
cut by fonttools[woff].
"""

from __future__ import annotations

import argparse
import html
import json
import re
import sys
from pathlib import Path

import typst

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "tools" / "equations.typ"
EQUATIONS = ROOT / "templates" / "equations.json"
FONT = ROOT / "templates" / "math.woff2"

ENTRY = re.compile(r"^/// (?P<header>.+)\n(?P<body>(?:(?!///).*\n?)+)", re.MULTILINE)

# Typst writes accents as combining characters, which browsers put beside the letter instead of above it.
ACCENTS = {"\u0307": "\u02d9", "\u0308": "\u00a8", "\u0304": "\u00af"}


def entries(text: str) -> dict[str, dict[str, str]]:
    """Read the names, numbers, words and Typst sources of the equations."""
    found = {}
    for entry in ENTRY.finditer(text):
        name, number, words = (part.strip() for part in entry["header"].split("|"))
        if name in found:
            raise SystemExit(f"{SOURCE}: the name {name} is given twice")
        found[name] = {"number": number, "alt": words, "typst": " ".join(entry["body"].split())}
    return found


def with_mathml(equations: dict[str, dict[str, str]]) -> dict[str, dict[str, str]]:
    """Add the MathML of each equation."""
    source = "\n\n".join(f"#html.div(id: {json.dumps(name)})[{e['typst']}]" for name, e in equations.items())
    document = typst.Compiler(ignore_system_fonts=True).compile(source.encode(), format="html").decode()
    for name, equation in equations.items():
        found = re.search(rf'<div id="{re.escape(name)}">(<math.*?</math>)</div>', document, re.DOTALL)
        if found is None:
            raise SystemExit(f"{SOURCE}: {name} did not become MathML")
        equation["mathml"] = tidy(found[1], equation["alt"])
    return equations


def tidy(mathml: str, words: str) -> str:
    """Repair the accents, shorten the spaces, and add the words for those who cannot see the equation."""
    for combining, spacing in ACCENTS.items():
        mathml = mathml.replace(combining, spacing)
    mathml = re.sub(r"0\.1666+7?em", "0.17em", mathml)
    return mathml.replace("<math ", f'<math alttext="{html.escape(words)}" ', 1)


def characters(equations: dict[str, dict[str, str]]) -> set[str]:
    """What the font has to cover."""
    return {letter for e in equations.values() for letter in re.sub(r"<[^>]*>", "", e["mathml"])} - {
        " ",
        "\n",
    }


def cut(source: Path, letters: set[str]) -> bytes:
    """Cut the part of a font that some letters need, with the tables that stretch brackets and roots."""
    from io import BytesIO

    from fontTools.subset import Options, Subsetter, load_font, save_font

    options = Options(flavor="woff2", layout_features=["*"], hinting=False, desubroutinize=True, notdef_outline=True)
    font = load_font(str(source), options)
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=sorted(map(ord, letters)))
    subsetter.subset(font)
    file = BytesIO()
    save_font(font, file, options)
    return file.getvalue()


def uncovered(font: bytes, letters: set[str]) -> set[str]:
    """Letters that the font does not have."""
    from io import BytesIO

    from fontTools.ttLib import TTFont

    return letters - set(map(chr, TTFont(BytesIO(font)).getBestCmap()))


def main(arguments: list[str] | None = None) -> int:
    """Write or check the generated files; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--font", type=Path)
    options = parser.parse_args(arguments)
    equations = with_mathml(entries(SOURCE.read_text(encoding="utf-8")))
    text = json.dumps(equations, ensure_ascii=False, indent=1) + "\n"
    stale = []
    if options.check:
        if EQUATIONS.read_text(encoding="utf-8") != text:
            stale.append(f"{EQUATIONS.name} is out of date")
    else:
        EQUATIONS.write_text(text, encoding="utf-8")
        if options.font:
            FONT.write_bytes(cut(options.font, characters(equations)))
    if missing := uncovered(FONT.read_bytes(), characters(equations)):
        stale.append(f"{FONT.name} lacks {' '.join(sorted(missing))}")
    print("\n".join(stale) or f"{len(equations)} equations, {FONT.stat().st_size} bytes of font")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
