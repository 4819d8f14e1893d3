"""Parameters in a project file: `fitting` of the file and of a patch, `nesting`, `limits`."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import TypeVar, cast

from flatnet.parameters import METHODS, FittingParameters, Limits, NestingParameters
from flatnet.project.section import Section
from flatnet.project.values import Parser, integer, number, one_of

Parameters = TypeVar("Parameters", bound=FittingParameters | NestingParameters | Limits)


def read_fitting(parent: Section, defaults: FittingParameters) -> FittingParameters:
    """The method and its parameters under `fitting`; what is not said there is as in `defaults`.

    Another method than that of `defaults` starts from its own defaults.
    """
    every = {key for cls in METHODS.values() for key in parameter_names(cls)}
    section = parent.section("fitting", {"method", *every})
    usual = next(name for name, cls in METHODS.items() if isinstance(defaults, cls))
    method = section.get("method", one_of(*METHODS), usual)
    cls = METHODS[method]
    for key in [key for key in section.values if key not in ("method", *parameter_names(cls))]:
        owner = next(other for other, cls in METHODS.items() if key in parameter_names(cls))
        section.problem(section.keys[key], f"{key!r} belongs to method {owner!r}, but the method is {method!r}")
    return read_parameters(section, defaults if isinstance(defaults, cls) else cls())


def parameter_names(cls: type) -> tuple[str, ...]:
    """The keys that may stand in the section of a parameter class."""
    return tuple(field.name for field in fields(cls))


def read_parameters(section: Section, defaults: Parameters) -> Parameters:
    """`defaults` with the values that the section gives; what the dataclass says against them is noted."""
    usual = asdict(defaults)
    given: dict[str, float] = {}
    for key, value in usual.items():
        if key in section.values:
            parse: Parser[float] = integer if isinstance(value, int) else number
            given[key] = section.get(key, parse, cast(float, value))
    while True:
        try:
            return type(defaults)(**(usual | given))
        except ValueError as error:
            culprit = str(error).split()[0]
            section.problem(section.values.get(culprit, section.mark), str(error))
            if culprit not in given:  # a default that a given value has put out of range
                return defaults
            del given[culprit]
