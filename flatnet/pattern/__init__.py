"""A fitted patch becomes a piece to cut."""

from flatnet.pattern.piece import Piece, make_piece

__all__ = ["Piece", "make_piece"]
