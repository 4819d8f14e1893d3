"""The project file in the README builds as it stands there."""

import re
from pathlib import Path

from written import read_report

from flatnet.cli import main

README = Path(__file__).parents[1] / "README.md"


def test_the_example_builds(tmp_path):
    (example,) = re.findall(r"```yaml\n(.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "project.yaml").write_text(example + "nesting: {seconds: 1}\n")
    assert main(["check", str(tmp_path / "project.yaml")]) == 0
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    (layout,) = read_report(tmp_path / "out")["layouts"]
    assert [(piece["copy"], piece["mirrored"]) for piece in layout["pieces"]] == [(1, False), (2, True)]
