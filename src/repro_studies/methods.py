"""Each method of the study: its estimate, its interval, and the errors of both.

There are three kinds of method, and all use the same simulations: Algorithm 1, whose network has image and guess as
inputs; an amortised posterior, whose network has the torque alone as input; and least squares. Each network is trained
once for an excitation and a prior.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import linalg
from scipy.special import ndtr

from repro.board.frames import RADIANS_PER_COUNT
from repro.cnn.dataset import DataSettings, SampledMotion, UnmodelledColumns, UnmodelledSettings, draw_torques
from repro.cnn.network import save_network
from repro.cnn.priors import ListedPrior
from repro.cnn.train import train
from repro.config.model import Configuration
from repro.config.sections import data_settings
from repro.experiments.arm import Recording
from repro.experiments.identifications import prepare_recording
from repro.experiments.monte_carlo import ArmScores
from repro.experiments.networks import algorithm1_of, for_the_arm
from repro.experiments.simulated_arms import run_loop, sampled_tracks
from repro.files import read_tensors, write_tensors
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.search import ImageMotion, ResidualEstimator, search, select
from repro.identification.least_squares import METHODS
from repro.identification.regression import Regression, correlation_time, mean_variance
from repro.identification.scores import relative_rms
from repro.model.parameters import FEASIBILITY, Array
from repro.progress import Progress, over
from repro.signals.dct import SignalSettings
from repro.streams import Stream, stream
from repro_studies.arms import Effects, choose, excitation_config, prior_stream, read_choice, record, specimens
from repro_studies.design import ALGORITHM1, FLOW, POSTERIOR, RANKS, TRACKED, jobs, trained
from repro_studies.plain import Flow, PlainNetwork, load_posterior, read_torque, save_posterior, train_posterior

#: Networks that are searched with, and the motion of line 18: the measured one as listed, or the one that was sent.
SEARCHED: dict[str, ImageMotion] = {ALGORITHM1: "measured", TRACKED: "desired"}
#: Weight of a white part in the covariance of the torque errors, for those that are not in the training.
SHRINKAGE = 0.1


def _data(config: Configuration, arms: Array, unmodelled: bool) -> DataSettings:
    """Distribution of training samples of listed arms, with the study's torque beyond Eq. 1 or without any."""
    effects = config.study.unmodelled if unmodelled else UnmodelledSettings()
    return replace(data_settings(config), prior=ListedPrior(arms), unmodelled=effects)


def make_arms(choice: Path, training: Sequence[Path], config: Configuration) -> None:
    """Choose motions and arms of the study; for each motion and law simulate the training arms."""
    choose(config, choice)
    for (excitation, law), out in zip(trained(config), training, strict=True):
        _simulate_training(excitation, law, choice, out, config)


def _simulate_training(excitation: str, law: str, choice: Path, out: Path, config: Configuration) -> None:
    """Simulate the training arms of an excitation and a law; write the arrays that the training needs."""
    c, s = excitation_config(config, excitation), config.study
    program, chosen = read_choice(choice, config, excitation)
    signals, n, proper = c.signals, s.training_arms, slice(program.n1, program.n2)
    rng = prior_stream(config, Stream.STUDY_TRAINING_ARMS, law)
    arms = chosen[f"law/{law}"]
    beta = arms[:n]
    effects = Effects.drawn(rng, beta).times(rng.uniform(0.0, 3.0, n))
    recordings = record(c, beta, [program] * n, effects, f"arms to train on, {excitation}, {law}")
    largest = config.data.tracked.largest_error_rad
    tracks = [recording.q for recording in recordings if np.abs(recording.q - program.q)[:, proper].max() <= largest]
    ideal = sampled_tracks([program.q], program, signals)
    tracked = sampled_tracks(tracks, program, signals, unmodelled=True, desired=True)
    # The posterior learns from these samples. Generalised least squares has their error covariance and their prior.
    torque, draws, which = draw_torques(rng, 4000, tracked, _data(config, arms, unmodelled=True))
    error = (torque - np.einsum("njmp,np->njm", tracked.torque[which], draws)).reshape(len(draws), -1)
    error /= np.sqrt(np.mean(error**2, axis=1, keepdims=True))
    covariance = error.T @ error / len(error)
    white = np.eye(len(covariance)) * np.trace(covariance) / len(covariance)
    kept = {f"unmodelled/{name}": array for name, array in vars(tracked.unmodelled).items()}
    kept |= {"arms": arms, "ideal/torque": ideal.torque[0], "ideal/model": ideal.model[0]}
    kept |= {"tracked/torque": tracked.torque, "tracked/model": tracked.model}
    kept |= {"error_covariance": (1.0 - SHRINKAGE) * covariance + SHRINKAGE * white}
    kept |= {"prior_mean": draws.mean(axis=0), "prior_covariance": np.cov(draws.T)}
    write_tensors(out, kept)


def train_reader(
    network: str, excitation: str, law: str, training: Path, weights: Path, checkpoint: str, config: Configuration
) -> None:
    """Train one network: of the posterior, or of Algorithm 1 on the ideal motion or on motions as arms track them."""
    kept, _ = read_tensors(training, "training motions of the study")
    progress, s = Progress(f"training, {network} of {excitation}, {law}"), config.study
    if network == ALGORITHM1:
        motion = SampledMotion(kept["ideal/torque"], kept["ideal/model"])
    else:
        columns = UnmodelledColumns(*(kept[f"unmodelled/{name}"] for name in ("stribeck", "ripple", "rate")))
        motion = SampledMotion(kept["tracked/torque"], kept["tracked/model"], columns)
    data = _data(config, kept["arms"], unmodelled=network != ALGORITHM1)
    posterior = motion, data, s.posterior, s.seed, progress
    if network == FLOW:
        make = partial(Flow, mean=kept["prior_mean"], covariance=kept["prior_covariance"])
        save_posterior(weights, train_posterior(make, *posterior))
    elif network == POSTERIOR:
        save_posterior(weights, train_posterior(PlainNetwork, *posterior))
    else:
        steps, warmup = s.cnn_steps, s.cnn_steps // 10
        settings = replace(config.training, recipe="streamed", seed=s.seed, steps=steps, warmup=warmup)
        trained, _ = train(motion, data, config.network, settings, Path(checkpoint), progress)
        save_network(weights, trained, {})
        Path(checkpoint).unlink(missing_ok=True)


@dataclass(frozen=True)
class MethodEstimate:
    """Estimate of a method from one recording, and its claimed distribution: a covariance, samples, or none."""

    method: str
    beta: Array  # (9,), SI
    covariance: Array | None = None  # (9, 9), of a normal distribution
    samples: Array | None = None  # (n, 9)


class Methods:
    """All methods for one excitation and one prior."""

    def __init__(
        self, training: Path, weights: dict[str, Path], config: Configuration, signals: SignalSettings
    ) -> None:
        kept, _ = read_tensors(training, "training motions of the study")
        self._signals, self._seed = signals, config.study.seed
        self._factor = linalg.cholesky(kept["error_covariance"], lower=True)
        self._prior = kept["prior_mean"], kept["prior_covariance"]
        sizes = signals.image_samples, config.study.posterior.width
        self._plain = load_posterior(weights[POSTERIOR], PlainNetwork(*sizes)) if POSTERIOR in weights else None
        self._flow = load_posterior(weights[FLOW], Flow(*sizes, *self._prior)) if FLOW in weights else None
        chosen = [name for name in SEARCHED if name in weights]
        self._cnn = {name: for_the_arm(algorithm1_of(name, weights[name], config), config) for name in chosen}

    def estimate(self, recording: Recording, searched: bool, rng: np.random.Generator) -> Iterator[MethodEstimate]:
        """Identify one recording by every method, by Algorithm 1 only if `searched`."""
        prepared = prepare_recording(recording, None, self._signals)
        unit = prepared.torque_scale
        yield from _least_squares(prepared.regression)
        yield from self._generalised(prepared)
        if self._plain is not None:
            mean, factor = read_torque(self._plain, prepared.alpha)
            yield MethodEstimate(POSTERIOR, unit * mean, unit**2 * linalg.inv(factor @ factor.T))
        if searched:
            for name in self._cnn:
                yield self._searched(name, prepare_recording(recording, None, self._signals, SEARCHED[name]), rng)
        if self._flow is not None:
            normal = stream(self._seed, Stream.STUDY_FLOW).standard_normal((1000, 9))
            samples = unit * self._flow.sample(prepared.alpha, normal)
            yield MethodEstimate(FLOW, samples.mean(axis=0), samples=samples)

    def judge(self, claim: MethodEstimate, true: Array, unit: float, rng: np.random.Generator) -> dict[str, float]:
        """Compare a claimed distribution with the truth; `unit` is the torque scale of the prior.

        The mean share of the prior's variance that the claim removes; the share of its draws nearer to a random point
        than the truth (TARP, Lemos and others 2023); the probability that it gives to values below each parameter.
        """
        spread, samples = unit * np.sqrt(np.diag(self._prior[1])), claim.samples
        if claim.covariance is not None:
            deviation = np.sqrt(np.diag(claim.covariance))
            below = ndtr((true - claim.beta) / deviation)
            samples = rng.multivariate_normal(claim.beta, claim.covariance, 200, method="cholesky")
        elif samples is not None:
            deviation, below = samples.std(axis=0), (samples < true).mean(axis=0)
        else:
            return dict.fromkeys(("contraction", "nearer", *RANKS), np.nan)
        point = unit * self._prior[0] + spread * rng.standard_normal(9)
        far = np.linalg.norm((samples - point) / spread, axis=1)
        nearer = float((far < np.linalg.norm((true - point) / spread)).mean())
        contraction = float(np.mean(1.0 - (deviation / spread) ** 2))
        return {"contraction": contraction, "nearer": nearer, **dict(zip(RANKS, below.tolist(), strict=True))}

    def _generalised(self, prepared: PreparedSignals) -> Iterator[MethodEstimate]:
        """Least squares weighted by the covariance of the simulated torque errors, without and with the prior."""
        y = linalg.solve_triangular(self._factor, prepared.y_sub.reshape(-1, 9), lower=True)
        tau = linalg.solve_triangular(self._factor, prepared.alpha.reshape(-1), lower=True)
        beta = linalg.lstsq(y, tau)[0]
        variance = float(np.sum((tau - y @ beta) ** 2)) / (len(tau) - len(beta))
        information, unit = y.T @ y / variance, prepared.torque_scale
        yield MethodEstimate("generalised", unit * beta, unit**2 * linalg.inv(information))
        mean, precision = self._prior[0], linalg.inv(self._prior[1])
        covariance = linalg.inv(information + precision)
        beta = covariance @ (y.T @ tau / variance + precision @ mean)
        yield MethodEstimate("generalised+prior", unit * beta, unit**2 * covariance)

    def _searched(self, name: str, prepared: PreparedSignals, rng: np.random.Generator) -> MethodEstimate:
        """Algorithm 1, and the spread of its network's estimates from the first guess of each execution."""
        network, settings = self._cnn[name], self._cnn[name].search
        estimator = ResidualEstimator(network.network, network.image, prepared)
        guesses = rng.uniform(settings.guess_low, settings.guess_high, (settings.executions, 9))
        spread = prepared.torque_scale * estimator.estimate(guesses)
        selected = select(search(estimator, prepared, settings, rng).beta, prepared, settings)
        return MethodEstimate(name, selected.beta, samples=spread)


def _least_squares(regression: Regression) -> Iterator[MethodEstimate]:
    """Methods without simulations; the plain one with the interval of correlated errors."""
    beta = METHODS["ordinary"].estimate(regression).beta
    y, error = regression.y.reshape(-1, 9), regression.tau - regression.y @ beta
    rows = max(2.0 * correlation_time(error, regression.h) / regression.h - 1.0, 1.0)
    covariance = linalg.pinv(y.T @ y) * (rows * mean_variance(regression, beta))
    yield MethodEstimate("ordinary", beta, np.asarray(covariance, dtype=np.float64))
    for name in ("robust", "bounded", "consistent"):
        yield MethodEstimate(name, METHODS[name].estimate(regression).beta)


def run_job(job: str, choice: Path, training: Path, weights: Sequence[Path], config: Configuration) -> pd.DataFrame:
    """Record the arms of a job's cells, and identify each by every method."""
    cells, rows, estimates = jobs(config)[job], [], list[tuple[Recording, Array, bool]]()
    c = excitation_config(config, cells[0].excitation)
    methods = Methods(training, {path.stem: path for path in weights}, config, c.signals)
    arms = specimens(config, cells, choice)
    for k, arm in enumerate(over(arms, f"identifying {len(arms)} runs")):
        rng = prior_stream(config, Stream.STUDY_SEARCH, cells[0].prior, arm.labels["arm"])
        scores = ArmScores(arm.recordings, c)
        unit = prepare_recording(arm.recordings[0], None, c.signals).torque_scale
        searched = cells[k * len(cells) // len(arms)].searched
        true = MethodEstimate("true", arm.true)
        for estimate in (true, *methods.estimate(arm.recordings[0], searched, rng)):
            beta, row = estimate.beta, {**arm.labels, "method": estimate.method}
            row |= scores(beta, c.metric)
            row["torque_error"] = float(np.mean([relative_rms(r, beta) for r in scores.regressions[1:]]))
            row["parameter_error"] = float(np.sqrt(np.mean((beta - arm.true) ** 2))) / unit
            rows.append({**row, **methods.judge(estimate, arm.true, unit, rng)})
            estimates.append((arm.recordings[1], beta, searched))
    return pd.DataFrame(rows).assign(position_error=_position_errors(estimates, config)).round(5)


def _position_errors(estimates: Sequence[tuple[Recording, Array, bool]], config: Configuration) -> Array:
    """RMS difference of T1 as recorded and as Eq. 1 with the estimate moves in the same loop, rad; NaN if it cannot."""
    every, betas, searched = zip(*estimates, strict=True)
    # For time only cells that every method is run in.
    able = FEASIBILITY["positive-definite"](np.stack(betas)) & np.array(searched)
    errors = np.full(len(betas), np.nan)
    if able.any():
        motions = [every[k] for k in np.flatnonzero(able)]
        desired = np.stack([motion.program.q for motion in motions])
        position, _ = run_loop(config, np.stack(betas)[able], desired, "estimates", quick=True)
        apart = position * RADIANS_PER_COUNT - np.stack([motion.q for motion in motions])
        errors[able] = np.sqrt(np.mean(apart**2, axis=(1, 2)))
    return errors
