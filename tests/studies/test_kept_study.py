"""The kept study: its tables and maps follow from its outcomes, and the outcomes are those of the default design."""

import io
from pathlib import Path

import pandas as pd
import pytest

from repro.config.check import load_config
from repro.exhibits.declare import Exhibit
from repro_studies.design import FACTORS, jobs
from repro_studies.exhibits import study

REFERENCE = Path(__file__).resolve().parents[2] / "docs/reference"
CONFIG = load_config(REFERENCE / "config.yaml")
OUTCOMES = [REFERENCE / f"study/cells/{job}.csv" for job in jobs(CONFIG)]
EXHIBITS = [value for value in vars(study).values() if isinstance(value, Exhibit)]


@pytest.mark.parametrize("exhibit", EXHIBITS, ids=lambda exhibit: exhibit.target)
def test_numbers_of_each_exhibit_follow_from_the_outcomes(exhibit):
    kept = pd.read_csv(REFERENCE / f"{exhibit.kind}s/{exhibit.name}.csv")
    text = exhibit.numbers({"outcomes": OUTCOMES}, CONFIG).to_csv(index=False)
    pd.testing.assert_frame_equal(pd.read_csv(io.StringIO(text)), kept, rtol=1e-9, atol=1e-12)


def test_each_condition_has_its_arms_and_methods():
    for cells, path in zip(jobs(CONFIG).values(), OUTCOMES, strict=True):
        found = pd.read_csv(path).groupby(list(FACTORS))["arm"].nunique()
        assert found.to_dict() == {tuple(vars(cell).values())[:4]: CONFIG.study.arms for cell in cells}
