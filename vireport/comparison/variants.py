"""The scenarios of a comparison: files, loaded or solved scenarios, and their variants, each with a name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from pathlib import Path

from vireport.errors import Mistake, ScenarioError, UsageError
from vireport.scenario import (
    Loaded,
    as_texts,
    load,
    loads,
)
from vireport.study import Study

RESERVED = ("quantity", "group", "unit", "change", "differs", "sentence")
"""Columns of compare.csv that are no scenarios."""

OPENING, CLOSING = "[{", "]}"


@dataclass(frozen=True, slots=True, eq=False)
class Variant:
    """A scenario of a comparison.

    Attributes
    ----------
    name : str
    loaded : Loaded
    study : Study or None
        Where it is solved already.
    """

    name: str
    loaded: Loaded
    study: Study | None = None


def variants(
    items: Sequence[str | Path | Loaded | Study],
    vary: Sequence[str] | Mapping[str, Sequence[object]] | None,
    names: Sequence[str] | None,
    overrides: str | Sequence[str] | Mapping[str, object],
    most: int,
) -> list[Variant]:
    """Load every scenario in every variant; all mistakes are told at once, those of a variant with its name.

    Parameters
    ----------
    items : sequence of str, Path, Loaded or Study
    vary, names, overrides
        As in `comparison.compare`.
    most : int
        How many there may be.

    Raises
    ------
    UsageError
        Where there are too many, or the names do not fit.
    ScenarioError
        Where one cannot be used.
    """
    axes, over = _axes(vary), as_texts(overrides)
    count = len(items) * prod(len(values) for _, values in axes)
    if count > most:
        raise UsageError(f"{count} scenarios are too many to compare (allowed: at most {most})")
    grid = [tuple(f"{path}={text}" for (path, _), text in zip(axes, texts, strict=True)) for texts in _texts(axes)]
    found, failures = [], []
    for item in items:
        for extra in grid:
            try:
                found.append(_variant(item, over, extra))
            except ScenarioError as error:
                failures.append((_words(extra), error))
    if failures:
        raise _all_mistakes(failures)
    if names is None:
        return _renamed(found, _default_names(found, grid, len(items)))
    if len(names) == len(found):
        return _renamed(found, names)
    if len(names) == len(items):
        return _renamed(found, [_joined(name, _words(extra)) for name in names for extra in grid])
    raise UsageError(f"{len(names)} names for {len(found)} scenarios")


def _axes(vary: Sequence[str] | Mapping[str, Sequence[object]] | None) -> list[tuple[str, list[str]]]:
    """Paths and the values of each, as texts."""
    if not vary:
        return []
    axes = []
    if isinstance(vary, Mapping):
        for path, values in vary.items():
            axes.append((path, [as_texts({path: value})[0].partition("=")[2] for value in values]))
    else:
        for text in [vary] if isinstance(vary, str) else vary:
            path, sign, values = text.partition("=")
            if not sign or not path.strip():
                raise UsageError(f"--vary {text}: not of the form key=value,value (such as inclination_deg=0,15,30)")
            axes.append((path.strip(), _split(values)))
    for k, (path, texts) in enumerate(axes):
        if not texts or not all(texts):
            raise UsageError(f"--vary {path}: a value is missing (such as {path}=1,2,3)")
        if len(set(texts)) < len(texts):
            raise UsageError(f"--vary {path}: a value is given twice")
        if path in [other for other, _ in axes[:k]]:
            raise UsageError(f"--vary {path}: is varied twice; give all its values at once")
    return axes


def _split(text: str) -> list[str]:
    """Split at the commas that are not inside brackets or quotes."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in OPENING + CLOSING:
            depth += 1 if letter in OPENING else -1
        elif letter == "," and not depth:
            parts.append("")
            continue
        parts[-1] += letter
    return [part.strip() for part in parts]


def _texts(axes: Sequence[tuple[str, Sequence[str]]]) -> Iterable[tuple[str, ...]]:
    return product(*(texts for _, texts in axes))


def _variant(item: str | Path | Loaded | Study, over: tuple[str, ...], extra: tuple[str, ...]) -> Variant:
    if isinstance(item, str | Path):
        return Variant("", load(item, (*over, *extra)))
    loaded = item.loaded if isinstance(item, Study) else item
    if over or extra:
        document = loaded.document
        return Variant("", loads(document.text, document.name, (*loaded.overrides, *over, *extra)))
    return Variant("", loaded, item if isinstance(item, Study) else None)


def _all_mistakes(failures: Sequence[tuple[str, ScenarioError]]) -> ScenarioError:
    """One error with the mistakes of all scenarios, each once; those of what is set, with the variant's name."""
    found: dict[tuple[str, Mistake], None] = {}
    for words, error in failures:
        for mistake in error.mistakes:
            if not mistake.line and words:
                mistake = replace(mistake, message=f"{mistake.message} [in the variant {words}]")
            found[error.name, mistake] = None
    files = dict.fromkeys(name for name, _ in found)
    if len(files) == 1:
        return ScenarioError(next(iter(files)), [mistake for _, mistake in found])
    return _SeveralFiles([(name, [one for other, one in found if other == name]) for name in files])


class _SeveralFiles(ScenarioError):
    """The mistakes of several files, file by file."""

    def __init__(self, files: Sequence[tuple[str, Sequence[Mistake]]]) -> None:
        super().__init__(files[0][0], [mistake for _, mistakes in files for mistake in mistakes])
        self.args = ("\n".join(str(ScenarioError(name, mistakes)) for name, mistakes in files),)


def _words(extra: Iterable[str]) -> str:
    """The values of a variant, for the reader: ``inclination_deg = 15``; of a path the last key, if that is enough."""
    pairs = [tuple(part.strip() for part in text.partition("=")[::2]) for text in extra]
    keys = [path.rpartition(".")[2] for path, _ in pairs]
    return ", ".join(
        f"{key if keys.count(key) == 1 else path} = {value}" for key, (path, value) in zip(keys, pairs, strict=True)
    )


def _joined(*parts: str) -> str:
    return ", ".join(filter(None, parts))


def _default_names(found: Sequence[Variant], grid: Sequence[tuple[str, ...]], items: int) -> list[str]:
    """Files by their names without suffix, variants by their values; what is set over a file where files agree."""
    stems = [_stem(variant.loaded.document.name) for variant in found]
    if items == 1 and grid != [()]:
        return [_words(extra) for extra in grid]
    words = [_words(extra) for extra in grid] * items
    names = [_joined(stem, each) for stem, each in zip(stems, words, strict=True)]
    folders = [Path(variant.loaded.document.name).parent.name for variant in found]
    longer = (
        [_joined(stem, _words(variant.loaded.overrides)) for stem, variant in zip(stems, found, strict=True)],
        [f"{folder}/{name}" if folder else name for folder, name in zip(folders, names, strict=True)],
    )
    for other in longer:
        told = [long if names.count(name) > 1 else name for name, long in zip(names, other, strict=True)]
        names = told if len(set(told)) > len(set(names)) else names
    return names


def _stem(name: str) -> str:
    return name.strip("<>") if name.startswith("<") else Path(name).stem or name


def _renamed(found: Sequence[Variant], names: Sequence[str]) -> list[Variant]:
    """Give names, numbered where they would be alike."""
    taken = set(RESERVED)
    result = []
    for variant, name in zip(found, names, strict=True):
        unique = name
        number = 2
        while unique in taken:
            unique, number = f"{name} ({number})", number + 1
        taken.add(unique)
        result.append(replace(variant, name=unique))
    return result
