"""A project file -> its tree of YAML nodes, each with its place in the file.

PyYAML composes the tree but constructs nothing from it: the keys `on` and `no` would become booleans, `12:30`
would become 750 and the first of two equal keys would be lost. What stands in the file is what is read.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

import yaml

from flatnet.project.problems import Mark, Problem, ProjectError

_STANDARD = "tag:yaml.org,2002:"
_TAGS = {
    _STANDARD + kind
    for kind in ("map", "seq", "str", "int", "float", "bool", "null", "timestamp", "merge", "value")
}
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
#: Longest quotation of the file in a message, characters.
_LONGEST_QUOTE = 60


def compose(file: Path, text: str) -> yaml.MappingNode:
    """The top mapping of a file's text.

    Raises
    ------
    ProjectError
        It is no YAML, empty, or no mapping.
    """
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        said = ", ".join(part for part in (error.context, error.problem) if part)
        if r"'\t'" in said:
            said += "; that is a tab: indent with spaces"
        mark = error.problem_mark or error.context_mark
        # What a colour without quotes leaves open, YAML misses only further down.
        bare = _bare_colour(text.split("\n")[: mark.line + 1]) if mark else None
        if bare is not None:
            line, colour = bare
            said += f"; in line {line} {colour} begins a comment: write a colour in quotes, '{colour}'"
        problem = Problem(_mark(mark) if mark else None, f"not valid YAML: {said}")
        raise ProjectError(file, [problem]) from error
    except yaml.reader.ReaderError as error:
        message = f"not valid YAML: the character U+{error.character:04X} is not allowed; delete it"
        raise ProjectError(file, [Problem(_place(text[: error.position]), message)]) from error
    except RecursionError as error:
        raise ProjectError(file, [Problem(None, "not valid YAML: lists are nested too deep")]) from error
    except (ValueError, OverflowError) as error:  # PyYAML lets these out: "\UFFFFFFFF", %YAML 1<5000 digits>
        raise ProjectError(file, [Problem(None, f"not valid YAML: {error}")]) from error
    if root is None:
        message = "the file is empty; docs/project-file.md shows what belongs in it"
        raise ProjectError(file, [Problem(None, message)])
    if not isinstance(root, yaml.MappingNode):
        message = f"expected keys with values (name: ...) at the top of the file, got {describe(root)}"
        raise ProjectError(file, [Problem(mark_of(root), message)])
    return root


#: A colour that stands as a value without quotes.
_BARE_COLOUR = re.compile(r"[^#]*[:,\[]\s+(#[0-9a-fA-F]{6})\b")


def _bare_colour(lines: Sequence[str]) -> tuple[int, str] | None:
    """The last line with such a colour, counted from 1, and the colour."""
    found = [(number, match[1]) for number, line in enumerate(lines, 1) if (match := _BARE_COLOUR.match(line))]
    return found[-1] if found else None


def read_text(file: Path) -> str:
    """The text of a file.

    Raises
    ------
    ProjectError
        The file can't be read, or is no UTF-8.
    """
    if os.path.isdir(file):  # unlike Path.is_dir it takes any text without raising
        raise ProjectError(file, [Problem(None, "is a folder; name the project file in it")])
    try:
        data = file.read_bytes()
    except FileNotFoundError as error:
        raise ProjectError(file, [Problem(None, "there is no such file")]) from error
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        said = error.strerror if isinstance(error, OSError) else error
        raise ProjectError(file, [Problem(None, f"the file cannot be read: {said}")]) from error
    try:
        return data.decode("utf-8")  # PyYAML passes over a byte order mark
    except UnicodeDecodeError as error:
        mark = _place(data[: error.start].decode("utf-8"))
        message = f"byte 0x{data[error.start]:02x} is no UTF-8; save the file as UTF-8"
        raise ProjectError(file, [Problem(mark, message)]) from error


def _place(text: str) -> Mark:
    """The place right behind `text`."""
    return Mark(text.count("\n") + 1, len(text) - (text.rfind("\n") + 1) + 1)


def _mark(mark: yaml.Mark) -> Mark:
    return Mark(mark.line + 1, mark.column + 1)


def mark_of(node: yaml.Node) -> Mark:
    """Where a node begins."""
    return _mark(node.start_mark)


def is_null(node: yaml.Node) -> bool:
    """Nothing stands there (or `~`, or `null`)."""
    return node.tag == _STANDARD + "null" and isinstance(node, yaml.ScalarNode)


def is_plain(node: yaml.Node) -> bool:
    """A scalar without quotes."""
    return isinstance(node, yaml.ScalarNode) and node.style is None


def is_number(node: yaml.Node) -> bool:
    """A scalar without quotes that is a decimal number; 1e-5 too, 12:30 and 0x1F not."""
    return is_plain(node) and _NUMBER.fullmatch(node.value) is not None


def describe(node: yaml.Node) -> str:
    """What stands at a node, in words, for `expected ..., got ...`."""
    if isinstance(node, yaml.MappingNode):
        return "keys with values"
    if isinstance(node, yaml.SequenceNode):
        return f"a list of {len(node.value)}"
    if is_null(node):
        return "nothing"
    text = node.value if len(node.value) <= _LONGEST_QUOTE else node.value[:_LONGEST_QUOTE] + "..."
    if is_number(node):
        return text
    return f"{text!r}" if is_plain(node) else f"the text {text!r} in quotes"


def entries(node: yaml.MappingNode) -> dict[str, tuple[yaml.Node, yaml.Node]]:
    """Text of each key -> (key, value), in file order.

    Mappings merged in by `<<: *anchor` give what the mapping does not say itself. A mapping that is merged
    into itself is read once.
    """
    found: dict[str, tuple[yaml.Node, yaml.Node]] = {}
    queue: list[yaml.Node] = [node]
    visited: set[int] = set()
    while queue:
        mapping = queue.pop(0)
        if id(mapping) in visited or not isinstance(mapping, yaml.MappingNode):
            continue
        visited.add(id(mapping))
        merged: list[yaml.Node] = []
        for key, value in mapping.value:
            if _is_merge(key):
                merged += value.value if isinstance(value, yaml.SequenceNode) else [value]
            elif isinstance(key, yaml.ScalarNode):
                found.setdefault(key.value, (key, value))
        queue[:0] = merged
    return found


def _is_merge(key: yaml.Node) -> bool:
    return key.tag == _STANDARD + "merge"


def tree_problems(root: yaml.Node) -> list[Problem]:
    """What is wrong wherever it stands: equal keys, keys that are no words, tags, merges of no mapping."""
    problems = []
    stack, visited = [root], set()
    while stack:
        node = stack.pop()
        if id(node) in visited:  # an alias
            continue
        visited.add(id(node))
        if node.tag not in _TAGS:
            problems.append(Problem(mark_of(node), f"the tag {node.tag!r} means nothing here; leave it out"))
        if isinstance(node, yaml.SequenceNode):
            stack += node.value
        elif isinstance(node, yaml.MappingNode):
            problems += _key_problems(node)
            stack += [value for _, value in node.value]
    return problems


def _key_problems(node: yaml.MappingNode) -> list[Problem]:
    problems = []
    first: dict[str, int] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            problems.append(Problem(mark_of(key), f"a key must be a word, got {describe(key)}"))
            continue
        if key.value in first:
            message = f"the key {key.value!r} stands twice, first in line {first[key.value]}; keep one"
            problems.append(Problem(mark_of(key), message))
        first.setdefault(key.value, mark_of(key).line)
        merged = value.value if isinstance(value, yaml.SequenceNode) else [value]
        if _is_merge(key) and not all(isinstance(each, yaml.MappingNode) for each in merged):
            message = f"'<<' takes an alias of keys with values, or a list of such; got {describe(value)}"
            problems.append(Problem(mark_of(value), message))
    return problems
