"""flatnet: flattenable patches for curve networks, and their flat pieces laid out for cutting.

Nothing is imported before it is asked for, so that the command can take care of Ctrl-C first.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from flatnet.version import VERSION

if TYPE_CHECKING:
    from flatnet.build import BuildResult, build, check
    from flatnet.export.output import OutputError
    from flatnet.project import ProjectError

__all__ = ["BuildResult", "OutputError", "ProjectError", "__version__", "build", "check"]
__version__ = VERSION

#: Public name -> the module that has it.
_HOMES = {
    "BuildResult": "flatnet.build",
    "OutputError": "flatnet.export.output",
    "ProjectError": "flatnet.project",
    "check": "flatnet.build",
}


class _Package(ModuleType):
    """The package, in which `build` is the function and stays it when the module of that name is imported."""

    @property
    def build(self) -> Any:
        """`flatnet.build.build`."""
        return import_module("flatnet.build").build

    @build.setter
    def build(self, module: ModuleType) -> None:
        """The import system would put the module here."""


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


sys.modules[__name__].__class__ = _Package
