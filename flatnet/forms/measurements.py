"""Read the measurements of a parametric form: names and values become its checked dataclass."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from flatnet.project.model import PLAIN_NUMBERS
from flatnet.project.values import nearest

Form = TypeVar("Form")

#: A measurement this many times larger or smaller than its default is taken for a slip of the unit.
PLAUSIBLE_FACTOR = 3.0


class MeasurementError(ValueError):
    """Measurements that no form can have; `messages` holds one sentence for each."""

    def __init__(self, messages: list[str]) -> None:
        self.messages = messages
        super().__init__("; ".join(messages))


def read_measurements(form: type[Form], measurements: Mapping[str, float | str]) -> Form:
    """Make the dataclass `form` from measurements in mm; fields that are left out keep their defaults.

    Raises
    ------
    MeasurementError
        Names that the form has not, words where a length belongs, lengths far from any body.
    """
    defaults: dict[str, Any] = {field.name: field.default for field in fields(form)}  # type: ignore[arg-type]
    messages = []
    for name, value in measurements.items():
        if name not in defaults:
            messages.append(f"unknown measurement {name!r}; {nearest(name, defaults, 'measurements')}")
            continue
        default = defaults[name]
        if isinstance(default, str):
            continue
        if isinstance(value, bool | str) or not math.isfinite(value):
            messages.append(f"{name} must be a {'number' if name in PLAIN_NUMBERS else 'length'}, got {value!r}")
        elif default is None or name in PLAIN_NUMBERS:
            continue  # the form knows its range
        elif not default / PLAUSIBLE_FACTOR <= value <= default * PLAUSIBLE_FACTOR:
            messages.append(
                f"{name} must be in [{default / PLAUSIBLE_FACTOR:.0f}, {default * PLAUSIBLE_FACTOR:.0f}] mm, "
                f"got {value:g} mm"
            )
    if messages:
        raise MeasurementError(messages)
    return form(**measurements)
