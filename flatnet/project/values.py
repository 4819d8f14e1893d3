"""YAML node -> one checked value: number, length, vector, word, name. Parsers raise `WrongValueError`."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np
import yaml
from numpy.typing import NDArray

from flatnet.project.yaml_nodes import describe, is_number, is_plain

Floats = NDArray[np.float64]
T = TypeVar("T")
Parser = Callable[[yaml.Node], T]

#: Units of length by name, mm.
UNITS = {"mm": 1.0, "cm": 10.0, "dm": 100.0, "m": 1000.0, "in": 25.4}
#: A file's up axis -> the turn that takes it to z: about x for y, about y for x. So a figure with y up that
#: looks along +z looks along -y afterwards.
TO_Z_UP: dict[str, Floats] = {
    "x": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}
#: A name: letters, digits and _, with single . or - between them. Neither `-` at the front nor `:` nor `..`,
#: so that `-curve:from..to` has one meaning.
NAME = r"\w+(?:[.-]\w+)*"
#: No length is larger, mm (1000 km): its powers stay far from overflow, and a wrong unit shows.
LARGEST_LENGTH = 1e9

_NOT_FINITE = re.compile(r"[-+]?\.?(nan|inf|infinity)", re.IGNORECASE)
_TRUE, _FALSE = ("true", "yes", "on"), ("false", "no", "off")


class WrongValueError(Exception):
    """The value at `node` is not what is wanted; `message` says why."""

    def __init__(self, node: yaml.Node, message: str) -> None:
        super().__init__(message)
        self.node = node
        self.message = message


class NotFiniteError(WrongValueError):
    """Infinity, or what is no number, where a number is wanted."""


def wrong(node: yaml.Node, expected: str) -> WrongValueError:
    """The error that says what was expected and what stands there."""
    return WrongValueError(node, f"expected {expected}, got {describe(node)}")


def nearest(name: str, known: Iterable[str], what: str) -> str:
    """The end of a message about an unknown name: the nearest known one, or what there is."""
    names = list(known)
    close = difflib.get_close_matches(name.lower(), [each.lower() for each in names], n=1)
    if close:
        return f"did you mean {next(each for each in names if each.lower() == close[0])!r}?"
    if not names:
        return f"the file has no {what}"
    return f"known {what}: {', '.join(map(repr, names[:12]))}{', ...' if len(names) > 12 else ''}"


def scalar(expected: str) -> Parser[str]:
    """The text of a scalar as it stands in the file."""

    def parser(node: yaml.Node) -> str:
        if not isinstance(node, yaml.ScalarNode) or node.value == "":
            raise wrong(node, expected)
        return node.value

    return parser


def number(node: yaml.Node) -> float:
    """A finite number."""
    if is_plain(node) and _NOT_FINITE.fullmatch(node.value):
        raise _not_finite(node)
    if not is_number(node):
        raise wrong(node, "a number")
    value = float(node.value)
    if not math.isfinite(value):
        raise _not_finite(node)
    return value


def _not_finite(node: yaml.Node) -> NotFiniteError:
    return NotFiniteError(node, wrong(node, "a finite number").message)


def integer(node: yaml.Node) -> int:
    """A whole number."""
    value = number(node)
    if value != round(value):
        raise wrong(node, "a whole number")
    return int(value)


def between(parse: Callable[[yaml.Node], T], low: float, high: float) -> Parser[T]:
    """A number in [low, high]."""

    def parser(node: yaml.Node) -> T:
        value = parse(node)
        if not low <= value <= high:  # type: ignore[operator]
            raise WrongValueError(node, f"must be in [{low:g}, {high:g}], got {describe(node)}")
        return value

    return parser


def length_in(mm_per_unit: float, positive: bool = False, negative: bool = True) -> Parser[float]:
    """A length in the file's unit -> mm."""

    def parser(node: yaml.Node) -> float:
        value = number(node)
        if positive and value <= 0.0:
            raise WrongValueError(node, f"must be greater than 0, got {describe(node)}")
        if not negative and value < 0.0:
            raise WrongValueError(node, f"must not be less than 0, got {describe(node)}")
        if abs(value) * mm_per_unit > LARGEST_LENGTH:
            raise WrongValueError(node, f"{describe(node)} is {value * mm_per_unit:g} mm; is the unit right?")
        return value * mm_per_unit

    return parser


def unit(node: yaml.Node) -> float:
    """A unit of length by name or as mm per unit -> mm per unit."""
    if isinstance(node, yaml.ScalarNode) and node.value in UNITS:
        return UNITS[node.value]
    if not is_number(node):
        raise wrong(node, f"{', '.join(UNITS)} or a number (mm per unit)")
    return between(number, 1e-6, 1e6)(node)


def point_in(mm_per_unit: float) -> Parser[Floats]:
    """[x, y, z] in the file's unit -> (3,) mm, read-only."""
    coordinate = length_in(mm_per_unit)

    def parser(node: yaml.Node) -> Floats:
        return _vector(node, coordinate)

    return parser


def direction(node: yaml.Node) -> Floats:
    """[x, y, z] of any length but 0 -> (3,) unit, read-only."""
    vector = _vector(node, number)
    largest = np.abs(vector).max()
    if largest == 0.0:
        raise WrongValueError(node, "a direction must not be [0, 0, 0]")
    scaled = vector / largest  # so that no square over- or underflows
    return frozen(scaled / np.linalg.norm(scaled))


def _vector(node: yaml.Node, parse: Parser[float]) -> Floats:
    if not isinstance(node, yaml.SequenceNode) or len(node.value) != 3:
        raise wrong(node, "three numbers [x, y, z]")
    return frozen(np.array([parse(item) for item in node.value]))


def frozen(array: Floats) -> Floats:
    """The same array, read-only."""
    array.setflags(write=False)
    return array


def flag(node: yaml.Node) -> bool:
    """true, yes, on; or false, no, off."""
    text = node.value.lower() if is_plain(node) else ""
    if text not in _TRUE + _FALSE:
        raise wrong(node, "true or false")
    return text in _TRUE


def one_of(*words: str) -> Parser[str]:
    """One of the given words."""
    expected = " or ".join(f"'{word}'" for word in words)

    def parser(node: yaml.Node) -> str:
        text = scalar(expected)(node)
        if text not in words:
            close = difflib.get_close_matches(text, words, n=1)
            hint = f"; did you mean '{close[0]}'?" if close and len(words) > 1 else ""
            raise WrongValueError(node, f"expected {expected}, got {describe(node)}{hint}")
        return text

    return parser


def colour(node: yaml.Node) -> str:
    """A colour as #rrggbb, in small letters."""
    text = scalar("a colour, '#rrggbb' in quotes")(node)
    if not re.fullmatch("#[0-9a-fA-F]{6}", text):
        raise wrong(node, "a colour, '#rrggbb' in quotes")
    return text.lower()


def title(node: yaml.Node) -> str:
    """One line of text."""
    text = scalar("a line of text")(node)
    if not text.isprintable() or not text.strip():
        raise wrong(node, "a line of text")
    return text


def name(node: yaml.Node) -> str:
    """A name of a node, curve, patch, opening or material."""
    text = scalar("a name")(node)
    if not re.fullmatch(NAME, text):
        raise WrongValueError(
            node,
            f"{text!r} is no name: letters, digits and _ make one, with single '.' or '-' between them",
        )
    return text
