"""Which branches of the words of templates are taken."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from jinja2 import nodes
from jinja2.compiler import CodeGenerator
from pages import read_back

from vireport.text import templates as wording
from vireport.text.templates import ROOTS, environment_of


class Branches(CodeGenerator):
    """Compiles templates so that each branch tells that it was taken."""

    def visit_Template(self, node: nodes.Template, frame: object = None) -> None:
        for k, branch in enumerate(node.find_all((nodes.If, nodes.For, nodes.CondExpr))):
            place = f"{self.name}:{branch.lineno}:{k}"
            if isinstance(branch, nodes.CondExpr):
                branch.expr1 = self.told(f"{place} true", branch.expr1)
                branch.expr2 = branch.expr2 and self.told(f"{place} false", branch.expr2)
            else:
                branch.body.insert(0, nodes.ExprStmt(self.told(f"{place} true"), lineno=branch.lineno))
                if branch.else_:
                    branch.else_.insert(0, nodes.ExprStmt(self.told(f"{place} false"), lineno=branch.lineno))
        super().visit_Template(node, frame)

    def told(self, branch: str, value: nodes.Expr | None = None) -> nodes.Call:
        self.environment.branches.add(branch)
        given = [nodes.Const(branch), value or nodes.Const(None)]
        return nodes.Call(nodes.EnvironmentAttribute("taken"), given, [], None, None).set_lineno(0)


@contextmanager
def branches_taken() -> Iterator[Callable[[], tuple[set[str], set[str]]]]:
    """The branches of the words, and those that were taken, for as long as it lasts."""
    environment, told = environment_of(None), set()
    environment.bytecode_cache = None  # where other runs would find templates that tell

    def tell(branch: str, value: object) -> object:
        told.add(branch)
        return value

    environment.branches, environment.taken, environment.code_generator_class = set(), tell, Branches
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wording, "_environment", lambda templates: environment)
        yield lambda: (environment.branches, told)


def macros_of(words: str, given: str = "") -> list[str]:
    """The names of all macros of a file of words, or of those that are given nothing."""
    (file,) = (path for root in ROOTS if (path := root / "words" / f"{words}.j2").is_file())
    return re.findall(rf"macro (\w+)\({given}", file.read_text(encoding="utf-8"))


def say_every_branch(*rows: tuple[str, str, tuple[object, ...]]) -> None:
    """Hold what all macros of files say to what is kept, and that there is no branch besides.

    Rows have the file, the macro and what it is given; macros that are given nothing need none.
    """
    files = dict.fromkeys(words for words, _, _ in rows)
    plain = ((words, macro, ()) for words in files for macro in macros_of(words, r"\)"))
    said: dict[str, list[str]] = {words: [] for words in files}
    with branches_taken() as taken:
        for words, macro, given in (*plain, *rows):
            said[words].append(f"{macro}: {wording.Words(words)(macro, *given)}")
        branches, told = taken()
    for words, lines in said.items():
        assert read_back(f"words, {words.replace('/', ' ')}", lines) == []
    assert {branch.partition(":")[0] for branch in branches} <= {f"words/{words}.j2" for words in files}
    assert branches - told == set()
