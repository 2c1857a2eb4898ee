"""`repro excite` as a user runs it: the files it writes are of the motion it tells of, and what is wrong is refused."""

import json

import numpy as np
import pandas as pd
import pytest
import yaml
from experiment_example import ROOT, refusal_in, refused
from pytest import approx

from repro.cli import main
from repro.commands.boards import program_of
from repro.commands.excite import read_guess
from repro.config.check import load_config
from repro.identification.armfile import read_arm
from repro.identification.exciting_motion import Envelope, published
from repro.logs.load import read_log
from repro.model.dynamics import inverse_dynamics
from repro.model.parameters import NAMES, UNITS

pytestmark = pytest.mark.slow

BETA = np.array([0.12, 0.0026, 0.0227, 0.95, 0.078, 0.08, 0.0036, 0.454, 0.31])
LIMITS = {"position_limit": [[-1.4, 1.4], [-1.2, 1.2]], "speed_limit": [4, 5], "torque_limit": [1.9, 0.9]}
SHORT = ("--duration", "8", "--harmonics", "4")


def excite(tmp_path, *options, out="out", **keys):
    content = {key: value for key, value in (LIMITS | keys).items() if value is not None}
    (tmp_path / "arm.yaml").write_text(yaml.safe_dump(content))
    return main(["excite", "--arm", str(tmp_path / "arm.yaml"), "-o", str(tmp_path / out), *map(str, options)])


def test_what_is_written_is_the_motion_that_is_reported(tmp_path, capsys):
    assert excite(tmp_path, *SHORT, "--guess", *BETA) == 0
    out = tmp_path / "out"
    assert {path.name for path in out.iterdir()} == {"excite.json", "motion.csv", "motion.pdf", "motion.png"}
    table, content = pd.read_csv(out / "motion.csv"), json.loads((out / "excite.json").read_text())
    assert list(table) == [*("time_s", "q1_rad", "q2_rad", "dq1_rad/s", "dq2_rad/s", "ddq1_rad/s^2", "ddq2_rad/s^2")]
    assert len(table) == 8 * 400 + 1
    q, dq, ddq = (table.iloc[:, k : k + 2].to_numpy().T for k in (1, 3, 5))
    np.testing.assert_allclose(table["time_s"], np.arange(len(table)) / 400, atol=1e-9)
    np.testing.assert_allclose(np.gradient(q, table["time_s"], axis=1)[:, 1:-1], dq[:, 1:-1], atol=0.01)
    told = content["optimised"]
    assert told["position_rad"] == approx(np.stack([q.min(1), q.max(1)], axis=1))
    assert told["speed_rad_s"] == approx(np.abs(dq).max(1))
    assert told["acceleration_rad_s2"] == approx(np.abs(ddq).max(1))
    assert told["torque_nm"] == approx(np.abs(inverse_dynamics(q, dq, ddq, BETA)).max(1))
    assert (np.array(told["torque_nm"]) <= LIMITS["torque_limit"]).all()
    assert content["settings"]["guess"] == BETA.tolist()
    limits = Envelope(read_arm(tmp_path / "arm.yaml"), BETA)
    eq10 = published(limits, (3200, 1 / 400), 4 / 8, np.full(2, 0.05))  # up to the highest harmonic
    assert content["eq10"]["speed_rad_s"] == approx(np.abs(eq10.dq).max(1))
    lines = capsys.readouterr().out.splitlines()
    for name in NAMES:
        row = next(line for line in lines if line.startswith(f"  {name}, "))
        ours, theirs, ratio = map(float, row.split()[-3:])
        assert [ours, theirs] == approx([content[key]["half_widths"][name] for key in ("optimised", "eq10")], rel=0.01)
        assert ratio == approx(ours / theirs, abs=0.02)
    # The board takes the table as it is, and the configured arm can do it.
    assert program_of(load_config(ROOT / "config/config.yaml"), str(out / "motion.csv")).q == approx(q)


def test_the_table_is_in_the_angles_that_the_arm_records(tmp_path):
    keys = {"sign": [1, -1], "zero": [0.5, -0.7], "second_joint_absolute": True, "speed_limit": [0.05, 6]}
    keys["position_limit"] = [[-1, 1], [-0.01, 0.01]]
    assert excite(tmp_path, "--duration", 2, "--rate", 100, "--harmonics", 6, **keys) == 0
    own = pd.read_csv(tmp_path / "out" / "motion.csv")
    log = own[["time_s", "q1_rad", "q2_rad", "dq1_rad/s", "dq2_rad/s"]].assign(tau1=np.sin(own.time_s), tau2=own.time_s)
    log.to_csv(tmp_path / "log.csv", index=False)
    read = read_log(tmp_path / "log.csv", read_arm(tmp_path / "arm.yaml"))
    eq1, eq10 = (json.loads((tmp_path / "out/excite.json").read_text())[key] for key in ("optimised", "eq10"))
    assert eq10["condition"] is None  # within limits so narrow it cannot separate the parameters
    assert np.stack([read.q.min(1), read.q.max(1)], axis=1) == approx(np.array(eq1["position_rad"]), abs=1e-8)
    assert np.abs(read.dq).max(1) == approx(eq1["speed_rad_s"], abs=1e-8)


@pytest.mark.parametrize(
    ("options", "keys", "place", "found"),
    [
        (("--guess", *BETA), {"torque_limit": None}, "arm.yaml: torque_limit", "nothing"),
        ((), {"position_limit": [[-1e-5, 1e-5]] * 2}, "arm.yaml: position_limit, speed_limit, torque_limit", ""),
        (("--guess", 1, 2), {}, "--guess", "['1', '2']"),
        (("--guess", 1, 0, -0.05, *BETA[3:]), {}, "--guess", ""),
        (("--guess", "arm.yaml"), {}, "arm.yaml", "no such file"),
        (("--harmonics", 2), {}, "harmonics", "2"),
        (("--rate", 1), {}, "--rate times duration", "8 samples"),
    ],
)
def test_what_is_wrong_is_reported_in_one_line_and_leaves_nothing(tmp_path, capsys, options, keys, place, found):
    assert excite(tmp_path, *SHORT, *options, **keys) == 2
    error = refusal_in(capsys.readouterr().err.splitlines()[-1])
    assert error.place.endswith(place) and error.found.startswith(found)
    assert {path.name for path in tmp_path.iterdir()} == {"arm.yaml"}


@pytest.mark.parametrize(
    ("row", "key", "value", "place", "found"),
    [
        (0, "estimate", "0.1", "estimate", "'0.1'"),
        (1, "name", "I1", "name", "'I1'"),
        (8, "unit", "kg m^2", "unit", "'kg m^2'"),
    ],
)
def test_a_result_is_a_guess_unless_a_name_a_unit_or_a_type_differs(tmp_path, row, key, value, place, found):
    parameters = [{"name": n, "unit": u, "estimate": x} for n, u, x in zip(NAMES, UNITS, BETA, strict=True)]
    methods = [{"method": "ordinary", "parameters": []}, {"method": "bounded", "parameters": parameters}]
    content = {"recommended": "bounded", "methods": methods}
    file = tmp_path / "parameters.json"
    file.write_text(json.dumps(content))
    np.testing.assert_array_equal(read_guess([str(file)]), BETA)
    parameters[row][key] = value
    file.write_text(json.dumps(content))
    error = refused(read_guess, [str(file)])
    assert error.place == f"{file}: methods[1].parameters[{row}].{place}" and error.found == found
