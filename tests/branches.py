"""Which branches of the words of templates are taken."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from jinja2 import nodes
from jinja2.compiler import CodeGenerator

from vireport.text import templates as wording
from vireport.text.templates import environment_of


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


def say_every_branch(*rows: tuple[str, str, tuple[object, ...], str]) -> None:
    """Hold what macros say, by their file and what they are given, and that their files have no branch besides."""
    with branches_taken() as taken:
        for words, macro, given, part in rows:
            assert part in wording.Words(words)(macro, *given), (words, macro)
        branches, told = taken()
    assert {branch.partition(":")[0] for branch in branches} == {f"words/{row[0]}.j2" for row in rows}
    assert branches - told == set()
