"""The bench: a design changed by hand in a page of this machine or in a notebook, and what the program says of it."""

from vireport.bench.server import serve
from vireport.bench.session import Opened, opened

__all__ = ["Opened", "opened", "serve"]
