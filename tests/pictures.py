"""Build every project and draw it into docs/pictures: `python -m tests.pictures [NAME ...]`."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image

import flatnet
from flatnet.report.pictures import draw

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
#: Picture of a variant -> its project, a line of the project file, and what stands there instead.
VARIANTS = {
    f"{shoe}_fair": (shoe, "fitting: {normal_weight: 100}", "fitting: {normal_weight: 1}")
    for shoe in ("shoe_1", "shoe_2")
}
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
    print(f"docs/pictures/{name}.png", flush=True)
    return True


def replace_line(project_file: Path, line: str, instead: str) -> None:
    lines = project_file.read_text(encoding="utf-8").splitlines()
    if lines.count(line) != 1:
        raise SystemExit(f"{project_file.parent.name}: its project file no longer says '{line}' once")
    lines[lines.index(line)] = instead
    project_file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def shrink(drawn: Path, picture: Path) -> None:
    with Image.open(drawn) as image:
        size = (WIDTH, round(image.height * WIDTH / image.width))
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    few = small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=ROUNDS, dither=Image.Dither.NONE)
    few.save(picture, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
