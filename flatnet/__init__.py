"""flatnet: flattenable patches for curve networks, and their flat pieces laid out for cutting."""

from flatnet.build import BuildResult, build, check
from flatnet.export.output import OutputError
from flatnet.project import ProjectError
from flatnet.version import VERSION

__all__ = ["BuildResult", "OutputError", "ProjectError", "__version__", "build", "check"]
__version__ = VERSION
