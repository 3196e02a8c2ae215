"""Names of what is stable in a region of a chart, short ones for its figure and long ones for its legend and tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from msgspec import Struct

from vireport.map.chart.chart import Chart
from vireport.map.chart.regions import Kind, Kinds, StableMotion
from vireport.motions.switching import Limits
from vireport.text.templates import Words


class Naming(Struct, frozen=True, eq=False):
    """How the stable motions of one chart are named.

    Attributes
    ----------
    ambiguous : frozenset of (str, bool)
        Words, and whether they are of asymmetric motions, that take different numbers of forcing periods in it.
    said : Words
    """

    ambiguous: frozenset[tuple[str, bool]]
    said: Words

    def of(self, kind: Kind) -> str:
        """Name of a motion by its kind."""
        _, letters, periods, asymmetric = kind
        return self.said("motion", letters, periods if (letters, asymmetric) in self.ambiguous else 0, asymmetric)

    def short(self, kinds: Kinds | None) -> str:
        """Names of the motions that are stable, in a few words."""
        if kinds is None:
            return self.said("stable_unresolved")
        return self.said("stable", [self.of(kind) for kind in kinds]) if kinds else self.said("stable_none")

    def motions(self, motions: Sequence[StableMotion] | None) -> str:
        """The names of motions, none twice; of None that rounding does not resolve them."""
        return self.short(None if motions is None else tuple(dict.fromkeys(motion.kind for motion in motions)))

    def long(self, kinds: Kinds | None, limits: Limits) -> str:
        """What is stable, with what the words mean to a designer, and up to which limits nothing is."""
        if kinds is None:
            return self.said("meaning_unresolved")
        if not kinds:
            return self.said("meaning_none", limits)
        alone = len(kinds) == 1 and kinds[0][1:3] == ("BT", 1)
        return self.said("meaning_one_to_one" if alone else "meaning", [self.of(kind) for kind in kinds])


def naming(chart: Chart, templates: Path | None = None) -> Naming:
    """How the stable motions of a chart are named: by their words, with the period where words alone are ambiguous."""
    kinds = {kind for region in chart.regions.every for kind in region.kinds or ()}
    if chart.design is not None:
        stable = [chart.design.motions, *(end.beyond for end in chart.design.margins)]
        kinds |= {motion.kind for motions in stable for motion in motions or ()}
    counts = Counter((letters, asymmetric) for _, letters, _, asymmetric in kinds)
    return Naming(frozenset(key for key, count in counts.items() if count > 1), Words("chart", templates))
