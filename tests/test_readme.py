"""The project file in the README builds as it stands there; every project has a README with its picture."""

import re
from pathlib import Path

import pytest
from written import read_report

from flatnet.cli import main

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
PROJECTS = sorted(path.parent for path in ROOT.glob("projects/*/project.yaml"))


def test_the_example_builds(tmp_path):
    (example,) = re.findall(r"```yaml\n(.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "project.yaml").write_text(example + "nesting: {seconds: 1}\n")
    assert main(["check", str(tmp_path / "project.yaml")]) == 0
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    (layout,) = read_report(tmp_path / "out")["layouts"]
    assert [(piece["copy"], piece["mirrored"]) for piece in layout["pieces"]] == [(1, False), (2, True)]


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda folder: folder.name)
def test_every_project_has_a_readme_that_shows_its_picture_and_is_listed(folder):
    text = (folder / "README.md").read_text(encoding="utf-8")
    shown = [(folder / link).resolve() for link in re.findall(r"!\[.+?\]\((.+?)\)", text)]
    assert ROOT.resolve() / "docs" / "pictures" / f"{folder.name}.png" in shown
    assert all(picture.is_file() for picture in shown)
    assert f"`{folder.name}`" in README.read_text(encoding="utf-8").partition("## Projects")[2]
