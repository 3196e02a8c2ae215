"""JSON of results: nothing that is not finite or NumPy's, whatever they hold."""

from __future__ import annotations

import json
import math
import re
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
from msgspec import Struct

import vireport
from vireport.base.encoding import json_answer, json_text
from vireport.study.plan import AddedTask

PACKAGE = Path(vireport.__file__).parent


class Kind(Enum):
    """An enumeration whose members are no texts."""

    ONE = "one"


class Row(Struct, frozen=True):
    """A record in results."""

    name: str
    bound: float


VALUES = [
    (math.inf, None),
    (np.float64("nan"), None),
    (np.float32(0.5), 0.5),
    (np.bool_(True), True),
    (np.int64(3), 3),
    (np.array([1.0, -np.inf]), [1.0, None]),
    (np.array([[True], [False]]), [[True], [False]]),
    (0.1 + 0.2, 0.1 + 0.2),
    ((1, "ü"), [1, "ü"]),
    (AddedTask("proof", "whether it is proved"), "proof"),
    (Row("a", math.nan), {"name": "a", "bound": None}),
    ({"deep": [{"er": (Row("b", 1.0), np.float64("inf"))}]}, {"deep": [{"er": [{"name": "b", "bound": 1.0}, None]}]}),
]


@pytest.mark.parametrize("layout", [{}, {"indent": 2}, {"ascii_only": False}])
def test_what_is_not_finite_is_null_and_what_is_numpys_is_pythons(layout: dict[str, object]) -> None:
    for value, read in VALUES:
        assert json.loads(json_text({"value": value}, **layout)) == {"value": read}
        assert json.loads(json_answer({"value": value})) == {"value": read}


def test_members_of_enumerations_are_their_values() -> None:
    assert json_text([Kind.ONE, math.inf]) == '["one", null]'


def test_what_is_no_data_is_refused() -> None:
    for write in (json_text, json_answer):
        with pytest.raises(TypeError):
            write({"value": object()})


def test_nothing_else_writes_json() -> None:
    """But a scenario's values, of which one that is not finite is a mistake with its line."""
    encoders = re.compile(r"json\.dumps?\(|msgspec\.json\.encode\(|json\.Encoder|to_json\(")
    writers = {str(path.relative_to(PACKAGE)) for path in PACKAGE.rglob("*.py") if encoders.search(path.read_text())}
    assert writers == {"base/encoding.py", "scenario/overrides.py", "bench/jobs.py"}  # the last writes questions
