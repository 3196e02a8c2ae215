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
    ("arrival", (thing(proved=True, name="BT every forcing period", bits=512, impacts=33),)),
    ("arrival", (thing(proved=False, reason="the ball rests"),)),
    ("sections", (thing(velocity_unit=6.0, sections=[SHARES, SHARES]),)),
    ("sections", (thing(sections=[]),)),
    ("shocks", (thing(jump_m_s=1.224, cells=844),)),
    ("shocks", (thing(jump_m_s=None, unproved=""),)),
    ("shocks", (thing(jump_m_s=None, unproved="no motion"),)),
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
