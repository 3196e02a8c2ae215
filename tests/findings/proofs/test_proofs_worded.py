"""What is said of proofs: of the start from rest, of shares of all starts, and of shocks."""

from __future__ import annotations

from types import SimpleNamespace as thing

from branches import say_every_branch
from msgspec.structs import replace

from vireport.base.records import plain
from vireport.findings.proofs.finding import FINDING
from vireport.study.result_records import DisturbancesData, FromRestData, ShockData

SHARES = thing(name="BT", fastest=1.9, share=0.684021, switch_on=0.933349)
SAID = [
    (
        "arrival",
        (thing(proved=True, name="BT every forcing period", bits=512, impacts=33),),
        "reaches BT every forcing period. Ball arithmetic of 512 bits encloses 33 impacts, up to a region in which",
    ),
    ("arrival", (thing(proved=False, reason="the ball rests"),), "is reached from rest. The ball rests."),
    (
        "sections",
        (thing(velocity_unit=6.0, sections=[SHARES, SHARES]),),
        "up to 11.4 m/s, at least 68.4 % lead to BT; so does switching on from rest at 93.3 % or more of all",
    ),
    ("sections", (thing(sections=[]),), "Not proved: that any share of all impacts"),
    ("shocks", (thing(jump_m_s=1.224, cells=844),), "dies out (844 cells of moments and jumps are enclosed)"),
    ("shocks", (thing(jump_m_s=None, unproved=""),), "The smallest jumps remain open."),
    ("shocks", (thing(jump_m_s=None, unproved="no motion"),), "that the motion survives. No motion."),
]


def test_every_branch_of_the_words_is_said() -> None:
    say_every_branch(*(("proofs", *row) for row in SAID))


def test_nothing_proved_is_null() -> None:
    from_rest, shock = FromRestData(outcome="1:1"), ShockData(tried=9)
    block = DisturbancesData(from_rest=from_rest, shock=shock, recovery_s=2.0)
    data = FINDING.results_within(block, None)
    assert plain(data.from_rest) == plain(from_rest) | {"proved": None}
    assert plain(data.shock) == plain(shock) | {"proved_m_s": None}
    assert (data.proof, data.recovery_s) == (None, 2.0)
    assert FINDING.results_within(replace(block, shock=None), None).shock is None
