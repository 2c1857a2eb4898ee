"""Links, URDF, MJCF and BibTeX of identified parameters, against pinocchio, MuJoCo and an XML parser."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from kept import same
from simulators import torque_by_mujoco, torque_by_pinocchio
from strategies import seeds

from repro.fitting.export import horizontal_links_of, links_of, mjcf, principal_inertia, urdf
from repro.fitting.outputs import METHODS_FILE, entries
from repro.model.dynamics import inverse_dynamics, mass_matrix
from repro.model.parameters import STANDARD_GRAVITY, Links, inertial_from_links

# What the owners of a real arm, geared and with l1 = 0.3 m, published of it.
REAL = np.array([0.1346, 0.0666, 0.0267, 3.425, 1.090, 0.001, 0.001, 0.146, 0.123])
BETA = np.array([0.5, 0.2, 0.1, 6.0, 2.0, 0.3, 0.2, 0.1, 0.05])

NAMES = ["arm", "a<b & \"c\" 'd'", "<!-- no -->", "ключ é 大", "{name} %s", "tab\ta\nb", "bell\x07null\x00\ud800", ""]


@st.composite
def consistent_betas(draw, near=0.999):
    """Parameters of some arm; I2^2 / 4 up to `near`^2 of I3 (I1 - I3). g1 may have either sign."""
    i3, excess = draw(st.floats(0.01, 1.0)), draw(st.floats(0.01, 1.0))
    i2 = 2.0 * draw(st.floats(0.05, near)) * np.sqrt(i3 * excess)
    g1, g2 = draw(st.floats(-10.0, 30.0)), 0.5 * i2 * STANDARD_GRAVITY / draw(st.floats(0.05, 1.0))
    return np.array([i3 + excess, i2, i3, g1, g2, *(draw(st.floats(0.0, 1.0)) for _ in range(4))])


#: Here, as often rounded, and on the Moon; and lengths that need not agree with the parameters.
gravities = st.sampled_from([STANDARD_GRAVITY, 9.81, 1.62])
given_lengths = st.none() | st.tuples(st.floats(0.05, 1.0), st.floats(0.05, 1.0))


def assert_same_parameters(links, beta):
    """The links have these parameters, but for rounding; g1 is a difference where link 1 is balanced."""
    scale = np.abs(beta[:5]) + np.array([0.0, 0.0, 0.0, links.m2 * links.l1 * links.gravity, 0.0])
    planar = Links(links.m1, links.m2, links.l1, links.lc1, links.lc2, links.j1, links.j2)
    assert (np.abs(inertial_from_links(planar, links.gravity) - beta[:5]) <= 1e-12 * scale).all()
    assert (*links.b, *links.k) == tuple(beta[5:])


def test_models_are_those_kept(file_regression):
    made = {
        "small": links_of(REAL),
        "near the known lengths": links_of(REAL, 9.81, (0.31, 0.2)),
        "far from the known lengths": links_of(REAL, 9.81, (0.3, 0.5)),
        "on the Moon": links_of(BETA, 1.62, (0.4, 0.35)),
        "horizontal": horizontal_links_of(REAL, (0.3, 0.25)),
        "with a rotor": replace(links_of(BETA), rotor=0.004, notes=("a note", "another -- one")),
    }
    models = [write(links, name) for name, links in made.items() for write in (urdf, mjcf)]
    file_regression.check("\n".join(models), check_fn=same, basename="models")


@given(beta=consistent_betas(), gravity=gravities, lengths=given_lengths)
def test_the_links_are_bodies_and_have_the_given_parameters(beta, gravity, lengths):
    links = links_of(beta, gravity, lengths)
    assert_same_parameters(links, beta)
    assert min(links.m1, links.m2, links.l1, links.l2, links.lc2, links.j1, links.j2) > 0.0
    # Of link 1's inertia about its joint, a uniform rod has a quarter about its centre of mass, and so far away.
    assert links.j1 >= 0.25 * (links.m1 * links.lc1**2 + links.j1) * (1.0 - 1e-9)
    assert abs(links.lc1) <= 0.5 * links.l1 * (1.0 + 1e-9)
    for moments in (principal_inertia(links.j1), principal_inertia(links.j2)):
        small, middle, large = sorted(moments)
        assert small > 0.0 and small + middle >= large


def test_a_uniform_rod_is_found_again():
    # With both lengths known, two uniform rods are the member of the family that is chosen.
    m1, m2, l1, l2 = 1.5, 0.8, 0.4, 0.3
    i3 = m2 * l2**2 / 3.0
    weights = np.array([(m1 * l1 / 2.0 + m2 * l1), m2 * l2 / 2.0]) * STANDARD_GRAVITY
    beta = np.array([m1 * l1**2 / 3.0 + m2 * l1**2 + i3, m2 * l1 * l2, i3, *weights, 0.0, 0.0, 0.0, 0.0])
    links = links_of(beta, lengths=(l1, l2))
    np.testing.assert_allclose([links.m1, links.m2, links.l1, links.l2], [m1, m2, l1, l2], rtol=1e-12)
    np.testing.assert_allclose([links.lc1, links.lc2], [l1 / 2.0, l2 / 2.0], rtol=1e-12)
    np.testing.assert_allclose([links.j1, links.j2], [m1 * l1**2 / 12.0, m2 * l2**2 / 12.0], rtol=1e-12)


@pytest.mark.parametrize("gap", [1e-2, 1e-6, 1e-9, 1e-12])
def test_links_exist_up_to_the_edge_and_not_beyond(gap):
    # det M at q2 = 0 is I3 (I1 - I3) - I2^2 / 4, here 0.06 * gap.
    beta = np.array([0.5, 2.0 * np.sqrt(0.06 * (1.0 - gap)), 0.2, 3.0, 1.0, 0.1, 0.1, 0.1, 0.1])
    links = links_of(beta)
    assert_same_parameters(links, beta)
    assert any("nearly singular" in note for note in links.notes)
    assert np.linalg.eigvalsh(mass_matrix(np.zeros(2), beta))[0] > 0.0
    with pytest.raises(ValueError, match=r"I3 \(I1 - I3\) = 0\.06 must be above I2\^2 / 4 = 0\.06"):
        links_of(np.array([0.5, 2.0 * np.sqrt(0.06 * (1.0 + gap)), 0.2, 3.0, 1.0, 0.1, 0.1, 0.1, 0.1]))


@pytest.mark.parametrize(
    ("changes", "condition"),
    [
        ({4: 0.0}, r"^g2 = 0 must be positive: without gravity on link 2, l1 .* is not fixed"),
        ({4: -2.0}, r"^g2 = -2 must be positive: q = 0 must hang down"),
        ({3: -6.0, 4: -2.0}, r"^g2 = -2 must be positive: q = 0 must hang down"),
        ({1: 0.0}, r"^I2 = 0 must be positive: with g2 = 2 "),
        ({1: -0.2}, r"^I2 = -0\.2 must be positive"),
        ({1: -0.2, 4: -2.0}, r"^I2 = -0\.2 and g2 = -2 must be positive: with both negative"),
        ({1: 0.5}, r"^I3 \(I1 - I3\) = 0\.04 must be above I2\^2 / 4 = 0\.0625: M\(q\) is not positive definite"),
        ({0: 0.05}, r"^I3 \(I1 - I3\) = -0\.005 must be above"),
        ({0: 0.1}, r"^I3 \(I1 - I3\) = 0 must be above"),
        ({2: 0.0}, r"^I3 = 0 must be positive"),
        ({0: -0.5, 2: -0.1}, r"^I1 = -0\.5 must be positive"),
        ({4: 1e-6}, r"^l1 = .* m is no arm's length"),
        ({4: BETA[1] * 9.80665 / 2 / 1001.0}, r"^l1 = .* = 1001 m is no arm's length"),
        ({6: -0.03}, r"^b2 = -0\.03: friction must not be negative"),
        ({7: -0.03}, r"^k1 = -0\.03: friction must not be negative"),
        ({3: 1e200}, r"^g1 = 1e\+200"),
        ({0: 1e200}, r"^I1 = 1e\+200"),
        ({3: np.nan}, r"^beta: every parameter must be finite"),
    ],
)
def test_parameters_that_no_links_have_are_refused(changes, condition):
    beta = BETA.copy()
    for place, value in changes.items():
        beta[place] = value
    with pytest.raises(ValueError, match=condition):
        links_of(beta)


@given(values=st.lists(st.floats(-1e15, 1e15), min_size=9, max_size=9))
@example(values=[5e-324] * 9)
@example(values=[1e-160, 1e-161, 5e-161, 1e-160, 1e-160, 0.0, 0.0, 0.0, 0.0])
@example(values=[1e12, 1e6, 1e11, 1e12, 1e4, 0.0, 0.0, 0.0, 0.0])
@example(values=[2e-12, 1.9e-12, 1e-12, -1e12, 1e-12, 0.0, 0.0, 0.0, 0.0])
def test_any_numbers_give_links_or_a_reason(values):
    beta = np.array(values)
    try:
        links = links_of(beta)
    except ValueError as error:
        assert "\n" not in str(error)
    else:
        assert np.isfinite([links.m1, links.m2, links.lc1, links.lc2, links.j1, links.j2]).all()
        assert min(links.m1, links.m2, links.j1, links.j2) > 0.0


@pytest.mark.slow
@given(beta=consistent_betas(near=0.95), gravity=gravities, lengths=given_lengths, seed=seeds)
def test_simulators_need_the_torque_of_eq_1(beta, gravity, lengths, seed):
    rng = np.random.default_rng(seed)
    q, dq, ddq = rng.uniform(-6.0, 6.0, (5, 2)), rng.uniform(-8.0, 8.0, (5, 2)), rng.uniform(-40.0, 40.0, (5, 2))
    links = links_of(beta, gravity, lengths)
    expected = inverse_dynamics(q.T, dq.T, ddq.T, np.concatenate([beta[:5], np.zeros(4)])).T
    by_pinocchio = torque_by_pinocchio(pin.buildModelFromXML(urdf(links, "arm")), gravity)
    for torque in (by_pinocchio, torque_by_mujoco(mjcf(links, "arm"))):
        tau = np.stack([torque(*state) for state in zip(q, dq, ddq, strict=True)])
        np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-9)


def test_the_tool_is_where_the_angles_put_it():
    links, q = links_of(REAL, 9.81, (0.3, 0.2)), np.array([0.4, 0.7])
    angles, lengths = np.cumsum(q), np.array([links.l1, 0.2])
    expected = [lengths @ np.sin(angles), 0.0, -lengths @ np.cos(angles)]  # positive angles swing towards +x
    model = pin.buildModelFromXML(urdf(links, "arm"))
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    np.testing.assert_allclose(data.oMf[model.getFrameId("tool")].translation, expected, atol=1e-14)
    simulated = mujoco.MjModel.from_xml_string(mjcf(links, "arm"))
    state = mujoco.MjData(simulated)
    state.qpos[:] = q
    mujoco.mj_forward(simulated, state)
    np.testing.assert_allclose(state.site("tool").xpos, expected, atol=1e-14)
    middle = np.array([links.l1 * np.sin(q[0]), 0.0, -links.l1 * np.cos(q[0])])
    # Links are drawn from joint to joint.
    np.testing.assert_allclose(state.geom_xpos, [middle / 2, (middle + expected) / 2], atol=1e-6)
    np.testing.assert_allclose(simulated.geom_size[:, 1], [0.5 * links.l1, 0.5 * links.l2], atol=1e-6)


def test_friction_and_motors_arrive():
    links = links_of(BETA)
    model = pin.buildModelFromXML(urdf(links, "arm"))
    np.testing.assert_array_equal(model.damping, BETA[5:7])
    np.testing.assert_array_equal(model.upperDryFrictionLimit, BETA[7:9])
    assert list(model.names) == ["universe", "joint1", "joint2"]
    for text in (urdf(links, "arm"), mjcf(links, "arm")):
        simulated = mujoco.MjModel.from_xml_string(text)
        np.testing.assert_array_equal(simulated.dof_damping, BETA[5:7])
        np.testing.assert_array_equal(simulated.dof_frictionloss, BETA[7:9])
    state = mujoco.MjData(simulated)  # of the MJCF, which has motors
    state.ctrl[:] = [1.5, -0.5]
    mujoco.mj_forward(simulated, state)
    np.testing.assert_array_equal(state.qfrc_actuator, [1.5, -0.5])


@pytest.mark.parametrize("write", [urdf, mjcf])
@pytest.mark.parametrize("name", NAMES)
def test_any_name_is_safe(write, name):
    text = write(links_of(BETA), name)
    root = ElementTree.fromstring(text.encode("utf-8"))
    if write is urdf:
        read, joints = root.get("name"), pin.buildModelFromXML(text).nq
    else:
        read, joints = root.get("model"), mujoco.MjModel.from_xml_string(text).nv
    assert read == re.sub("[\x00\x07\ud800]", "_", " ".join(name.split())) or (name == "" and read == "arm")
    assert joints == 2


def test_bibliography_is_whole():
    text = METHODS_FILE.read_text(encoding="utf-8")
    assert text.isascii()  # so that the oldest BibTeX reads it
    known = entries()
    assert len(known) == len(re.findall(r"^@", text, re.MULTILINE))
    for key, entry in known.items():
        assert entry.count("{") == entry.count("}")
        fields = dict(re.findall(r"^  (\w+)\s*= \{(.*)\},?$", entry, re.MULTILINE))
        if key == "cnn_identification":  # the text at hand names no authors and no year
            assert {"title", "journal", "note"} == fields.keys()
        else:
            assert {"title", "author", "year"} <= fields.keys(), key
            assert fields["year"] in key
        assert all(line.endswith(",") == (number > 2) for number, line in enumerate(reversed(entry.splitlines()), 1))
        assert re.fullmatch(r"10\.\d{4,}/\S+", fields.get("doi", "10.1000/none"))
