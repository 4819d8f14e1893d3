"""Text for formats that have 7-bit characters only: transliterated, and said."""

from __future__ import annotations

from flatnet.export.missing_library import needs

_PLAIN = str.maketrans({"·": "-", "×": "x", "→": "->", "–": "-", "—": "-"})


def seven_bit(text: str) -> str:
    """The text in ASCII: `Größe` becomes `Grosse`, `брюки` `bryuki`; what has no letters for it becomes `?`."""
    if text.isascii():
        return text
    text = text.translate(_PLAIN)
    return text if text.isascii() else needs("anyascii", "7-bit texts").anyascii(text) or "?"


class Transliterated:
    """Makes texts 7-bit and remembers those that came out as others.

    Attributes
    ----------
    changed : text -> what was written for it.
    """

    def __init__(self) -> None:
        self.changed: dict[str, str] = {}

    def __call__(self, text: str) -> str:
        plain = seven_bit(text)
        if plain != text.translate(_PLAIN):
            self.changed[text] = plain
        return plain

    def notes(self, file: str) -> list[str]:
        """What to tell whoever reads the file."""
        changed = self.changed.items()
        return [f"{file}: the format has 7-bit letters only; {old!r} is written {new!r}" for old, new in changed]
