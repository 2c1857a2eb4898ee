"""Check a configuration: its values against `repro.config.model`, and against each other."""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from pydantic import ValidationError

from repro.board.frames import PWM_LIMIT, SAMPLING_PERIOD
from repro.config.model import Configuration
from repro.documents import Place, first_error, read_yaml, spelled
from repro.errors import InputError
from repro.model.parameters import is_positive_definite
from repro.signals.programs import MEMORY_SAMPLES
from repro.signals.validation_motions import CIRCLE_RADIUS

_ABSENT = object()

#: What a file should be, for messages.
CONFIGURATION = "a configuration file"

#: Folders of the project that no run may write to; those that begin with a point belong to tools.
_OWN = {"benchmarks", "build", "config", "data", "docs", "envs", "profiles", "src", "tests", "workflow"}
#: Largest number that the board's memory holds.
LARGEST = float(np.finfo(np.float32).max)


def merged(base: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """A configuration changed by another one, as Snakemake merges them: sections are merged, lists replaced."""
    changed = dict(base)
    for key, value in overlay.items():
        both = isinstance(value, Mapping) and isinstance(base.get(key), Mapping)
        changed[key] = merged(base[key], value) if both else value
    return changed


def _at(node: Any, place: Place) -> object:  # noqa: ANN401
    """Value at a place of a nested configuration, or `_ABSENT`."""
    try:
        for key in place:
            node = node[key]
    except (KeyError, IndexError, TypeError):
        return _ABSENT
    return node


def _contradictions(config: Configuration) -> Iterator[tuple[str, str]]:
    """Find values that contradict each other: their places, the one to name first, and what is expected."""
    data, signals, paper = config.data, config.signals, config.training.paper
    constants = config.algorithm1
    for place, low, high in (
        ("data.guess", data.guess_low, data.guess_high),
        ("data.near", data.near_low, data.near_high),
        ("algorithm1.guess", constants.guess_low, constants.guess_high),
    ):
        if not low < high:
            yield f"{place}_low {place}_high", f"{place}_low ({low}) below {place}_high ({high})"
    if data.exact_share + data.near_share > 1:
        yield "data.exact_share data.near_share", "two shares that add up to 1 at most"
    if round(signals.duration_s / signals.sampling_period_s) <= signals.image_samples:
        expected = f"a run of more than image_samples ({signals.image_samples}) sampling periods"
        yield "signals.duration_s signals.sampling_period_s", expected
    if config.accepted.further_guesses[0] <= config.accepted.guesses[-1]:
        yield "accepted.further_guesses accepted.guesses", "more guesses than the largest of `guesses`"
    yield from _folder_contradictions(config)
    yield from _experiment_contradictions(config)
    if not 1 <= round(paper.train_share * paper.images) < paper.images:
        yield (
            "training.paper.images training.paper.train_share",
            "at least one image to train with and one to test with",
        )


def _folder_contradictions(config: Configuration) -> Iterator[tuple[str, str]]:
    """Refuse folders that a run would spoil."""
    folders = {"results": Path(config.results), "figures": Path(config.figures)}
    for (key, folder), usual in zip(folders.items(), ("results/mine", "paper_figures/mine"), strict=True):
        top = folder.parts[0]
        if top.startswith(".") or top.lower() in _OWN or Path(top).is_file():
            yield key, f"a folder that holds nothing of the project, such as {usual}"
    if folders["results"] == folders["figures"]:
        yield "results figures", "two folders"
    made = folders["results"]  # a job's outputs are deleted before it reads
    for key, stored, own in (
        ("experiment.captures", config.experiment.captures, made / "experiment"),
        ("training.networks", config.training.networks, made / "model"),
    ):
        if Path(stored) == own:
            yield f"{key} results", "a folder that the run does not write to"


def _experiment_contradictions(config: Configuration) -> Iterator[tuple[str, str]]:
    """Find motions that the board cannot run and an arm that cannot be built."""
    signals, experiment, arm, board = config.signals, config.experiment, config.arm, config.board
    h = signals.sampling_period_s
    if h != SAMPLING_PERIOD:
        yield "signals.sampling_period_s", f"{SAMPLING_PERIOD} s, the board's clock"
    lead_in, edges_at = round(experiment.lead_in_s / h), "experiment.lead_in_s experiment.margin_samples"
    edges = lead_in + 2 * experiment.margin_samples
    if not 1 <= lead_in <= edges < MEMORY_SAMPLES:
        expected = f"at least one sampling period ({h} s) of lead-in, with both margins below {MEMORY_SAMPLES * h:g} s"
        yield edges_at, expected
    for place, duration in (
        ("signals.duration_s", signals.duration_s),
        ("experiment.duration_s", experiment.duration_s),
    ):
        if round(duration / h) + edges > MEMORY_SAMPLES:
            longest = f"{(MEMORY_SAMPLES - edges) * h:g} s with this lead-in and margin"
            yield f"{place} {edges_at}", f"a motion that the board's memory holds, {longest}"
        elif round(duration / h) <= signals.image_samples:
            yield place, f"a run of more than image_samples ({signals.image_samples}) sampling periods"
    levels, arms = config.coverage.levels, config.coverage.arms
    if sorted(set(levels)) != levels or levels[-1] > arms / (arms + 1):
        expected = f"rising shares that {arms} arms can calibrate, {arms / (arms + 1):.4g} at most"
        yield "coverage.levels coverage.arms", expected
    first, second = arm.link_lengths_m
    if abs(first - second) > (experiment.t2.centre - CIRCLE_RADIUS) * (first + second):
        yield "arm.link_lengths_m", "links of which the shorter one reaches the circle of T2"
    for name, gains in (("kp_nm_per_rad", board.kp_nm_per_rad), ("kv_nm_per_rad", board.kv_nm_per_rad)):
        if max(g * PWM_LIMIT / t for g, t in zip(gains, board.full_torque_nm, strict=True)) > LARGEST:
            yield f"board.{name}", "gains that single precision holds"
    if not is_positive_definite(np.array(arm.parameters, dtype=np.float64)):
        yield "arm.parameters", "an inertia matrix that is positive definite in every pose"


def capture_files(config: Configuration, motion: str) -> list[str]:
    """Files that a stored capture is read from; a simulated or real board needs none."""
    stored = config.experiment.source == "stored"
    return [f"{config.experiment.captures}/{motion}.{end}" for end in ("bin", "program", "json") if stored]


def _missing_inputs(config: Configuration, motions: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Find a folder of stored networks without them, and one of captures without those of these motions."""
    for file in (file for motion in motions for file in capture_files(config, motion)):
        if not Path(file).is_file():
            yield "experiment.captures experiment.source", f"a folder with the stored captures ({Path(file).name})"
    training = config.training
    if training.source == "stored" and not (Path(training.networks) / "cnn.safetensors").is_file():
        yield "training.networks training.source", "a folder with the stored networks (cnn.safetensors)"


def check_config(
    config: Mapping[str, Any], files: Iterable[Path] = (), inputs: bool = False, motions: Iterable[str] = ()
) -> Configuration:
    """Check a configuration, merged from these files, and that of each of its networks.

    With `inputs`, the files that it names must be there, too, and of the captures those of `motions`: a run that only
    trains needs none.
    """
    motions = tuple(motions)
    contents = {str(file): read_yaml(Path(file), CONFIGURATION) for file in files}

    def file_of(place: Place) -> str:
        """Name of the last file that contains the value at a place; the first one for a value that is missing."""
        if place and isinstance(place[-1], int):
            place = place[:-1]  # the list, which may be too short
        value = repr(_at(config, place))  # as text, because NaN does not equal itself
        if value == repr(_ABSENT) and contents:
            return next(iter(contents))
        return next((name for name in reversed(contents) if repr(_at(contents[name], place)) == value), "command line")

    def refuse(place: Place, found: object, expected: str) -> NoReturn:
        raise InputError.at(f"{file_of(place)}: {spelled(place) or 'configuration'}", found, expected)

    def valid(content: Mapping[str, Any], within: Place = ()) -> Configuration:
        try:
            return Configuration.model_validate(content)
        except ValidationError as invalid:
            place, found, expected = first_error(invalid, Configuration)
            refuse((*within, *place), found, expected)

    checked = valid(config)
    if not checked.refinement.passes:
        refuse(("refinement", "passes"), 0, "at least 1; 0 is for section networks")
    for name, changes in config["networks"].items():
        if "tracked" in changes.get("data", {}):
            refuse(("networks", name, "data", "tracked"), "a key", "none, because all networks share these arms")
    networks = {("networks", name): merged(config, changes) for name, changes in config["networks"].items()}
    for network, content in ({(): config} | networks).items():
        whole = valid(content, network)
        for places, expected in chain(_contradictions(whole), _missing_inputs(whole, motions) if inputs else ()):
            named = [tuple(int(key) if key.isdigit() else key for key in each.split(".")) for each in places.split()]
            own = [place for place in named if _at(config, (*network, *place)) is not _ABSENT]
            names = ["command line", *reversed(contents)]
            place = min(own, key=lambda place: names.index(file_of((*network, *place))))  # the one that was set last
            refuse((*network, *place), _at(content, place), expected)
    return checked


def read_config(path: Path, *overlays: Path) -> dict[str, Any]:
    """Read a configuration as it stands in its files."""
    config: dict[str, Any] = {}
    for file in (path, *overlays):
        config = merged(config, read_yaml(file, CONFIGURATION))
    return config


def load_config(path: Path, *overlays: Path, inputs: bool = False, motions: Iterable[str] = ()) -> Configuration:
    """Read and check a configuration outside the workflow."""
    return check_config(read_config(path, *overlays), [path, *overlays], inputs, motions)


def accept_config(
    config: Mapping[str, Any],
    files: Iterable[str | Path],
    motions: Iterable[str] = (),
    further: Callable[[Configuration], None] | None = None,
) -> Configuration:
    """Check the configuration of a run, `further` last; on a fault print its one line and leave with exit code 2."""
    try:
        if any(map(str.isspace, sys.executable)):
            raise InputError.at(sys.executable, "a blank in the path of Python", "none: a shell starts the jobs")
        checked = check_config(config, [Path(file) for file in files], True, motions)
        if further:
            further(checked)
    except InputError as error:
        print(error, file=sys.stderr)
        raise SystemExit(2) from None
    return checked
