"""Names that a package exports and imports only when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module


def deferred(package: str, *modules: str) -> Callable[[str], object]:
    """The `__getattr__` of a package, for the names of modules that most runs do without.

    A run with --json would otherwise spend a tenth of its time on classes that it has no use for. None of the modules
    may have the name of what it exports: once it is imported, the package has the module by that name.

    Parameters
    ----------
    package : str
    modules : str
        Of the package, each after those that it imports: they are asked in turn.

    Raises
    ------
    AttributeError
        When no module has a name; by the function returned.
    """

    def find(name: str) -> object:
        for module in modules:
            names = vars(import_module(f"{package}.{module}"))
            if name in names:
                return names[name]
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return find
