"""The few ways a run can fail, each with the exit code it leads to.

Only the command line catches these. Any other exception is a fault of ours and shows its traceback on
request.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct

EXTRAS = {
    "anywidget": "notebook",
    "dask.distributed": "cluster",
    "filelock": "sweep",
    "h5py": "recordings",
    "numba": "simulation",
    "pyarrow": "sweep",
    "python-flint": "certify",
}
"""The extra with which each optional package comes."""


def install_command(package: str) -> str:
    """Return the command that installs an optional package, from a clone's environment as from any other."""
    extra = EXTRAS.get(package)
    return f"pip install 'vireport[{extra}]'" if extra is not None else f"pip install {package}"


class VireportError(Exception):
    """A failure that is explained to the caller in one message; `exit_code` is what the process returns."""

    exit_code = 3

    @property
    def lines(self) -> tuple[str, ...]:
        """The message, a text for each line; what stands in one may come from a file, and hold anything."""
        return (str(self),)


class UsageError(VireportError):
    """The command line asks for something that does not exist or does not fit together."""

    exit_code = 2


class Mistake(Struct, frozen=True):
    """One mistake in a scenario: where it is, which key, what is wrong and what is allowed.

    Line 0 is no line of the file: the mistake was made on the command line, in ``--set path=value``.
    """

    line: int
    path: str
    message: str

    def render(self, name: str) -> str:
        """Return ``file:line: path: message``, or ``--set path: message`` where it is not in the file."""
        place = f"{name}:{self.line}: " if self.line else "--set "
        return f"{place}{self.path}: {self.message}" if self.path else f"{place}{self.message}"


class ScenarioError(VireportError):
    """A scenario that cannot be used, with every mistake that was found in it.

    Parameters
    ----------
    name : str
        Name of the file, as the caller gave it.
    mistakes : iterable of Mistake
        At least one; they are shown in the order of their lines.
    """

    exit_code = 2

    def __init__(self, name: str, mistakes: Iterable[Mistake]) -> None:
        self.name = name
        self.mistakes = tuple(sorted(mistakes, key=lambda mistake: mistake.line))
        super().__init__("\n".join(self.lines))

    @property
    def lines(self) -> tuple[str, ...]:
        """The message as lines, one for each mistake."""
        return tuple(mistake.render(self.name) for mistake in self.mistakes)

    def to_dicts(self) -> list[dict[str, str | int | None]]:
        """The mistakes as data, ready for JSON: those of ``--set`` have neither file nor line."""
        return [
            {
                "file": self.name if mistake.line else None,
                "line": mistake.line or None,
                "path": mistake.path,
                "message": mistake.message,
            }
            for mistake in self.mistakes
        ]


class OutputError(VireportError):
    """What was computed cannot be written: the disk or the stream that it goes to is full or faulty."""


class NumericalError(VireportError):
    """The numbers could not be had: a case outside the theory, or a computation that did not converge."""


class RenderError(VireportError):
    """A template that cannot be set."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What the library says, with the place that it shows."""
        return tuple(str(self).split("\n"))
