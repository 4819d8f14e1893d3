"""Check what `flatnet export` wrote: one module reads a format, and none of them shares a writer's code."""

from flatnet.verify.exports.check import check_exports

__all__ = ["check_exports"]
