"""The few ways a run can fail, each with the exit code it leads to.

Only the command line catches these. Any other exception is a fault of ours and shows its traceback on
request.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from msgspec import Struct

EXTRAS = {
    "anywidget": "notebook",
    "dask.distributed": "cluster",
    "filelock": "sweep",
    "h5py": "recordings",
    "mpmath": "verify",
    "nptdms": "recordings",
    "numba": "simulation",
    "pyarrow": "sweep",
    "python-flint": "certify",
    "pyuff": "recordings",
}
"""The extra with which each optional package comes."""


def install_command(package: str) -> str:
    """Return the command that installs an optional package, from a clone's environment as from any other."""
    extra = EXTRAS.get(package)
    return f"pip install 'vireport[{extra}]'" if extra is not None else f"pip install {package}"


class VireportError(Exception):
    """Any failure of vireport that is explained in a message; `exit_code` is what the command exits with."""

    exit_code = 3

    @property
    def lines(self) -> tuple[str, ...]:
        """The message, a text for each line; what stands in one may come from a file, and hold anything."""
        return (str(self),)


class UsageError(VireportError):
    """A command or a call that asks for something that does not exist or does not fit together.

    Parameters
    ----------
    message : str
    *example : str
        Further lines of the message: an example that works.
    """

    exit_code = 2

    def __init__(self, message: str = "", *example: str) -> None:
        self.example = example
        super().__init__(message)

    @property
    def lines(self) -> tuple[str, ...]:
        """The message, and the lines of its example."""
        return (str(self), *self.example)


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


MOST_MISTAKES = 20
"""Of a file that are told one by one: whoever has mended these runs it again."""

MOST_COUNTED = 100_000
"""Of a file that are counted: beyond, it is said that there are more."""


class Mistakes:
    """Mistakes of a file as they are found: the first ones in words, and how many others there are.

    What is wrong with a million rows is neither kept nor worded.
    """

    def __init__(self) -> None:
        self.reported: list[Mistake] = []
        self.more = 0

    def __bool__(self) -> bool:
        return bool(self.reported)

    @property
    def countless(self) -> bool:
        """Whether there are so many that no others need be looked for."""
        return self.more > MOST_COUNTED

    def add(self, line: int, path: str, message: Callable[[], str] | str) -> None:
        """Add a mistake; what words it is called where it is told alone."""
        if len(self.reported) < MOST_MISTAKES:
            self.reported.append(Mistake(line, path, message if isinstance(message, str) else message()))
        else:
            self.more += 1


class ScenarioError(VireportError):
    """A scenario or a record of measurements that cannot be used, with all mistakes found in it.

    Parameters
    ----------
    name : str
        Name of the file, for messages.
    mistakes : iterable of Mistake
        At least one, in the order of their lines.
    more : int
        Number of further mistakes, which are not listed.
    """

    exit_code = 2

    def __init__(self, name: str, mistakes: Iterable[Mistake], more: int = 0) -> None:
        self.name = name
        by_line = sorted(mistakes, key=lambda mistake: mistake.line)
        self.mistakes = tuple(by_line[:MOST_MISTAKES])
        self.more = more + len(by_line) - len(self.mistakes)
        super().__init__("\n".join(self.lines))

    @classmethod
    def in_line(cls, name: str, line: int, path: str, message: str) -> ScenarioError:
        """The error of one mistake, in a line of a file; the path is "" where it is none of a key or column."""
        return cls(name, [Mistake(line, path, message)])

    @property
    def lines(self) -> tuple[str, ...]:
        """The message as lines, one for each mistake that is told, and one for the number of others."""
        rendered = tuple(mistake.render(self.name) for mistake in self.mistakes)
        count = self.more if self.more < MOST_COUNTED else f"over {MOST_COUNTED}"
        return (*rendered, f"{self.name}: and {count} more (mend these first)") if self.more else rendered


class OutputError(VireportError):
    """What was computed cannot be written: the disk or the stream that it goes to is full or faulty."""


class NumericalError(VireportError):
    """A computation without a result: the case is outside the theory, or an iteration did not converge."""


class RenderError(VireportError):
    """A template that cannot be set."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What the library says, with the place that it shows."""
        return tuple(str(self).split("\n"))
