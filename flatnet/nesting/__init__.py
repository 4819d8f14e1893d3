"""Pieces and a material become layouts."""

from flatnet.nesting.check import check_layouts
from flatnet.nesting.layout import Layout, Placement
from flatnet.nesting.nest import nest
from flatnet.nesting.stored import read_stored, write_stored

__all__ = ["Layout", "Placement", "check_layouts", "nest", "read_stored", "write_stored"]
