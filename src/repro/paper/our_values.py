"""Our value of every number that the paper prints as its own, in the order of the paper.

The place that begins the id of a published number is the name of the function that computes ours: `table10` has
``table10/ID/algorithm1/total/joint1``. An id with ``@`` compares an extension of ours with the same number.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from repro.board import frames
from repro.cnn import architecture, dataset, image, priors
from repro.cnn.architecture import NetworkSettings
from repro.config.model import Configuration
from repro.model import dynamics, parameters, stability
from repro.model.parameters import NAMES
from repro.paper.claims import Basis
from repro.paper.our_results import (
    JOINTS,
    LEAST_SQUARES,
    LISTED,
    ON_PAPERS_ARMS,
    ON_SIMULATED_ARM,
    VALIDATION_CASES,
    Results,
    Values,
    board_property,
    board_size,
    comparisons_in_words,
    estimates_of_test_arm,
    held_out_loss,
    largest_validation_total,
    mean_numeric_total,
    of_appendix_arm,
    on_papers_arms,
    on_simulated_arm,
    smallest_identification_total,
    training_note,
    validation_ratio,
)
from repro.paper.our_settings import (
    arithmetic,
    bench,
    constant,
    filter_coefficient,
    image_samples,
    joints,
    literal,
    numeric_arms,
    of_paper_recipe,
    recipe_images,
    recipe_iterations,
    sampling_period,
    setting,
    true_parameters,
)
from repro.paper.published import NUMERIC_CASES, Published
from repro.signals import programs, trajectories, validation_motions
from repro.signals.metric import metr2ev

QUANTITIES = ("time", "frequency", "total")


def our_values(published: Published, config: Configuration, found: Mapping[str, float], results: Results) -> Values:
    """Compute our values; `found` has what the findings of the audit calculate, by their ids."""
    return {
        **abstract(config, results),
        **section1a(config),
        **section2(config),
        **section3(published, config, results),
        **fig03(),
        **section4a(config),
        **eq08(config),
        **eq09(),
        **eq10(),
        **section4b(config),
        **section4c(config),
        **algorithm1(config),
        **section5(config),
        **eq16(),
        **section5a(config, results),
        **section5b(config),
        **table04(published, config, results),
        **table05(published, config, results),
        **table07(config, results),
        **section5c(config, results),
        **table08(config, results),
        **table10(results),
        **section6(config, results),
        **section7(config, results),
        **appendix(found, results),
    }


def abstract(config: Configuration, results: Results) -> Values:
    """Abstract."""
    return {
        "abstract/joints": joints(config),
        "abstract/numeric-arms": numeric_arms(config),
        **mean_numeric_total("abstract/numeric/total", config, results),
        **smallest_identification_total("abstract/experimental/total", results),
    }


def section1a(config: Configuration) -> Values:
    """Section I-A, other works and contributions."""
    random = sum(motion.random for motion in programs.VALIDATION.values())
    return {
        "section1a/joints": joints(config),
        "section1a/random-trajectories": constant(programs, random, "T1"),
    }


def section2(config: Configuration) -> Values:
    """Section II, model and controller."""
    return {"section2/joints": joints(config)}


def section3(published: Published, config: Configuration, results: Results) -> Values:
    """Section III, arm and board."""
    period, lengths, speed = config.signals.sampling_period_s, config.arm.link_lengths_m, config.board.speed_limit_rad_s
    torque_bits = frames.TORQUE_BITS[0].bit_count()
    position_bits = 8 * frames.FRAME_BYTES - frames.FIXED_BITS.bit_count() - 2 * torque_bits  # of both joints
    gear_ratio = frames.COUNTS_PER_TURN / 64
    used, available = (published[f"section3/logic-{name}"].value for name in ("used", "available"))
    design = "a design of ours, synthesised but not placed; other floating-point units and sharing than the authors'"
    memory = "a design of ours: trajectory, and the last 2048 bytes of the downlink"
    register = "width in the design in logic"
    return {
        "section3/joints": joints(config),
        "section3/sampling-period": sampling_period(config),
        "section3/sampling-rate": arithmetic(1 / period, "1 / 2.5 ms"),
        "section3/position-register": board_property(results, "Decoder", "position_bits", register),
        "section3/frame": constant(frames, 8 * frames.FRAME_BYTES),
        "section3/identifier": constant(frames, (frames.FIXED_BITS >> 56).bit_count() / 8),
        "section3/position-fields": constant(frames, position_bits / 16),
        "section3/position-bits": constant(frames, position_bits / 2),
        "section3/torque-bits": constant(frames, torque_bits),
        "section3/position-low": literal(arithmetic(-(2**15), "-2^15")),
        "section3/position-high": literal(arithmetic(2**15 - 1, "2^15 - 1")),
        "section3/position-turns": arithmetic((2**15 - 1) / frames.COUNTS_PER_TURN, "32767 / 8400"),
        "section3/torque-low": arithmetic(-(2 ** (torque_bits - 1)), "-2^10"),
        "section3/torque-high": arithmetic(2 ** (torque_bits - 1) - 1, "2^10 - 1"),
        "section3/torque-unit": arithmetic(100 / frames.PWM_LIMIT, "100 % / 1023"),
        "section3/motors": setting("board.full_torque_nm", len(config.board.full_torque_nm)),
        "section3/gear-ratio": constant(frames, gear_ratio, "8400 counts a joint turn, 64 a motor turn"),
        "section3/motor-torque": bench(),
        "section3/motor-voltage": bench(),
        "section3/encoder-step": arithmetic(frames.RADIANS_PER_COUNT, "2 pi / (64 x 131.25)"),
        "section3/joint-speed": setting("board.speed_limit_rad_s", speed),
        "section3/tip-speed": setting(
            "arm.link_lengths_m", sum(lengths) * speed, "their sum times board.speed_limit_rad_s"
        ),
        "section3/logic-used": board_size(results, "board", "elements", design),
        "section3/logic-available": board_property(results, "device", "elements", "data sheet of the device"),
        "section3/logic-share": arithmetic(100 * used / available, f"{used:g} / {available:g}"),
        "section3/memory-share": board_size(results, "board (%)", "memory_bits", memory),
        "section3/clock": bench(),
    }


def fig03() -> Values:
    """Fig. 3, the controller."""
    return {f"fig03/saturation/joint{joint}": constant(frames, frames.PWM_LIMIT) for joint in JOINTS}


def section4a(config: Configuration) -> Values:
    """Section IV-A, training images."""
    channels = NetworkSettings().weights["conv1.weight"][1]
    signals, samples = config.signals, config.signals.image_samples
    steps = round(signals.duration_s / signals.sampling_period_s)
    highest_band = (samples - 1) / (2 * signals.sampling_period_s * steps)
    lengths, masses, friction = priors.PUBLISHED_LENGTH, priors.PUBLISHED_MASS, priors.PUBLISHED_FRICTION
    prior = "kept as data.prior: published; the default draws from wider ranges"
    return {
        "section4a/joints": joints(config),
        "section4a/image/rows": image_samples(config),
        "section4a/image/columns": image_samples(config),
        "section4a/image/channels": constant(architecture, channels),
        "section4a/bands": image_samples(config),
        "section4a/band-low": literal(arithmetic(0, "band k = 0")),
        "section4a/band-high": arithmetic(highest_band, f"({samples} - 1) / (2 x 2.5 ms x {steps})"),
        "section4a/sampling-period": sampling_period(config),
        "section4a/length-low": constant(priors, lengths[0], prior),
        "section4a/length-high": constant(priors, lengths[1], prior),
        "section4a/mass-low": constant(priors, masses[0], prior),
        "section4a/mass-high": constant(priors, masses[1], prior),
        "section4a/friction-low": constant(priors, friction[0], prior),
        "section4a/friction-high": constant(priors, friction[1], prior),
        "section4a/steepness": constant(dynamics, dynamics.LAMBDA),
        "section4a/time-low": constant(trajectories, trajectories.identification_trajectory().time[0]),
        "section4a/time-high": setting("signals.duration_s", signals.duration_s / math.pi),
        "section4a/guess-low": setting("data.guess_low", config.data.guess_low),
        "section4a/guess-high": setting("data.guess_high", config.data.guess_high),
    }


def eq08(config: Configuration) -> Values:
    """Eq. 8, samples of the image."""
    return {"eq08/samples": image_samples(config)}


def eq09() -> Values:
    """Eq. 9, the image."""
    return {
        "eq09/torque-factor": literal(constant(dataset, 2)),
        "eq09/offset/alpha": constant(image, image.LOG_OFFSET),
        "eq09/offset/psi": constant(image, image.LOG_OFFSET),
    }


def eq10() -> Values:
    """Eq. 10, the identification trajectory."""
    values = {}
    for joint, harmonic in zip(JOINTS, trajectories.SECOND_HARMONIC, strict=True):
        values[f"eq10/amplitude/joint{joint}"] = constant(trajectories, harmonic.amplitude)
        values[f"eq10/frequency/joint{joint}"] = constant(trajectories, harmonic.frequency)
        values[f"eq10/phase/joint{joint}"] = constant(trajectories, harmonic.phase)
    return values


def section4b(config: Configuration) -> Values:
    """Section IV-B, the network and its training."""
    network, paper = NetworkSettings(), config.training.paper
    weights, outputs = network.weights, network.weights["fc6.weight"][0]
    values = {
        "section4b/input/rows": image_samples(config),
        "section4b/input/columns": image_samples(config),
        "section4b/input/channels": constant(architecture, weights["conv1.weight"][1]),
        "section4b/outputs": constant(architecture, outputs),
        "section4b/output-low": literal(constant(architecture, 0, "sigmoid of Eq. 13")),
        "section4b/output-high": literal(constant(architecture, 1, "sigmoid of Eq. 13")),
        "section4b/biases": constant(architecture, weights["conv1.bias"][0]),
        "section4b/pool": constant(architecture, (network.image_size - network.kernels[0] + 1) / network.pooled[0]),
        "section4b/loss-divisor": constant(architecture, 2 * outputs, "half the mean square"),
        "section4b/loss-terms": constant(architecture, outputs),
        "section4b/iterations": recipe_iterations(config),
    }
    for layer in (1, 2, 3):
        maps, inputs, size, _ = weights[f"conv{layer}.weight"]
        values[f"section4b/kernel{layer}/size"] = constant(architecture, size)
        values[f"section4b/kernel{layer}/inputs"] = constant(architecture, inputs)
        values[f"section4b/kernel{layer}/outputs"] = constant(architecture, maps)
    for name, key, value in (
        ("learning-rate", "learning_rate", paper.learning_rate),
        ("learning-rate-slope", "learning_rate_slope", paper.learning_rate_slope),
        ("gradient-gain", "gradient_gain", paper.gradient_gain),
        ("train-images", "train_share", paper.train_share * paper.images),
        ("test-images", "train_share", -paper.train_share * paper.images + paper.images),
    ):
        values[f"section4b/{name}"] = of_paper_recipe(config, f"training.paper.{key}", value)
    return values


def section4c(config: Configuration) -> Values:
    """Section IV-C, filter, guesses and similarity."""
    signal = np.sin(np.arange(1.0, 100.0))
    self_similarity = float(metr2ev(signal, signal).total)
    return {
        "section4c/sampling-period": sampling_period(config),
        "section4c/filter-coefficient": filter_coefficient(config),
        "section4c/samples": image_samples(config),
        "section4c/guess-low": setting("algorithm1.guess_low", config.algorithm1.guess_low),
        "section4c/guess-high": setting("algorithm1.guess_high", config.algorithm1.guess_high),
        "section4c/identical": arithmetic(100 * self_similarity, "metr2ev of a signal with itself"),
        "section4c/power": setting("metric.exponent", config.metric.exponent),
    }


def algorithm1(config: Configuration) -> Values:
    """Listing of Algorithm 1."""
    return {
        "algorithm1/samples": image_samples(config),
        "algorithm1/guesses": constant(parameters, len(NAMES)),
        "algorithm1/guess-low": setting("algorithm1.guess_low", config.algorithm1.guess_low),
        "algorithm1/guess-high": setting("algorithm1.guess_high", config.algorithm1.guess_high),
        "algorithm1/joint-weight": literal(constant(parameters, 1 / 2, "the mean of both joints")),
    }


def section5(config: Configuration) -> Values:
    """Section V, results."""
    published = sum(motion.published for motion in programs.VALIDATION.values())
    return {
        "section5/validation-trajectories": constant(programs, published, "T1 to T4"),
        "section5/joints": joints(config),
    }


def eq16() -> Values:
    """Eq. 16, colours of an image."""
    red, green, blue = image.COLOUR_WEIGHTS
    return {
        "eq16/red/channel1": constant(image, 3 * red[0]),
        "eq16/red/channel2": constant(image, 3 * red[1]),
        "eq16/green/channel1": constant(image, 3 * green[0]),
        "eq16/blue/channel1": constant(image, 3 * blue[0]),
    }


def section5a(config: Configuration, results: Results) -> Values:
    """Section V-A, the training."""
    share = config.training.paper.train_share
    return {
        "section5a/parameter-sets": recipe_images(config),
        "section5a/loss": held_out_loss(config, results),
        "section5a/iterations": recipe_iterations(config),
        "section5a/train-share": of_paper_recipe(config, "training.paper.train_share", share * 100),
        "section5a/test-share": of_paper_recipe(config, "training.paper.train_share", 100 - share * 100),
    }


def section5b(config: Configuration) -> Values:
    """Section V-B, numeric tests."""
    low, high = trajectories.RANDOM_RANGE
    return {
        "section5b/arms": numeric_arms(config),
        "section5b/random-low": constant(trajectories, low),
        "section5b/random-high": constant(trajectories, high),
    }


def table04(published: Published, config: Configuration, results: Results) -> Values:
    """Parameters of N1 and N2."""
    return {
        **true_parameters("table04", "N1", config.numeric.arms.N1),
        **estimates_of_test_arm("table04", "N1", published, results),
        **true_parameters("table04", "N2", config.numeric.arms.N2),
        **estimates_of_test_arm("table04", "N2", published, results),
    }


def table05(published: Published, config: Configuration, results: Results) -> Values:
    """Parameters of N3 and N4."""
    return {
        **true_parameters("table05", "N3", config.numeric.arms.N3),
        **estimates_of_test_arm("table05", "N3", published, results),
        **true_parameters("table05", "N4", config.numeric.arms.N4),
        **estimates_of_test_arm("table05", "N4", published, results),
    }


def table07(config: Configuration, results: Results) -> Values:
    """Similarities of the numeric tests on the random trajectory."""
    note, values = training_note(config), {}
    for case, quantity, joint in product(NUMERIC_CASES, QUANTITIES, JOINTS):
        for method in ON_PAPERS_ARMS if quantity == "total" else (LISTED,):
            score = results.similarity("table07", case, method.name, joint, quantity)
            values[f"table07/{case}/{quantity}/joint{joint}{method.suffix}"] = on_papers_arms(score, method, note)
    return values


def section5c(config: Configuration, results: Results) -> Values:
    """Section V-C, the experiment."""
    torque = config.board.full_torque_nm
    return {
        "section5c/joints": joints(config),
        "section5c/bridge-voltage": bench(),
        "section5c/power-voltage": bench(),
        "section5c/full-torque/joint1": setting("board.full_torque_nm", torque[0]),
        "section5c/full-count/joint1": constant(frames, frames.PWM_LIMIT),
        "section5c/full-torque/joint2": setting("board.full_torque_nm", torque[1]),
        "section5c/full-count/joint2": constant(frames, frames.PWM_LIMIT),
        **comparisons_in_words(results),
        **validation_ratio("section5c/validation/algorithm1-over-least-squares", results),
    }


def table08(config: Configuration, results: Results) -> Values:
    """Tracking of ID, to which arm and duration are matched, and the controller."""
    board, values = config.board, {"table08/pwm/joint1": setting("board.pwm_hz", config.board.pwm_hz[0] * 1e-3)}
    for joint, kp, kv in zip(JOINTS, board.kp_nm_per_rad, board.kv_nm_per_rad, strict=True):
        tracking = results.similarity("table08", "tracking", "pd", joint)
        tracking = replace(tracking, basis=Basis.CONSTRUCTION, cause="lag of the gains")
        values[f"table08/ID/total/joint{joint}"] = tracking
        values[f"table08/kp/joint{joint}"] = setting("board.kp_nm_per_rad", kp)
        values[f"table08/kv/joint{joint}"] = setting("board.kv_nm_per_rad", kv)
        values[f"table08/cf/joint{joint}"] = filter_coefficient(config)
    return values


def table10(results: Results) -> Values:
    """Similarities of the experiment."""
    values = {}
    for case, quantity, joint in product(("ID", *VALIDATION_CASES), QUANTITIES, JOINTS):
        for method in ON_SIMULATED_ARM if quantity == "total" else (LISTED,):
            score = results.similarity("table10", case, method.name, joint, quantity)
            id_ = f"table10/{case}/algorithm1/{quantity}/joint{joint}{method.suffix}"
            values[id_] = on_simulated_arm(score, method)
        score = results.similarity("table10", case, LEAST_SQUARES.name, joint, quantity)
        values[f"table10/{case}/least-squares/{quantity}/joint{joint}"] = on_simulated_arm(score, LEAST_SQUARES)
    return values


def section6(config: Configuration, results: Results) -> Values:
    """Section VI, discussion."""
    executions = setting("algorithm1.executions", config.algorithm1.executions)
    t1_range = config.experiment.t1.range_rad
    radius = 100 * validation_motions.CIRCLE_RADIUS * sum(config.arm.link_lengths_m)
    window = constant(validation_motions, validation_motions.WINDOW_COEFFICIENT)
    return {
        "section6/parameter-sets": recipe_images(config),
        "section6/image/rows": image_samples(config),
        "section6/image/columns": image_samples(config),
        **mean_numeric_total("section6/numeric/total", config, results),
        "section6/numeric/threshold": setting("algorithm1.threshold", config.algorithm1.threshold * 100),
        "section6/numeric/executions": executions,
        "section6/experimental/threshold": setting("experiment.threshold", config.experiment.threshold * 100),
        "section6/experimental/executions": executions,
        **largest_validation_total("section6/experimental/total", results),
        "section6/T1/range-low": setting("experiment.t1.range_rad", -t1_range),
        "section6/T1/range-high": setting("experiment.t1.range_rad", t1_range),
        "section6/T2/circle": setting("arm.link_lengths_m", radius, "radius, a tenth of the sum"),
        "section6/window/start": window,
        "section6/window/end": window,
    }


def section7(config: Configuration, results: Results) -> Values:
    """Section VII, conclusion."""
    return {
        "section7/joints": joints(config),
        "section7/sampling-period": sampling_period(config),
        **largest_validation_total("section7/experimental/total", results),
    }


def appendix(found: Mapping[str, float], results: Results) -> Values:
    """Appendix A, the stability proof."""
    proof, sine = stability.LyapunovSettings(), found["appendix/sine"]
    return {
        "appendix/rho": constant(stability, proof.rho),
        "appendix/epsilon": constant(stability, proof.epsilon),
        "appendix/gamma": constant(stability, proof.gamma),
        "appendix/domain": arithmetic(sine / math.pi, f"{sine:.3f} / pi"),
        "appendix/potential": of_appendix_arm(results, "Potential energy (Eq. 17)", "value"),
        "appendix/energy": of_appendix_arm(results, "Energy (Eq. 17)", "value"),
        "appendix/dissipation": of_appendix_arm(results, "Dissipation (Eq. 18)", "value"),
        "appendix/coupling": of_appendix_arm(results, "Dissipation (Eq. 18)", "bound"),
        "appendix/r1_min": of_appendix_arm(results, "Rate (Eq. 19)", "value"),
        "appendix/r2_max": of_appendix_arm(results, "Rate (Eq. 19)", "bound"),
    }
