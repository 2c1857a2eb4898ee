"""Design of the factorial on the simulated arm: factors and cells, blocks, and methods without a network.

Factors, each with two levels: the motion that f of the image is taken on (line 18), the motions a network is trained
on, the unit of omega in the filter, the motors' back-EMF, the time factor of the metric (in search and scores), and
the reader (the image CNN with Algorithm 1, or a plain network that reads the torque). Blocks are specimens of the arm.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.config import merged
from repro.errors import InputError
from repro.files import read_tensors, write_tensors
from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.identification.algorithm1.search import ImageMotion
from repro.identification.least_squares import METHODS
from repro.model.parameters import Array
from repro.pipeline.experiment import control_constants, program_from_config
from repro.pipeline.job import Config
from repro.pipeline.recordings import Recording
from repro.pipeline.specimen import disturbance
from repro.progress import Progress
from repro.settings import signal_settings
from repro.signals.metric import TIME_FORMULAS, MetricSettings, TorqueScorer
from repro.signals.programs import PROGRAMS

#: Name of the block that no effect is estimated from: an arm and a specimen frozen before, scored once.
CONFIRMATION = "confirmation"


@dataclass(frozen=True)
class Cell:
    """What one network of the factorial is trained for."""

    reader: str  # "cnn" or "plain"
    motions: str  # "ideal": Eq. 10; "tracked": closed-loop motions
    omega: str  # unit of omega
    image_motions: tuple[ImageMotion, ...]  # motions of line 18 that it is used with; of a plain network none

    def change(self, seed: int, noise: float) -> dict[str, Any]:
        """Sections of the configuration that differ from the default."""
        data: dict[str, Any] = {"motions": self.motions}
        if self.reader == "plain":
            data["unmodelled"] = {"noise": noise}
        changed = {"signals": {"frequency_reading": self.omega}, "data": data, "training": {"seed": seed}}
        return (
            changed
            if len(self.image_motions) != 1
            else changed | {"algorithm1": {"image_motion": self.image_motions[0]}}
        )


def _cells() -> dict[str, Cell]:
    """Networks by name. One trained on Eq. 10 alone serves both motions of line 18, which are equal there."""
    both: tuple[ImageMotion, ...] = ("measured", "desired")
    found = {}
    for omega in ("rad_per_s", "index"):
        found[f"cnn-ideal-{omega}"] = Cell("cnn", "ideal", omega, both)
        for one in both:
            found[f"cnn-tracked-{one}-{omega}"] = Cell("cnn", "tracked", omega, (one,))
        for motions in ("ideal", "tracked"):
            found[f"plain-{motions}-{omega}"] = Cell("plain", motions, omega, ())
    return found


CELLS = _cells()


def configured(config: Config, cell: Cell, seed: int) -> dict[str, Any]:
    """Configuration that a network of the factorial is trained with."""
    return merged(config, cell.change(seed, config["factorial"]["plain"]["noise"]))


@dataclass(frozen=True)
class Block:
    """One specimen with one back-EMF."""

    name: str
    arm: str
    back_emf: float
    true: Array
    recordings: dict[str, Recording]


def _specimens(config: Config) -> Iterator[tuple[str, str, int, Array]]:
    """Block, arm, specimen and parameters without back-EMF; the blocks take the arms in turn."""
    f = config["factorial"]
    arms = {"first": config["arm"]["parameters"], "second": f["second_arm"]}
    for k, seed in enumerate(f["specimens"]):
        arm = list(arms)[k % len(arms)]
        yield str(seed), arm, seed, np.array(arms[arm], dtype=np.float64)
    yield CONFIRMATION, CONFIRMATION, f["confirmation_specimen"], np.array(f["confirmation_arm"], dtype=np.float64)


def simulate_blocks(config: Config, out: Path) -> None:
    """Simulate every block with both back-EMFs on all motions, as one batch."""
    control, h = control_constants(config), config["signals"]["sampling_period_s"]
    beta, levels, phases, desired = [], [], [], []
    for name in PROGRAMS:
        for _, _, seed, parameters in _specimens(config):
            effects, phase = disturbance(config, seed)
            for back_emf in config["factorial"]["back_emf_nm_s_per_rad"]:
                beta.append(parameters + back_emf * np.isin(np.arange(9), (5, 6)))
                levels.append(effects)
                phases.append(phase)
                desired.append(program_from_config(config, name, seed).q)
    longest = max(q.shape[-1] for q in desired)
    held = np.stack([np.pad(q, ((0, 0), (0, longest - q.shape[-1])), mode="edge") for q in desired])
    plant = Plant(np.stack(beta), h, levels, np.stack(phases))
    position, pwm = simulate(plant, control, held, Progress(f"simulating {len(beta)} runs"))
    kept: dict[str, NDArray[Any]] = {"parameters": np.stack(beta)[: len(beta) // len(PROGRAMS)]}
    for k, name in enumerate(PROGRAMS):
        own = slice(k * len(kept["parameters"]), (k + 1) * len(kept["parameters"]))
        n = desired[own.start].shape[-1]
        kept |= {f"{name}/position": position[own, :, :n], f"{name}/pwm": pwm[own, :, :n]}
    write_tensors(out, kept)


def read_blocks(path: Path, config: Config) -> list[Block]:
    """Recordings of every block."""
    kept, _ = read_tensors(path, "the recordings of the factorial")
    torque = control_constants(config).torque_per_count[:, np.newaxis]
    specimens, back_emfs = list(_specimens(config)), config["factorial"]["back_emf_nm_s_per_rad"]
    blocks = []
    for k, (name, arm, seed, _) in enumerate(specimens):
        programs = {motion: program_from_config(config, motion, seed) for motion in PROGRAMS}
        for j, back_emf in enumerate(back_emfs):
            index = k * len(back_emfs) + j
            recordings = {}
            for motion, program in programs.items():
                expected = (len(specimens) * len(back_emfs), *program.q.shape)
                signals = [kept.get(f"{motion}/{what}", np.empty(0)) for what in ("position", "pwm")]
                if any(signal.shape != expected for signal in signals):
                    raise InputError.at(f"{path}: {motion}", "another shape or nothing", f"arrays of shape {expected}")
                position, pwm = (signal[index] for signal in signals)
                sent = replace(program, q=program.q.astype(np.float32).astype(np.float64))
                recordings[motion] = Recording(sent, position * RADIANS_PER_COUNT, pwm * torque)
            blocks.append(Block(name, arm, back_emf, kept["parameters"][index], recordings))
    return blocks


METRICS: dict[str, MetricSettings] = {formula: MetricSettings(formula) for formula in TIME_FORMULAS}
COLUMNS = (
    "reader", "image_motion", "training", "omega", "back_emf", "metric", "block", "arm", "training_seed",
    "search_seed", "id", "validation", "error", "met",
)  # fmt: skip


@dataclass(frozen=True)
class Scorers:
    """Similarity of parameters on the motions of one block under both metrics."""

    by_metric: Mapping[str, Sequence[TorqueScorer]]  # ID first

    @classmethod
    def of(cls, block: Block, config: Config) -> "Scorers":
        """From the recordings of a block."""
        signals = signal_settings(config)
        regressions = [recording.regression(signals) for recording in block.recordings.values()]
        return cls({name: [TorqueScorer(r.tau, r.y, m) for r in regressions] for name, m in METRICS.items()})

    def row(self, metric: str, beta: Array) -> dict[str, float]:
        """Mean total of both joints on ID, and over T1 to T4."""
        totals = [float(score(beta).total.mean()) for score in self.by_metric[metric]]
        return {"id": totals[0], "validation": float(np.mean(totals[1:]))}


#: Methods without a network that every block is identified by, too.
REFERENCES = ("ordinary", "bounded")


def score_references(recordings: Path, config: Config) -> pd.DataFrame:
    """Least squares, bounded least squares and the true parameters on every block, for both units of omega."""
    rows = []
    for omega in dict.fromkeys(cell.omega for cell in CELLS.values()):
        c = merged(config, {"signals": {"frequency_reading": omega}})
        for block in read_blocks(recordings, c):
            scorers = Scorers.of(block, c)
            regression = block.recordings["ID"].regression(signal_settings(c))
            estimates = {name: METHODS[name].estimate(regression).beta for name in REFERENCES} | {"true": block.true}
            for reader, beta in estimates.items():
                for metric in METRICS:
                    rows.append(
                        {
                            "reader": reader, "omega": omega, "back_emf": block.back_emf, "metric": metric,
                            "block": block.name, "arm": block.arm, **scorers.row(metric, beta),
                        }
                    )  # fmt: skip
    return pd.DataFrame(rows)
