"""The whole experiment over many specimens of the arm: their recordings; `repro.pipeline.verdict` draws from them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load_file, save_file

from repro.errors import InputError
from repro.files import write_whole
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.loop import simulate
from repro.fpga.plant import Plant
from repro.pipeline.experiment import control_constants, program_from_config, true_parameters
from repro.pipeline.named import Config
from repro.pipeline.recordings import Recording
from repro.pipeline.specimen import disturbance
from repro.progress import Progress
from repro.signals.programs import PROGRAMS, Program

#: Motions that only validate.
VALIDATION = PROGRAMS[1:]


def programs(config: Config, seed: int, duration: float) -> dict[str, Program]:
    """The five motions of one seed and one identification duration."""
    found: dict[str, Program] = {"ID": program_from_config(config, "ID", duration=duration)}
    return found | {name: program_from_config(config, name, seed) for name in VALIDATION}


def simulate_spread(config: Config, out: Path) -> None:
    """Simulate every seed and motion as batches and keep the counts.

    Parameters
    ----------
    config : mapping
        Sections ``signals``, ``arm``, ``board``, ``experiment`` and ``spread``.
    out : Path
        safetensors file, arrays of shape (seeds, 2, N) named ``{motion}/position`` and ``{motion}/pwm`` (int16), and
        ``{motion}/desired`` as sent (float32); the identification motions are named ``ID0``, ``ID1`` ... after the
        durations.
    """
    seeds, durations = config["spread"]["seeds"], config["spread"]["durations_s"]
    kept: dict[str, np.ndarray[Any, np.dtype[Any]]] = {}
    desired = {
        f"ID{k}": [program_from_config(config, "ID", duration=d).q] * len(seeds) for k, d in enumerate(durations)
    }
    desired |= {name: [program_from_config(config, name, seed).q for seed in seeds] for name in VALIDATION}
    beta, control, h = true_parameters(config), control_constants(config), config["signals"]["sampling_period_s"]
    levels, phase = zip(*(disturbance(config, seed) for seed in seeds), strict=True)
    for name, q in desired.items():
        plant = Plant(np.tile(beta, (len(seeds), 1)), h, levels, np.stack(phase))
        position, pwm = simulate(plant, control, np.stack(q), Progress(f"simulating {name}, {len(seeds)} seeds"))
        kept |= {f"{name}/position": position.copy(), f"{name}/pwm": pwm.copy()}
        kept[f"{name}/desired"] = np.stack(q).astype(np.float32)
    write_whole(out, lambda temporary: save_file(kept, temporary))


def read_spread(path: Path, config: Config, index: int) -> list[tuple[int, dict[str, Recording]]]:
    """Recordings of every seed for one identification duration.

    Parameters
    ----------
    path : Path
        File of `simulate_spread`.
    config : mapping
        The configuration it was made with.
    index : int
        Which of the durations.

    Returns
    -------
    list of (seed, dict)
        Seed and its recordings by motion, ID first.

    Raises
    ------
    InputError
        If the file is missing, damaged or of another configuration.
    """
    seeds, duration = config["spread"]["seeds"], config["spread"]["durations_s"][index]
    try:
        kept = load_file(path)
    except (OSError, SafetensorError) as error:
        raise InputError.at(str(path), f"no safetensors file ({error})", "the recordings of the spread") from error
    torque = control_constants(config).torque_per_count[:, np.newaxis]
    found = []
    for k, seed in enumerate(seeds):
        recordings = {}
        for name, program in programs(config, seed, duration).items():
            key = f"ID{index}" if name == "ID" else name
            expected = (len(seeds), *program.q.shape)
            signals = [kept.get(f"{key}/{signal}") for signal in ("position", "pwm", "desired")]
            shaped = [signal[k] for signal in signals if signal is not None and signal.shape == expected]
            if len(shaped) != len(signals):
                raise InputError.at(f"{path}: {key}", "another shape", f"arrays of shape {expected}")
            position, pwm, desired = shaped
            sent = replace(program, q=desired.astype(np.float64))
            recordings[name] = Recording(sent, position * RADIANS_PER_COUNT, pwm * torque)
        found.append((seed, recordings))
    return found
