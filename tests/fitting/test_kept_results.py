"""All that `repro identify` says and writes of three kinds of log, as it was kept."""

import json
import logging
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from experiment_example import CAPTURES
from fitting_example import png
from kept import blocks, drawn, flat, same
from log_example import BETA, motion, text
from regression_example import other_motion

import repro
from repro.board.capture import read_capture, write_capture
from repro.model.dynamics import inverse_dynamics

pytestmark = pytest.mark.slow

#: What `write` records, in the words of an arm file.
ARM = """
name: bench arm
columns: {time: "t [ms]", q1: "shoulder [deg]", q2: "elbow [deg]", tau1: "M1 [mN m]", tau2: "M2 [mN m]"}
sign: [1, -1]
torque_sign: [-1, -1]
second_joint_absolute: true
zero: [0, -0.3]
torque_offset: [0.1, 0]
torque_scale: [0.8, 1]
torque_limit: [9, 4]
position_limit: [[-2, 2], [-1.5, 2.5]]
gravity: 9.8
link_lengths: [0.25, 0.2]
friction_steepness: auto
"""


def write(path, moved=motion, seconds=14.0, start=0.0, zero=0.0, scale=1.0, limit=np.inf, gap=(0.0, 0.0)):
    """A log of an arm with a rotor and friction beyond Eq. 1, whose torque acts 4 ms late; its name is its seed."""
    t = np.arange(round(seconds * 250)) / 250
    t = t[(t < gap[0]) | (t >= gap[1])]
    q = moved(t + start)[0]
    acting = moved(t + start + 0.004)
    load = inverse_dynamics(*acting, np.where(np.arange(9) < 5, BETA, 0.0))[0]
    tau = inverse_dynamics(*acting, BETA)
    tau += np.stack([0.15 * np.abs(load) * np.tanh(20.0 * acting[1][0]), 0.003 * acting[2][1]])
    noise = np.random.default_rng(ord(path.stem)).normal(size=(4, t.size))
    tau += np.array([[0.02], [0.01]]) * noise[:2]
    tau[0] = np.clip(tau[0], -limit, limit)
    shoulder, elbow = np.degrees([q[0] + zero, -(q[0] + q[1]) - 0.3]) + 0.02 * noise[2:]
    table = {"t [ms]": 1e3 * t, "shoulder [deg]": shoulder, "elbow [deg]": elbow}
    table |= {"M1 [mN m]": 1e3 * (0.1 - 0.8 * tau[0]), "M2 [mN m]": 1e3 * scale * tau[1]}
    path.write_text(text(table, 8), encoding="utf-8")
    return path


def several(folder):
    """Two logs, one with a gap and a limited torque, one with a zero error; a prior; friction; validation clipped."""
    return {
        "log": [write(folder / "b.csv", start=5.0, limit=5.0, gap=(4.0, 5.5)), write(folder / "a.csv", zero=0.06)],
        "validate": write(folder / "v.csv", other_motion, 6.0, limit=2.0),
        "method": ["ordinary", "weighted", "robust", "bounded"],
        "friction": True,
        "prior": {"g1": {"value": 3.2, "sd": 0.2}, "k2": {"value": 0.1, "sd": 0.01}, "b1": {"value": 0.07, "sd": 0}},
    }


def short(folder):
    """A log with a wrong torque constant, whose friction is left in, and synthetic logs."""
    log = write(folder / "c.csv", seconds=8.0, scale=1.5)
    return {"log": log, "method": ["ordinary", "consistent"], "self_test": True}


def capture(folder):
    """The simulated board's recording, which excites little, and one with two frames lost."""
    data, metadata = (CAPTURES / "T4.bin").read_bytes(), read_capture(CAPTURES / "T4.bin").metadata
    write_capture(folder / "T4.bin", data[:8000] + bytes(16) + data[8016:], replace(metadata, host=None))
    files = {"log": str(CAPTURES / "ID.bin"), "validate": [str(CAPTURES / "T1.bin"), folder / "T4.bin"]}
    return files | {"method": ["instrumental", "consistent", "parsimonious"], "cutoff": 3.0, "filter": "butterworth"}


@pytest.mark.parametrize("logs", [several, short, capture])
def test_results_pages_and_messages_are_those_kept(tmp_path, monkeypatch, caplog, file_regression, logs):
    figures = []
    monkeypatch.setattr("repro.fitting.evaluate.DRAWS", 3)
    monkeypatch.setattr("repro.fitting.figures.MAX_DRAWN_LOGS", 1)
    monkeypatch.setattr("repro.fitting.figures._png", lambda figure: figures.append(figure) or png())
    caplog.set_level(logging.INFO, "repro")
    arm = tmp_path / "arm.yaml"
    arm.write_text(ARM, encoding="utf-8")
    result = repro.identify(**logs(tmp_path), **({} if logs is capture else {"arm": arm}))
    out = tmp_path / "out"
    names = result.save(out)
    files = {name: (out / name).read_text(encoding="utf-8") for name in names if name != "provenance.json"}
    lines = [*names, *(message for message in caplog.messages if "%" not in message), *str(result).splitlines()]
    lines += flat(json.loads(files.pop("parameters.json")))
    lines += blocks(files.pop("report.html"))
    lines += [line for figure in figures for line in drawn(figure)]
    residuals = pd.read_csv(out / "residuals.csv")
    files["residuals.csv"] = residuals[:: len(residuals) // 40].to_csv(index=False, float_format="%.4f")
    lines += [line for name in sorted(files) for line in files[name].splitlines()]
    kept = "\n".join(" ".join(line.split()) for line in lines if line.strip()) + "\n"
    file_regression.check(re.sub(re.escape(str(tmp_path)), "", kept), check_fn=same, basename=logs.__name__)
