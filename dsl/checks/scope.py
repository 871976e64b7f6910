"""Which names a script declares, by sort."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from dsl import nodes as n
from dsl.diagnostics import Report
from dsl.words import did_you_mean

Named = TypeVar("Named", n.StoreNode, n.ActionNode, n.EnvironmentNode, n.GoalNode)


class Scope:
    """The declarations of a script, each under its name; of two equal names the first.

    Args:
        script: The script.
        report: Takes the names that are declared twice.
    """

    def __init__(self, script: n.Script, report: Report) -> None:
        self.script = script
        self._report = report
        declarations = script.declarations
        self.stores = self._by_name(
            "store", [d for d in declarations if isinstance(d, n.StoreNode)]
        )
        self.actions = self._by_name(
            "action", [d for d in declarations if isinstance(d, n.ActionNode)]
        )
        self.environments = self._by_name(
            "environment", [d for d in declarations if isinstance(d, n.EnvironmentNode)]
        )
        self.goals = self._by_name("goal", [d for d in declarations if isinstance(d, n.GoalNode)])

    def _by_name(self, sort: str, nodes: Iterable[Named]) -> dict[str, Named]:
        found: dict[str, Named] = {}
        for node in nodes:
            earlier = found.setdefault(node.name.text, node)
            if earlier is not node:
                message = (
                    f"the {sort} {node.name.text} is declared in line "
                    f"{earlier.name.span.line} already"
                )
                self._report.add("E201", node.name.span, message, "rename or remove one")
        return found

    def known(self, sort: str, names: Iterable[n.Name], table: Mapping[str, object]) -> list[str]:
        """Return the names that are declared, once each; report the others.

        Args:
            sort: What the names are of, such as `action`.
            names: The names as they are used.
            table: The declarations of that sort.
        """
        found: list[str] = []
        for name in names:
            if name.text in found:
                message = f"{name.text} is in the list already"
                self._report.add("E204", name.span, message, "remove one")
            elif self.is_known(sort, name, table):
                found.append(name.text)
        return found

    def is_known(self, sort: str, name: n.Name, table: Mapping[str, object]) -> bool:
        """Return whether a name can be used; report it if it is not declared at all."""
        if name.text in table:
            return True
        if (sort, name.text) not in self.script.mentioned:
            hint = did_you_mean(
                name.text, table, otherwise=f"declare it: `{sort} {name.text} {{ }}`"
            )
            self._report.add("E202", name.span, f"there is no {sort} {name.text}", hint)
        return False
