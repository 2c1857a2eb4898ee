"""The simulated arm from the configuration: what its parameters leave out, and the board that drives it."""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from repro.fpga.board import Board
from repro.fpga.plant import Plant, Unmodelled
from repro.model.parameters import Array
from repro.pipeline.experiment import control_constants, true_parameters
from repro.pipeline.job import Config
from repro.streams import Stream, stream


def disturbance(config: Config, seed: int) -> tuple[Unmodelled, Array]:
    """What Eq. 1 leaves out of one arm."""
    a = config["arm"]
    rng = stream(seed, Stream.PLANT)
    phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    factor = rng.uniform(1.0 - a["variation"], 1.0 + a["variation"], 2)
    levels = Unmodelled(
        stribeck=_scaled(a["stribeck"], factor[0]),
        stribeck_velocity=a["stribeck_velocity_rad_s"],
        ripple=_scaled(a["ripple_nm"], factor[1]),
        ripple_cycles=a["ripple_cycles"],
        dead_band=a["dead_band_counts"],
    )
    return levels, phase


def _scaled(levels: Sequence[float], factor: float) -> tuple[float, float]:
    first, second = levels
    return float(first * factor), float(second * factor)


def board_from_config(config: Config, seed: int | None = None) -> Board:
    """Simulated board with its arm."""
    seed = config["experiment"]["seed"] if seed is None else seed
    beta, h = true_parameters(config), config["signals"]["sampling_period_s"]
    levels, phase = disturbance(config, seed)
    stated = {name: config["arm"][name] for name in ("parameters", "back_emf_nm_s_per_rad")}
    effects = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(levels).items()}
    arm = {**stated, **effects, "ripple_phase": phase.tolist(), "seed": seed}
    return Board(
        lambda: Plant(beta, h, levels, phase),
        control_constants(config).torque_per_count,
        {"board": "simulated", "arm": arm},
    )
