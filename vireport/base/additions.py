"""What can be taken out: each addition is its packages with their tests, templates and pages, and a row here.

`python tools/take_out.py NAME` shows in a copy of the project that the rest stands without one.
"""

from collections.abc import Mapping

ADDITIONS: Mapping[str, tuple[str, ...]] = {
    "compare": ("comparison",),
    "map": ("maps", "chart"),
    "optimise": ("optimise",),
    "explore": ("bench",),
}
"""Each addition by its command, in the order of the help, with its packages: the module `command` of the first declares
it as `COMMAND`. A key of a scenario that names an addition is known where the addition is."""
