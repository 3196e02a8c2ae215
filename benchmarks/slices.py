"""A study of many outcomes that is made in slices: what is known is kept in a file, from which the next one goes on."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Hashable, Iterable
from pathlib import Path
from typing import Any


def options(about: str, records: int, each: str, outcomes: Path) -> argparse.ArgumentParser:
    """The options that such studies share."""
    asked = argparse.ArgumentParser(description=about)
    asked.add_argument("--records", type=int, default=records, help=each)
    asked.add_argument("--seconds", type=float, default=500, help="after which a slice of the study ends")
    asked.add_argument("--outcomes", type=Path, default=outcomes, help="where they are kept")
    asked.add_argument("--table", action="store_true", help="only tell what is known, and keep it as a result")
    return asked


def pursued(
    given: argparse.Namespace,
    every: Iterable[tuple[Hashable, ...]],
    outcome: Callable[..., dict[str, Any]],
    key: tuple[str, ...],
) -> list[dict[str, Any]]:
    """All outcomes that are known after one slice, without one where only the table is asked for.

    Parameters
    ----------
    given : Namespace
        Of `options`.
    every : iterable of tuple
        What to look into, in turn: a study that ends early has as many of each.
    outcome : callable
        Of these.
    key : tuple of str
        Where an outcome says what it is of.
    """
    known = [json.loads(line) for line in given.outcomes.open()] if given.outcomes.exists() else []
    done, end = {tuple(x[name] for name in key) for x in known}, time.monotonic() + given.seconds
    with given.outcomes.open("a") as file:
        for one in () if given.table else every:
            if time.monotonic() > end:
                break
            if one not in done:
                known.append(outcome(*one))
                file.write(json.dumps(known[-1], default=lambda x: x.item()) + "\n")
                file.flush()
    return known
