"""Draw a build as one picture, a PNG, from the files that it wrote."""

from __future__ import annotations

from pathlib import Path

from flatnet.report.build_files import read_build


class PictureError(Exception):
    """The picture can't be made or written."""


def draw(folder: str | Path, picture: str | Path | None = None) -> Path:
    """Draw the network, the warped and the fitted patches and the layouts of a build on one sheet.

    Parameters
    ----------
    folder : the output folder of a build.
    picture : the file to write, `.png`; left out, it stands beside the folder and has its name. Not inside: a
        build's folder holds what its report lists, and a picture would outlive the build that it shows.

    Raises
    ------
    BuildFilesError
        The folder holds no whole build.
    PictureError
        matplotlib is missing, or the file can't be written.
    """
    folder = Path(folder).resolve()
    picture = folder.with_name(f"{folder.name}.png") if picture is None else Path(picture)
    if picture.suffix.lower() != ".png":
        raise PictureError(f"{picture}: a picture is a PNG; name a file that ends in .png")
    build = read_build(folder)
    try:
        from flatnet.report.contact_sheet import contact_sheet
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("matplotlib"):
            raise
        raise PictureError("drawing needs matplotlib: pip install matplotlib") from None
    content = contact_sheet(build)
    try:
        picture.write_bytes(content)
    except OSError as error:
        raise PictureError(f"{picture}: can't be written: {error.strerror}") from None
    return picture
