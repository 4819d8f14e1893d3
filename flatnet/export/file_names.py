"""Names of patches as names of files: safe on every system, and no two of them the same."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

#: Names that Windows keeps for devices, with any ending.
RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{digit}" for port in ("com", "lpt") for digit in range(10))}
#: Longest name, in characters: room for an ending within the 255 bytes of common file systems.
LONGEST = 100


def safe_file_names(names: Iterable[str]) -> dict[str, str]:
    """A file name without ending for each name, distinct even where upper and lower case are the same.

    Letters, digits, `-` and `_` stay, all else becomes `_`. Names that would fall together are numbered in
    their order: `sole`, `Sole` become `sole`, `Sole-2`.
    """
    safe: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
        stem = re.sub(r"[^A-Za-z0-9_-]+", "_", plain)[:LONGEST].strip("_") or "piece"
        if stem.lower() in RESERVED or stem.startswith("-"):
            stem = f"piece_{stem}"
        candidate, number = stem, 2
        while candidate.lower() in taken:
            candidate, number = f"{stem}-{number}", number + 1
        taken.add(candidate.lower())
        safe[name] = candidate
    return safe
