"""Every kind of bad log is found in one line: what was found and what to do."""

import time

import numpy as np
import pytest
import yaml
from kept import same
from log_damage import GOOD, NOISE, REFUSED, SUSPECTED, absolute, scaled
from log_example import BETA, motion, write

from repro.errors import InputError
from repro.identification.armfile import Arm
from repro.identification.log import Log, uniform
from repro.logs import torque_limits
from repro.logs.conventions import READS_BETTER
from repro.logs.diagnostics import describe, diagnose
from repro.logs.load import read_log
from repro.model.dynamics import forward_dynamics

pytestmark = pytest.mark.slow


def described(path, arm):
    return describe(read_log(path, arm), arm)


@pytest.fixture(scope="module")
def suspected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("suspected")
    return {name: described(write(folder, content), Arm(**keys)) for name, content, keys in SUSPECTED}


@pytest.mark.filterwarnings("error")
def test_a_bad_log_is_refused_in_one_line_and_an_odd_one_warned_of(tmp_path, suspected, file_regression):
    sound = described(write(tmp_path, GOOD), Arm())
    assert sound.warnings == ()
    said = [f"{label} {value}" for label, value in sound.facts]
    for name, content, keys in REFUSED:
        path, began = write(tmp_path, content), time.process_time()
        with pytest.raises(InputError) as caught:
            uniform(read_log(path, Arm(**keys)))
        assert time.process_time() - began < 5.0, name
        message = str(caught.value)
        assert "\n" not in message, name
        assert "log.csv" in message or message.startswith("arm file: "), name
        assert len(message) < 400, name
        said.append(f"{name}: {message}")
    for name, log in suspected.items():
        assert log.warnings, name
        assert not any("\n" in warning or len(warning) > 400 for warning in log.warnings), name
        facts = (f"{label} {value}" for label, value in log.facts if (label, value) not in sound.facts)
        said += [f"{name}: {line}" for line in (*facts, *log.notes, *log.warnings)]
    kept = "\n".join(said).replace(str(tmp_path), "")
    file_regression.check(kept + "\n", check_fn=same, basename="messages")


def test_the_remedy_of_another_convention_or_delay_helps(tmp_path, suspected):
    tried, better = [], (READS_BETTER, "the torque fits")
    for name, content, keys in SUSPECTED:
        before = [w for w in suspected[name].warnings if w.startswith(better) and "write into" in w]
        if "units" in keys or not before:
            continue
        remedy = before[0].partition("write into the arm file: ")[2].partition(" (")[0].partition(" or ")[0]
        arm = Arm(**keys | yaml.safe_load(remedy.replace(" and ", "\n")))
        after = described(write(tmp_path, content), arm).warnings
        assert not any(w.startswith(better) or "Eq. 1" in w or "velocity" in w for w in after), name
        tried.append(name)
    assert len(tried) == 20


def moved(torque, x, v, noise):
    """Log of an arm under a torque that depends on sample, position and velocity, recorded with noise."""
    h, n = 0.002, noise.shape[1]
    q, tau = np.empty((2, n)), np.empty((2, n))
    for k in range(n):
        q[:, k], tau[:, k] = x, torque(k, x, v)
        for _ in range(2):
            v = v + 0.5 * h * forward_dynamics(x, v, tau[:, k], BETA)
            x = x + 0.5 * h * v
    return Log(name="log.csv", t=h * np.arange(n), q=q, tau=tau + noise)


@pytest.mark.parametrize("seed", range(3))
def test_noise_about_zero_in_a_free_fall_suggests_no_other_reading(seed):
    rng = np.random.default_rng(seed)
    log = moved(lambda *_: np.zeros(2), rng.uniform(-2.5, 2.5, 2), np.zeros(2), 0.01 * rng.normal(size=(2, 2500)))
    warnings = diagnose(log, Arm())
    assert len(warnings) <= 1
    assert not any(line.startswith(READS_BETTER) for line in warnings)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_switched_torque_is_neither_noise_nor_saturated(noise):
    """Most of it is above any cutoff, and what is below drives the arm."""
    wanted, speed, _ = motion(0.002 * np.arange(2500))

    def switched(k, x, v):
        return np.array([8.0, 4.0]) * np.sign(20.0 * (wanted[:, k] - x) + speed[:, k] - v)

    log = moved(switched, wanted[:, 0], speed[:, 0], noise * np.random.default_rng(2).normal(size=(2, 2500)))
    assert diagnose(log, Arm()) == ()
    assert not torque_limits.saturated(log).any()


@pytest.mark.parametrize(
    ("table", "named"),
    [
        (GOOD, None),
        (scaled(-1, "tau1"), "torque_sign: [-1, 1]"),
        (absolute(), "second_joint_absolute: true"),
        (scaled(2, "q1", "dq1"), "multiply the columns q1, q2 by 0.5, 1"),
    ],
)
def test_noise_of_the_torque_of_joint_2_hides_no_convention(table, named):
    tau = np.stack([table["tau1"], table["tau2"] + 3.0 * np.std(table["tau2"]) * NOISE[1]])
    log = Log(name="log.csv", t=table["time"], q=np.stack([table["q1"], table["q2"]]), tau=tau)
    found = [warning for warning in diagnose(log, Arm()) if warning.startswith(READS_BETTER)]
    assert len(found) == (named is not None)
    assert all(str(named) in warning for warning in found)


#: A header, and the columns that are proposed: none of another kind, none that was commanded or filtered.
FOREIGN = {
    "Zeit,Schulter [deg],q2,M1,M2": "Zeit,HEADER,q2,M1,M2",
    "TIME,JointPosition[0],JointPosition[1],M[0],M[1]": "TIME,JointPosition[0],JointPosition[1],M[0],M[1]",
    "seq,stamp,pos_a,pos_b,load": "stamp,HEADER,HEADER,HEADER,HEADER",
    "t,q_cmd_1,q_cmd_2,q_act_1,q_act_2,i_1,i_2": "t,q_act_1,q_act_2,HEADER,HEADER",
    "t,f_filt_1,f_filt_2,x_angle_2,x_angle_1,x_tau_1,x_tau_2": "t,x_angle_1,x_angle_2,x_tau_1,x_tau_2",
}


@pytest.mark.parametrize(("header", "proposed"), FOREIGN.items())
def test_foreign_headers_are_proposed_for_the_arm_file(tmp_path, header, proposed):
    with pytest.raises(InputError) as refused:
        read_log(write(tmp_path, f"{header}\n{','.join('0' * header.count(',') + '0')}\n"), Arm())
    skeleton = yaml.safe_load("columns:" + str(refused.value).rpartition("columns:")[2])
    assert skeleton["columns"] == dict(zip(("time", "q1", "q2", "tau1", "tau2"), proposed.split(","), strict=True))
