"""Values of YAML scalars by the core schema of YAML 1.2, section 10.3.2, and the characters they may have."""

from __future__ import annotations

import re
from math import inf, nan

LONGEST_INTEGER = 300  # characters; a longer one is beyond double precision, and slow to convert

_BASED_INTEGER = r"0o[0-7]+|0x[0-9a-fA-F]+"  # so rare that it is compiled where it is met
_NUMBER = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_WORDS: dict[str, object] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), nan),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), inf),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -inf),
}


def scalar(text: str) -> object:
    """Value of a plain scalar: None, bool, int, float, or else the text itself.

    Parameters
    ----------
    text : str
        The scalar without quotes; what stands in quotes is text whatever it looks like.

    Examples
    --------
    >>> [scalar(text) for text in ("1e-3", ".5", "017", "0o17", "True")]
    [0.001, 0.5, 17, 15, True]
    >>> [scalar(text) for text in ("yes", "1:30", "1_000", "2024-01-01")]
    ['yes', '1:30', '1_000', '2024-01-01']
    """
    if text in _WORDS:
        return _WORDS[text]
    if text[0] not in "+-.0123456789":
        return text
    if _NUMBER.fullmatch(text):
        whole = len(text) <= LONGEST_INTEGER and set(text).isdisjoint(".eE")
        return int(text) if whole else float(text)
    if re.fullmatch(_BASED_INTEGER, text):
        return int(text, 0) if len(text) <= LONGEST_INTEGER else inf
    return text


def joined(text: str) -> str | None:
    """Join the two escapes by which JSON writes a character beyond U+FFFF; None where one is missing."""
    if not any("\ud800" <= letter <= "\udfff" for letter in text):
        return text
    try:
        return text.encode("utf-16", "surrogatepass").decode("utf-16")
    except UnicodeDecodeError:
        return None


def is_forbidden(letter: str) -> bool:
    """Whether YAML forbids a character, or takes it for a line break, which would shift the later lines."""
    code = ord(letter)
    if code < 0xA0:
        return not (0x20 <= code < 0x7F or letter in "\t\n")
    return 0xD800 <= code <= 0xDFFF or code in (0x2028, 0x2029, 0xFEFF, 0xFFFE, 0xFFFF)
