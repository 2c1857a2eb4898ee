"""`repro check` reads what Snakemake would: a valid configuration, or one line with exit code 2."""

from pathlib import Path

import pytest

from repro.cli import main

CONFIG = Path(__file__).parents[2] / "config"


def check(*files):
    return main(["check", "--config", str(CONFIG / "config.yaml"), *map(str, files)])


def test_the_configurations_of_the_project_are_valid(capsys):
    assert check(CONFIG / "quick.yaml") == 0
    assert "quick.yaml: valid" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "place"),
    [
        (b"training: {stepz: 1}\n", "training.stepz"),
        (b"training: {steps: 1, steps: 2}\n", "line 1"),
        (b"experiment: {captures: README.md}\n", "experiment.captures: found README.md, expected a folder with"),
        (b"training: {source: stored, networks: none}\n", "training.networks: found none, expected a folder with"),
    ],
)
def test_a_fault_is_one_line(tmp_path, capsys, content, place):
    file = tmp_path / "my.yaml"
    file.write_bytes(content)
    assert check(file) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{file}: ")
    assert place in line
