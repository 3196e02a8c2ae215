"""The scenarios of a comparison: files, loaded or solved scenarios, and their variants, each with a name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from math import prod
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import Mistake, ScenarioError, UsageError
from vireport.scenario.blocks import Scenario, inputs
from vireport.scenario.loading import Loaded, Source, load, loads
from vireport.scenario.overrides import as_texts
from vireport.study.study import Study

Item = Source | Loaded | Study
Vary = Sequence[str] | Mapping[str, Sequence[object]]

MOST_SCENARIOS = 48
"""Scenarios in one comparison: twelve rows of figures; more are the matter of a map, not of a comparison."""

OF_DEVICE = ("device.", "excitation.", "inclination_deg", "gravity_m_s2", "period_ratio")
"""Paths, or how they begin, of the values that are known by their titles: what a device is, and how it is shaken."""

OPENING, CLOSING = "[{", "]}"


class Variant(Struct, frozen=True, eq=False):
    """A scenario of a comparison, with its study where it is solved already."""

    name: str
    loaded: Loaded
    study: Study | None = None


def variants(
    items: Sequence[Item] | Item,
    vary: Vary | None,
    names: Sequence[str] | None,
    overrides: str | Sequence[str] | Mapping[str, object],
    allow_outside: bool,
) -> list[Variant]:
    """Load every scenario in every variant; all mistakes are reported at once, those of a variant with its name.

    Parameters
    ----------
    items, vary, names, overrides, allow_outside
        As in `comparison.compare`.

    Raises
    ------
    UsageError
        Where there are too many, or the names do not fit.
    ScenarioError
        Where one cannot be used.
    """
    one = str, bytes, Path, Mapping, Loaded, Study
    alternatives = list(items) if isinstance(items, Iterable) and not isinstance(items, one) else [items]
    axes, over = _axes(vary), as_texts(overrides)
    count = len(alternatives) * prod(len(values) for _, values in axes)
    if count > MOST_SCENARIOS:
        raise UsageError(f"{count} scenarios are too many to compare (allowed: at most {MOST_SCENARIOS})")
    grid = [
        tuple(f"{path}={text}" for (path, _), text in zip(axes, texts, strict=True))
        for texts in product(*(texts for _, texts in axes))
    ]
    loaded, failures = [], []
    for item in alternatives:
        for extra in grid:
            try:
                loaded.append(_variant(item, over, extra, allow_outside))
            except ScenarioError as error:
                failures.append((_words(extra), error))
    if failures:
        raise _all_mistakes(failures)
    words = [
        _described(extra, one.loaded.scenario) for one, extra in zip(loaded, grid * len(alternatives), strict=True)
    ]
    if names is None:
        return _renamed(loaded, words if len(alternatives) == 1 and axes else _default_names(loaded, words))
    if len(names) == len(loaded):
        return _renamed(loaded, names)
    if len(names) == len(alternatives):
        owners = [name for name in names for _ in grid]
        return _renamed(loaded, [_joined(*both) for both in zip(owners, words, strict=True)])
    raise UsageError(f"{len(names)} names for {len(loaded)} scenarios")


def _axes(vary: Vary | None) -> list[tuple[str, list[str]]]:
    """Read the keys that are varied, each with its values, as texts."""
    axes = []
    if isinstance(vary, Mapping):
        for path, values in vary.items():
            if isinstance(values, str) or not isinstance(values, Iterable):
                raise UsageError(f"--vary {path}: {values!r} is no list of values (such as [1, 2, 3])")
            axes.append((path, [as_texts({path: value})[0].partition("=")[2] for value in values]))
    else:
        for text in [vary] if isinstance(vary, str) else vary or ():
            path, sign, listed = text.partition("=")
            if not sign or not path.strip():
                raise UsageError(f"--vary {text}: not of the form key=value,value (such as inclination_deg=0,15,30)")
            axes.append((path.strip(), _split(listed)))
    for k, (path, texts) in enumerate(axes):
        if not texts or not all(texts):
            raise UsageError(f"--vary {path}: a value is missing (such as {path}=1,2,3)")
        if len(set(texts)) < len(texts):
            raise UsageError(f"--vary {path}: a value is given twice")
        if path in [other for other, _ in axes[:k]]:
            raise UsageError(f"--vary {path}: is varied twice; give all its values at once")
    return axes


def _split(text: str) -> list[str]:
    """Split at the commas that are not inside brackets or quotes: a list, or a title, may have some of its own."""
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


def _variant(item: Item, over: tuple[str, ...], extra: tuple[str, ...], allow_outside: bool) -> Variant:
    """Load an item with its overrides; a study without overrides stays solved."""
    if not isinstance(item, Loaded | Study):
        return Variant("", load(item, (*over, *extra), allow_outside))
    loaded = item.loaded if isinstance(item, Study) else item
    if over or extra:
        document = loaded.document
        return Variant("", loads(document.text, document.name, (*loaded.overrides, *over, *extra), loaded.place))
    return Variant("", loaded, item if isinstance(item, Study) else None)


def _all_mistakes(failures: Sequence[tuple[str, ScenarioError]]) -> ScenarioError:
    """Gather the mistakes of all scenarios in one error, each once; those of what is set, with the variant's name."""
    files: dict[str, dict[Mistake, None]] = {}
    more: Counter[str] = Counter()
    for words, error in failures:
        more[error.name] = max(more[error.name], error.more)
        for mistake in error.mistakes:
            if not mistake.line and words:  # a mistake in a line of the file is that of all its variants
                mistake = replace(mistake, message=f"{mistake.message} [in the variant {words}]")
            files.setdefault(error.name, {})[mistake] = None
    errors = [ScenarioError(name, mistakes, more[name]) for name, mistakes in files.items()]
    if len(errors) == 1:
        return errors[0]
    return _SeveralFiles(errors)


class _SeveralFiles(ScenarioError):
    """The mistakes of several files, those of each together."""

    def __init__(self, errors: Sequence[ScenarioError]) -> None:
        self.errors = errors
        mistakes = [mistake for error in errors for mistake in error.mistakes]
        super().__init__(errors[0].name, mistakes, sum(error.more for error in errors))

    @property
    def lines(self) -> tuple[str, ...]:
        """A line for each mistake, by files."""
        return tuple(line for error in self.errors for line in error.lines)


def _described(extra: Iterable[str], scenario: Scenario) -> str:
    """Name a variant by its values with their units, ``inclination 15°``; what has no unit by its key."""
    titled = {title.path: title for title in inputs(scenario) if title.unit and title.path.startswith(OF_DEVICE)}
    parts = []
    for override in extra:
        path, _, text = (part.strip() for part in override.partition("="))
        title = titled.get(path)
        if title is None:
            parts.append(_words([override]))
        else:
            unit = {"1": "", "deg": "°"}.get(title.unit, f" {title.unit}")
            parts.append(f"{title.title[0].lower()}{title.title[1:]} {text}{unit}")
    return ", ".join(parts) if len(set(parts)) == len(parts) else _words(extra)


def _words(extra: Iterable[str]) -> str:
    """Name a variant by its values as they are set, ``inclination_deg = 15``; of a path the last key, if it can."""
    pairs = [tuple(part.strip() for part in text.partition("=")[::2]) for text in extra]
    keys = [path.rpartition(".")[2] for path, _ in pairs]
    return ", ".join(
        f"{key if keys.count(key) == 1 else path} = {value}" for key, (path, value) in zip(keys, pairs, strict=True)
    )


def _joined(*parts: str) -> str:
    """Join the parts of a name that there are."""
    return ", ".join(filter(None, parts))


def _default_names(loaded: Sequence[Variant], words: Sequence[str]) -> list[str]:
    """Name files without their suffix and variants by their values; files that agree, by their overrides too."""
    files = [variant.loaded.document.name for variant in loaded]
    stems = [name.strip("<>") if name.startswith("<") else Path(name).stem or name for name in files]
    names = [_joined(stem, values) for stem, values in zip(stems, words, strict=True)]
    folders = [Path(name).parent.name for name in files]
    longer = (
        [
            _joined(stem, _described(variant.loaded.overrides, variant.loaded.scenario))
            for stem, variant in zip(stems, loaded, strict=True)
        ],
        [f"{folder}/{name}" if folder else name for folder, name in zip(folders, names, strict=True)],
    )
    for other in longer:
        distinct = [long if names.count(name) > 1 else name for name, long in zip(names, other, strict=True)]
        names = distinct if len(set(distinct)) > len(set(names)) else names
    return names


def _renamed(loaded: Sequence[Variant], names: Sequence[str]) -> list[Variant]:
    """Give names, numbered where they would be alike."""
    taken = set[str]()
    named = []
    for variant, name in zip(loaded, names, strict=True):
        unique, number = name, 2
        while unique in taken:
            unique, number = f"{name} ({number})", number + 1
        taken.add(unique)
        named.append(replace(variant, name=unique))
    return named
