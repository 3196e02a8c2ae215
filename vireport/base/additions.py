"""The packages that can be taken out: each is a folder, its tests, its page of the documentation, and a row here.

`python tools/take_out.py NAME` shows in a copy of the project that the rest stands without one.
"""

COMMANDS = ("comparison", "maps", "optimise", "bench")
"""Packages that bring a command, which the module `command` of each declares as `COMMAND`; in the order of the help."""
