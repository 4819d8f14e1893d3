"""One mapping of the project file: hands its values out checked and notes all that is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import TypeVar

import yaml

from flatnet.project.problems import Mark, Problem
from flatnet.project.values import Parser, WrongValueError, name, nearest, wrong
from flatnet.project.yaml_nodes import entries, is_null, mark_of

T = TypeVar("T")


class Section:
    """The keys and values of one mapping.

    A value that is wrong is noted among the problems and a placeholder is handed out in its stead, so that
    reading goes on and every problem of a file is found at once.

    Attributes
    ----------
    title : what the section is, for messages: "curve 'hem'"; "" for the top of the file.
    mark : the place of its name.
    keys, values : text of each key -> node of the key, of the value.
    """

    def __init__(
        self,
        node: yaml.Node,
        title: str,
        mark: Mark,
        known: Collection[str] | None,
        problems: list[Problem],
    ) -> None:
        """`known` are the keys that may stand here; None where the keys are names."""
        self.title, self.mark, self.problems = title, mark, problems
        found = entries(node) if isinstance(node, yaml.MappingNode) else {}
        self.keys = {text: key for text, (key, _) in found.items()}
        self.values = {text: value for text, (_, value) in found.items()}
        self.is_mapping = isinstance(node, yaml.MappingNode)
        if not self.is_mapping:
            self.problem(node, wrong(node, "keys with values").message)
        if known is not None:
            for text in [text for text in self.keys if text not in known]:
                self.problem(self.keys[text], f"unknown key {text!r}; {nearest(text, known, 'keys')}")
                del self.values[text]

    def problem(self, where: yaml.Node | Mark, message: str) -> None:
        """Note what is wrong at a place, under the section's title."""
        mark = where if isinstance(where, Mark) else mark_of(where)
        self.problems.append(Problem(mark, f"{self.title}: {message}" if self.title else message))

    def get(self, key: str, parse: Parser[T], default: T) -> T:
        """The value of an optional key."""
        return self.read(key, self.values[key], parse, default) if key in self.values else default

    def require(self, key: str, parse: Parser[T], placeholder: T, hint: str = "") -> T:
        """The value of a key that must be there."""
        if key not in self.values and self.is_mapping:
            self.problem(self.mark, f"'{key}' is missing{hint and '; '}{hint}")
        return self.get(key, parse, placeholder)

    def read(self, label: str, node: yaml.Node, parse: Callable[[yaml.Node], T], placeholder: T) -> T:
        """What `parse` makes of a node; where it is wrong, that is noted and the placeholder handed out."""
        try:
            return parse(node)
        except WrongValueError as error:
            self.problem(error.node, f"{label}: {error.message}")
            return placeholder

    def items(self, label: str, node: yaml.Node, expected: str) -> list[tuple[str, yaml.Node]]:
        """The items of a list, each with a label for messages."""
        if not isinstance(node, yaml.SequenceNode):
            self.problem(node, f"{label}: {wrong(node, expected).message}")
            return []
        return [(f"{label}, item {i}", item) for i, item in enumerate(node.value, 1)]

    def section(self, key: str, known: Collection[str] | None) -> Section:
        """The mapping under `key`; without keys where it is missing or nothing stands there."""
        node = self.values.get(key)
        if node is None or is_null(node):
            node = yaml.MappingNode("", [])
        label = f"{self.title}: {key}" if self.title else key
        mark = mark_of(self.keys[key]) if key in self.keys else self.mark
        return Section(node, label, mark, known, self.problems)

    def named(self) -> Iterator[tuple[str, Mark, yaml.Node]]:
        """Where the keys are names of things: each name, its place and its value."""
        for text, key in self.keys.items():
            try:
                name(key)
            except WrongValueError as error:
                self.problem(key, error.message)
            yield text, mark_of(key), self.values[text]
