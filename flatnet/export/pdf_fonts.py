"""Fonts for texts of any language in a PDF: the first that has all letters of a text."""

from __future__ import annotations

import importlib.util
import unicodedata
from pathlib import Path
from typing import Any

from flatnet.export.missing_library import needs
from flatnet.export.seven_bit import seven_bit

#: Fonts that every PDF viewer brings along: letters by the beginning of their Unicode names.
_ASIAN = {"HIRAGANA": "HeiseiMin-W3", "KATAKANA": "HeiseiMin-W3", "HANGUL": "HYSMyeongJo-Medium", "CJK": "STSong-Light"}


class Fonts:
    """Bitstream Vera, which reportlab brings, for Latin letters; DejaVu Sans, which comes with matplotlib, for Greek,
    Cyrillic and more where it is installed; the viewer's own fonts for Chinese, Japanese and Korean.

    Attributes
    ----------
    changed : text that none has letters for -> what is written for it.
    """

    def __init__(self) -> None:
        metrics, ttf = needs("reportlab.pdfbase.pdfmetrics", "PDF"), needs("reportlab.pdfbase.ttfonts", "PDF")
        self._metrics = metrics
        self._embedded: dict[str, Any] = {}
        for name, file in (("Vera", "Vera.ttf"), ("DejaVuSans", _dejavu())):
            if file:
                font = ttf.TTFont(name, str(file))
                metrics.registerFont(font)
                self._embedded[name] = font.face.charToGlyph
        self.changed: dict[str, str] = {}

    def use(self, canvas: Any, text: str, size: float) -> str:
        """Set the font for a text, `size` in points; the text that is to be drawn."""
        name = self._font(text)
        if name is None:
            plain = seven_bit(text)
            self.changed[text] = plain
            name, text = "Vera", plain
        canvas.setFont(name, size)
        return text

    def _font(self, text: str) -> str | None:
        for name, letters in self._embedded.items():
            if all(ord(letter) in letters for letter in text):
                return name
        scripts = [unicodedata.name(letter, "").split()[0].split("-")[0] for letter in text if ord(letter) > 0x2000]
        for script, name in _ASIAN.items():
            if script in scripts and all(each in _ASIAN for each in scripts):
                self._metrics.registerFont(needs("reportlab.pdfbase.cidfonts", "PDF").UnicodeCIDFont(name))
                return name
        return None

    @property
    def notes(self) -> list[str]:
        """What to tell whoever reads the file."""
        return [f"no font at hand has all letters of {old!r}: written {new!r}" for old, new in self.changed.items()]


def _dejavu() -> Path | None:
    found = importlib.util.find_spec("matplotlib")
    if found is None or found.origin is None:
        return None
    file = Path(found.origin).parent / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"
    return file if file.is_file() else None
