"""Build every project and draw it into docs/pictures: `python -m tests.pictures [NAME ...]`."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageChops

import flatnet
from flatnet.forms import make_surface
from flatnet.project import load_project
from flatnet.report.build_files import read_build
from flatnet.report.contact_sheet import sheet_of
from flatnet.report.panels import Panel, shaded_panel
from flatnet.report.pictures import draw
from flatnet.report.view import FROM_THE_FRONT, Camera, Surface

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
#: Picture of a variant -> its project, a line of the project file, and what stands there instead.
VARIANTS = {
    f"{shoe}_fair": (shoe, "fitting: {normal_weight: 100}", "fitting: {normal_weight: 1}")
    for shoe in ("shoe_1", "shoe_2")
}
#: Projects whose patches are drawn in place too, NAME_in_place.png: seen from where they show.
IN_PLACE = {"moai": Camera(-125.0, -22.0)}
#: Of a picture in the repository: pixels across, colours, and rounds of choosing them; so it has some 150 kB.
WIDTH, COLOURS, ROUNDS = 1400, 256, 4


def main() -> int:
    projects = sorted(path.parent.name for path in (ROOT / "projects").glob("*/project.yaml"))
    names = [*projects, *VARIANTS]
    parser = argparse.ArgumentParser(prog="python -m tests.pictures", description="Draw the projects' pictures.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"only these, of {', '.join(names)}")
    chosen = parser.parse_args().names or names
    if unknown := sorted(set(chosen) - set(names)):
        parser.error(f"no project or variant is called {', '.join(unknown)}; there are {', '.join(names)}")
    failed = [name for name in chosen if not draw_project(name)]
    return 1 if failed else 0


def draw_project(name: str) -> bool:
    """Write docs/pictures/NAME.png if all patches of the project, or of the variant, are made."""
    project, *line = VARIANTS.get(name, (name,))
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(shutil.copytree(ROOT / "projects" / project, Path(scratch) / project))
        if line:
            replace_line(folder / "project.yaml", *line)
        built = flatnet.build(folder / "project.yaml", Path(scratch) / "out")
        if built.exit_status != 0:
            print(f"{name}: not all patches are made, no picture; build it to see why", file=sys.stderr)
            return False
        drawn = draw(Path(scratch) / "out", Path(scratch) / "drawn.png")
        shrink(drawn, PICTURES / f"{name}.png")
        if name in IN_PLACE:
            drawn.write_bytes(in_place(folder / "project.yaml", Path(scratch) / "out", IN_PLACE[name]))
            shrink(drawn, PICTURES / f"{name}_in_place.png", 720)
    print(f"docs/pictures/{name}.png", flush=True)
    return True


def in_place(project_file: Path, out: Path, camera: Camera) -> bytes:
    """The reference surface alone, from the front and from the camera, and with the fitted patches in it."""
    reference = make_surface(load_project(project_file))
    assert reference is not None, "a project drawn in place has a surface"
    corners = np.asarray(reference.mesh.triangles)
    plain = np.zeros(len(corners))
    surface = Surface(corners, np.zeros((0, 2, 3)), plain, plain)
    fitted = Surface.of([patch.mesh for patch in read_build(out).patches])
    plain = np.zeros(len(corners) + len(fitted.corners))
    filled = Surface(np.concatenate([corners, fitted.corners]), fitted.boundaries, plain, plain)

    def panels() -> list[Panel]:
        return [
            shaded_panel("the surface from the front", surface, FROM_THE_FRONT),
            shaded_panel("the surface alone, its inside brown", surface, camera),
            shaded_panel("with the fitted patches", filled, camera),
        ]

    return sheet_of(panels, lambda _: None)


def replace_line(project_file: Path, line: str, instead: str) -> None:
    lines = project_file.read_text(encoding="utf-8").splitlines()
    if lines.count(line) != 1:
        raise SystemExit(f"{project_file.parent.name}: its project file no longer says '{line}' once")
    lines[lines.index(line)] = instead
    project_file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def shrink(drawn: Path, picture: Path, width: int = WIDTH) -> None:
    """So many pixels across, without white edges, in few colours."""
    with Image.open(drawn) as image:
        full = image.convert("RGB")
    full = full.crop(ImageChops.invert(full).getbbox())
    small = full.resize((width, round(full.height * width / full.width)), Image.Resampling.LANCZOS)
    few = small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=ROUNDS, dither=Image.Dither.NONE)
    few.save(picture, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
