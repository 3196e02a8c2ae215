"""What a comparison opens with: the best scenario and why, what others lack, and the numbers of the best.

The macros that say it are in `templates/words/compare.j2`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from vireport.comparison.ranking import FIRST, RANKED_DIGITS, VOLTAGES, Merit, Ranked, held_against
from vireport.report.changes.sentences import NOTHING, listed
from vireport.study.judging.opening import Opening, Statement, gravest
from vireport.study.judging.verdict import AnyConclusion, Status
from vireport.text.formatting import ABSENT, percent
from vireport.text.said import Said, words_of

_said = words_of("compare")

GRAVE = Status.BAD, Status.CAUTION
"""What is said against scenarios, in one fact each."""


def comparison_opening(ranked: Sequence[Ranked]) -> Opening:
    """Choose what a comparison opens with.

    Parameters
    ----------
    ranked : sequence of Ranked
        The best first.
    """
    best = [scenario.name for scenario in ranked if scenario.rank == 1]
    study = ranked[0].study
    if not any(scenario.stable for scenario in ranked):
        facts = gravest([*_why(ranked), *_against(ranked)])
        return Opening(Status.BAD, _said("word_none_stable"), _said("none_stable"), facts)
    facts = gravest([*_why(ranked), *_against(ranked), *_traded(ranked)])
    word, status = _said("word_best", listed(best)), study.verdict.status
    return Opening(status, word, _sentence(ranked, best), facts, study.opening.tiles)


def _sentence(ranked: Sequence[Ranked], best: Sequence[str]) -> Said:
    if len(best) == len(ranked):
        return _said("equally_good", listed(best))
    following, margin = ranked[len(best)], ranked[0].study.verdict.margin
    merit = _decisive(ranked[0], following)
    if merit is Merit.MARGIN and margin is not None and margin.data.not_known:
        return _said("best_margin_rigid", listed(best), following.name)
    return _said(f"best_{merit}", listed(best), following.name)


def _decisive(better: Ranked, following: Ranked) -> Merit:
    """Find the merit that puts one scenario before another."""
    pairs = zip(better.order, better.key, following.key, strict=True)
    return next(merit for merit, mine, theirs in pairs if mine != theirs)


def _why(ranked: Sequence[Ranked]) -> Iterator[Statement]:
    """What puts the best before the next, with the numbers of both; that the next is not stable stands elsewhere."""
    following = next((scenario for scenario in ranked if scenario.rank > 1), None)
    if following is None:
        return
    merit = _decisive(ranked[0], following)
    if merit is not Merit.STABILITY:
        numbers = _number(ranked[0], merit), following.name, _number(following, merit)
        yield Statement(Status.GOOD, _said(f"why_{merit}", *numbers))


def _number(scenario: Ranked, merit: Merit) -> str | Said:
    """The number of a scenario in a merit, as a fact of the opening has it."""
    if merit is Merit.REQUIREMENTS:
        # Those that are missed, not those that are met: 1 of 1 met comes before 3 of 4, and so does nothing required.
        count = len(scenario.study.criteria)
        return _said("of_them", count - scenario.passed, count)
    text = scenario.said(merit)
    return NOTHING if text == ABSENT else text


def _against(ranked: Sequence[Ranked]) -> Iterator[Statement]:
    """What holds against scenarios, all of it and not only what weighs most: two may be alike in the rest."""
    for status in GRAVE:
        whose: dict[AnyConclusion, list[str]] = {}
        for scenario in ranked:
            for conclusion in scenario.study.verdict.conclusions:
                if conclusion.status is status:
                    whose.setdefault(conclusion, []).append(scenario.name)
        if whose:
            parts = [
                _said("of", held_against(conclusion), _said("all") if len(names) == len(ranked) else listed(names))
                for conclusion, names in whose.items()
            ]
            yield Statement(status, _said("lacking", parts))


def _traded(ranked: Sequence[Ranked]) -> Iterator[Statement]:
    """What gives more voltage than the best, of those as good in requirements and stability, with its margin."""
    first = ranked[0]
    rivals = [scenario for scenario in ranked if scenario.key[: len(FIRST)] == first.key[: len(FIRST)]]
    named = {first.name}
    for merit in VOLTAGES:
        top = max(rivals, key=lambda scenario: scenario.merits[merit] or 0.0)
        mine, most = first.merits[merit] or 0.0, top.merits[merit] or 0.0
        if mine > 0 and round(most / mine - 1, RANKED_DIGITS) > 0 and top.name not in named:
            named.add(top.name)
            more = percent(most / mine - 1, signed=True)
            values = top.name, top.said(merit), more, top.said(Merit.MARGIN)
            yield Statement(Status.NEUTRAL, _said(f"traded_{merit}", *values))
