"""The few ways a run can fail, each with the exit code it leads to.

Only the command line catches these. Any other exception is a fault of ours and shows its traceback on request.
"""

from __future__ import annotations

from dataclasses import dataclass


class VireportError(Exception):
    """A failure that is explained to the caller in one message; `exit_code` is what the process returns."""

    exit_code = 3


class UsageError(VireportError):
    """The command line asks for something that does not exist or does not fit together."""

    exit_code = 2


@dataclass(frozen=True, slots=True)
class Mistake:
    """One mistake in a scenario: where it is, which key, what is wrong and what is allowed."""

    line: int
    path: str
    message: str


class ScenarioError(VireportError):
    """A scenario that cannot be used, with every mistake that was found in it.

    Parameters
    ----------
    name : str
        Name of the file, as the caller gave it.
    mistakes : sequence of Mistake
        At least one; they are shown in the order of their lines.
    """

    exit_code = 2

    def __init__(self, name: str, mistakes: list[Mistake]) -> None:
        self.name = name
        self.mistakes = tuple(sorted(mistakes, key=lambda mistake: mistake.line))
        super().__init__(
            "\n".join(
                f"{name}:{mistake.line}: {mistake.path}: {mistake.message}" if mistake.path
                else f"{name}:{mistake.line}: {mistake.message}"
                for mistake in self.mistakes
            )
        )


class NumericalError(VireportError):
    """The numbers could not be had: a case outside the theory, or a computation that did not converge."""
