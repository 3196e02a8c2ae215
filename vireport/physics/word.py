"""The word of a motion: the membranes that it strikes in one period, in order.

A word is what the literature calls an impact sequence: BT is a 1:1 motion, BBT a 2:1 motion.
"""

from __future__ import annotations

from msgspec import Struct


class Word(Struct, frozen=True):
    """The impacts of one period of a motion.

    Attributes
    ----------
    walls : tuple of int
        The membrane of each impact, in order: 1 bottom, -1 top.
    periods : int
        Forcing periods that the motion takes, k.
    """

    walls: tuple[int, ...]
    periods: int

    @classmethod
    def of(cls, letters: str, periods: int = 1) -> Word:
        """The word with some letters, in a number of forcing periods."""
        return cls(tuple(1 if letter == "B" else -1 for letter in letters), periods)

    def __len__(self) -> int:
        """Return the number of impacts, N."""
        return len(self.walls)

    @property
    def letters(self) -> str:
        """The impacts as letters, such as BBT."""
        return "".join("B" if wall > 0 else "T" for wall in self.walls)

    @property
    def one_sided(self) -> bool:
        """Whether only one membrane is struck."""
        return len(set(self.walls)) == 1

    @property
    def ratio(self) -> str:
        """Impacts on the bottom to impacts on the top, such as 2:1."""
        return f"{self.walls.count(1)}:{self.walls.count(-1)}"

    def rotated(self, first: int) -> Word:
        """Return the word with its impacts counted from impact `first`."""
        return Word(self.walls[first:] + self.walls[:first], self.periods)

    def firsts(self, other: Word) -> list[int]:
        """The impacts from which the word, counted anew, is another word; none if it is never that."""
        count, twice = len(self), self.walls + self.walls
        same = count == len(other) and self.periods == other.periods
        return [i for i in range(count) if same and twice[i : i + count] == other.walls]

    def canonical(self, mirror: bool = False) -> Word:
        """Return the alphabetically first of all rotations of the word and, with `mirror`, of its mirror image."""
        count, words = len(self), (self, self.mirrored()) if mirror else (self,)
        starts = ((word.walls + word.walls)[i : i + count] for word in words for i in range(count))
        return Word(max(starts), self.periods)  # B, the first letter, is the larger number

    def mirrored(self) -> Word:
        """Return the word with bottom and top exchanged."""
        return Word(tuple(-wall for wall in self.walls), self.periods)

    @property
    def name(self) -> str:
        """The letters and the period, such as BBT every forcing period."""
        return word_name(self.letters, self.periods)


def word_name(letters: str, periods: int) -> str:
    """The letters of a word and its period as text, such as BBT every forcing period."""
    return f"{letters} every {f'{periods} forcing periods' if periods > 1 else 'forcing period'}"
