"""What is wrong with a text that is not YAML, in our own words, and on which line.

Imported only once there is such a text. The parser's own messages speak of tokens and block ends; these speak
of what was probably meant.
"""

from __future__ import annotations

import re

import yaml

# The first of these whose text is found in the parser's message explains it.
_EXPLANATIONS = (
    ("found character '\\t'", "a tab where YAML does not allow one (indent and separate with spaces)"),
    ("that cannot start any token", "a value cannot start with this character (put text in quotes)"),
    ("found unexpected end of stream", "a quote is opened here and never closed (close it)"),
    ("found unexpected document separator", "a quote is opened here and never closed (close it)"),
    ("expected ',' or ']'", "a '[' is opened here and not closed, or a comma is missing (close it with ']')"),
    ("expected ',' or '}'", "a '{' is opened here and not closed, or a comma is missing (close it with '}')"),
    ("invalid indentation or unclosed", "a '[' or '{' is not closed (close it)"),
    ("could not find expected ':'", "a key without its colon (write 'key: value')"),
    (
        "mapping values are not allowed here",
        "a second colon in one value, or wrong indentation (quote text with ': ')",
    ),
    ("sequence entries are not allowed here", "a list cannot start here (a scenario has no lists)"),
    ("but found '-'", "a list entry among keys (a scenario has no lists)"),
    ("expected <block end>", "wrong indentation (keys of one block start in the same column)"),
    (
        "expected '<document start>'",
        "text after the end of the scenario (everything belongs in one block of keys)",
    ),
    ("expected the node content", "a value is missing before this bracket or comma (write it)"),
    (
        "unknown escape character",
        "an unknown escape after '\\' (use single quotes for text with backslashes)",
    ),
    ("hexadecimal numbers", "an incomplete escape after '\\' (use single quotes for text with backslashes)"),
    ("chomping or indentation", "'|' or '>' starts a text of several lines (put the text in quotes)"),
    ("indentation indicator", "'|' or '>' starts a text of several lines (put the text in quotes)"),
    ("scanning an alias", "a value cannot start with '*' (put text in quotes)"),
    ("scanning an anchor", "a value cannot start with '&' (put text in quotes)"),
    ("tag", "a value cannot start with '!' (put text in quotes)"),
    ("directive", "a line cannot start with '%' (put text in quotes)"),
    ("incompatible YAML document", "a line cannot start with '%' (delete it)"),
)
_UNEXPLAINED = "this is not YAML (write 'key: value', one to a line)"
# Messages whose cause is where the construct began, not where the parser gave up.
_FROM_START = ("end of stream", "document separator", "or ']'", "or '}'", "could not find expected ':'")
_BARE = re.compile(r"\s*[^\s:#][^:#]*$")
_NO_SPACE = re.compile(r"\s*(?!['\"#])[^\s:#]+:[^\s/:]")


def explain(error: Exception, text: str) -> tuple[int, str]:
    """Return the line, counted from 1, and the explanation of a parser's error.

    Parameters
    ----------
    error : yaml.YAMLError, ValueError or OverflowError
        What the parser raised.
    text : str
        The text it read.
    """
    if not isinstance(error, yaml.MarkedYAMLError):
        # Only an escape or a version number that does not exist raises an error without a mark.
        rows = enumerate(text.split("\n"), 1)
        line = next((i for i, row in rows if "\\U" in row or row.startswith("%")), 1)
        return line, "an escape or a number that does not exist (delete it)"
    message = f"{error.context} {error.problem}"
    mark = error.problem_mark
    if error.context_mark is not None and any(part in message for part in _FROM_START):
        mark = error.context_mark
    line = 1 if mark is None else mark.line + 1
    lines = text.split("\n")
    # A key without its colon, or without the space after it, runs on into the next line.
    for earlier in (line - 1, line):
        row = lines[earlier - 1] if 0 < earlier <= len(lines) else ""
        if _NO_SPACE.match(row):
            return earlier, "no space after the colon (write 'key: value')"
        if earlier < line and "mapping values" in message and _BARE.match(row):
            return earlier, "a key without its colon (write 'key: value')"
    return line, next((words for part, words in _EXPLANATIONS if part in message), _UNEXPLAINED)
