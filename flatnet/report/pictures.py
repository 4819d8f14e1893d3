"""Write pictures, as PNG: of a build from the files that it wrote, of the faces of a network, of a diagnosis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from flatnet.network.listing import FaceList
from flatnet.remedies.diagnose import Diagnosis
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
    _check_name(picture)
    build = read_build(folder)
    with _matplotlib():
        from flatnet.report.contact_sheet import contact_sheet
    return _write(picture, contact_sheet(build))


def draw_diagnoses(project: str, diagnoses: Sequence[Diagnosis], picture: str | Path) -> Path:
    """Draw the cuts that were tried on some patches, one row or more for each; `.png`.

    Raises
    ------
    PictureError
        matplotlib is missing, or the file can't be written.
    """
    picture = Path(picture)
    _check_name(picture)
    with _matplotlib():
        from flatnet.report.diagnosis_picture import diagnosis_picture
    return _write(picture, diagnosis_picture(project, diagnoses))


def draw_faces(listed: FaceList, picture: Path) -> Path:
    """Draw a network from two sides, its faces in colours, with the names of faces and curves; `.png`.

    Raises
    ------
    PictureError
        matplotlib is missing, or the file can't be written.
    """
    _check_name(picture)
    with _matplotlib():
        from flatnet.report.face_picture import face_picture
    return _write(picture, face_picture(listed))


def _check_name(picture: Path) -> None:
    if picture.suffix.lower() != ".png":
        raise PictureError(f"{picture}: a picture is a PNG; name a file that ends in .png")


@contextmanager
def _matplotlib() -> Iterator[None]:
    try:
        yield
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("matplotlib"):
            raise
        raise PictureError("drawing needs matplotlib: pip install matplotlib") from None


def _write(picture: Path, content: bytes) -> Path:
    try:
        picture.write_bytes(content)
    except OSError as error:
        raise PictureError(f"{picture}: can't be written: {error.strerror}") from None
    return picture
