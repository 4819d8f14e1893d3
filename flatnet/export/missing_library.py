"""Libraries that only some formats need."""

from __future__ import annotations

import importlib
from typing import Any

from flatnet.export.written_build import ExportError

INSTALL = "pip install 'flatnet[exports]'"


def needs(module: str, what: str) -> Any:
    """A module that writes a format.

    Raises
    ------
    ExportError
        It is not installed; says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise ExportError(f"{what} needs {module.partition('.')[0]}, which is not installed: {INSTALL}") from None
