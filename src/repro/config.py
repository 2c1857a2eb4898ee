"""The configuration file, checked against its schema: one line for whatever is wrong."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from repro.documents import read_yaml
from repro.errors import InputError
from repro.fpga.frames import PWM_LIMIT, SAMPLING_PERIOD
from repro.model.parameters import is_positive_definite
from repro.schema import Place, spelled, violation
from repro.signals.programs import MEMORY_SAMPLES

_ABSENT = object()

#: What a file should be, for messages.
CONFIGURATION = "a configuration file"

#: Folders of the project that no run may write to; those that begin with a point belong to tools.
_OWN = {"benchmarks", "build", "config", "data", "docs", "envs", "profiles", "src", "tests", "workflow"}
#: Nearest that the circle of T2 comes to joint 1, over the arm's reach.
NEAREST = 0.7
#: Largest number that the board's memory holds.
LARGEST = float(np.finfo(np.float32).max)


def _at(node: Any, place: Place) -> object:  # noqa: ANN401
    """Value at a place of a nested configuration, or `_ABSENT`."""
    try:
        for key in place:
            node = node[key]
    except (KeyError, IndexError, TypeError):
        return _ABSENT
    return node


def _odd_keys(node: object, place: Place = ()) -> Iterator[tuple[Place, object]]:
    """Keys that are not text, which YAML can spell and a schema cannot match."""
    if isinstance(node, Mapping):
        for key, item in node.items():
            if not isinstance(key, str):
                yield place, key
            else:
                yield from _odd_keys(item, (*place, key))


class _Sources:
    """Which configuration file a value came from."""

    def __init__(self, config: Mapping[str, Any], files: Iterable[Path]) -> None:
        self._config = config
        self._files = [(str(file), read_yaml(Path(file), CONFIGURATION)) for file in files]

    def hold(self, place: Place) -> bool:
        """Whether there is a value."""
        return _at(self._config, place) is not _ABSENT

    def rank(self, place: Place) -> int:
        """Position of the last file that holds the merged value there; their number if none does."""
        value = _at(self._config, place)
        # By their text, because NaN does not equal itself.
        holding = [k for k, (_, content) in enumerate(self._files) if repr(_at(content, place)) == repr(value)]
        return holding[-1] if holding else len(self._files)

    def name(self, place: Place) -> str:
        """Name of that file; the first one for a value that is missing."""
        if not self.hold(place) and self._files:
            return self._files[0][0]
        rank = self.rank(place)
        return self._files[rank][0] if rank < len(self._files) else "command line"


def merged(base: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """A configuration changed by another one, as Snakemake merges them: sections are merged, lists replaced."""
    changed = dict(base)
    for key, value in overlay.items():
        both = isinstance(value, Mapping) and isinstance(base.get(key), Mapping)
        changed[key] = merged(base[key], value) if both else value
    return changed


def _contradictions(config: Mapping[str, Any]) -> Iterator[tuple[Sequence[Place], str]]:
    """Values that do not go together, and what would."""
    for low, high in (
        (("data", "guess_low"), ("data", "guess_high")),
        (("data", "near_low"), ("data", "near_high")),
        (("algorithm1", "guess_low"), ("algorithm1", "guess_high")),
    ):
        a, b = config[low[0]][low[1]], config[high[0]][high[1]]
        if not a < b:
            yield (low, high), f"{spelled(low)} ({a}) below {spelled(high)} ({b})"
    data, signals, paper = config["data"], config["signals"], config["training"]["paper"]
    if data["exact_share"] + data["near_share"] > 1:
        yield (("data", "exact_share"), ("data", "near_share")), "two shares that add up to 1 at most"
    if round(signals["duration_s"] / signals["sampling_period_s"]) <= signals["image_samples"]:
        expected = f"a run of more than image_samples ({signals['image_samples']}) sampling periods"
        yield (("signals", "duration_s"), ("signals", "sampling_period_s")), expected
    yield from _folder_contradictions(config)
    yield from _experiment_contradictions(config)
    if not 1 <= round(paper["train_share"] * paper["images"]) < paper["images"]:
        places = (("training", "paper", "images"), ("training", "paper", "train_share"))
        yield places, "at least one image to train with and one to test with"


#: Characters of a folder's path.
_LONGEST_FOLDER = 200


def _folder_contradictions(config: Mapping[str, Any]) -> Iterator[tuple[Sequence[Place], str]]:
    """Folders that a run would spoil."""
    for key, usual in (("results", "results/mine"), ("figures", "paper_figures/mine")):
        top = config[key].split("/")[0]
        if len(config[key]) > _LONGEST_FOLDER:
            yield ((key,),), f"at most {_LONGEST_FOLDER} characters"
        elif top.startswith(".") or top.lower() in _OWN or Path(top).is_file():
            yield ((key,),), f"a folder that holds nothing of the project, such as {usual}"
    if config["results"] == config["figures"]:
        yield (("results",), ("figures",)), "two folders"


def _experiment_contradictions(config: Mapping[str, Any]) -> Iterator[tuple[Sequence[Place], str]]:
    """What the board cannot play, and an arm that cannot be."""
    signals, experiment = config["signals"], config["experiment"]
    h = signals["sampling_period_s"]
    if h != SAMPLING_PERIOD:
        yield (("signals", "sampling_period_s"),), f"{SAMPLING_PERIOD} s, the board's clock"
    edges = round(experiment["lead_in_s"] / h) + 2 * experiment["margin_samples"]
    durations: list[tuple[Place, float]] = [(("signals", "duration_s"), signals["duration_s"])]
    durations += [(("spread", "durations_s", k), d) for k, d in enumerate(config["spread"]["durations_s"])]
    for place, duration in durations:
        if round(duration / h) + edges > MEMORY_SAMPLES:
            longest = (MEMORY_SAMPLES - edges) * h
            others = (("experiment", "lead_in_s"), ("experiment", "margin_samples"))
            expected = f"a motion that the board's memory holds, {longest:g} s with this lead-in and margin"
            yield (place, *others), expected
        elif round(duration / h) <= signals["image_samples"]:
            yield (place,), f"a run of more than image_samples ({signals['image_samples']}) sampling periods"
    levels, arms = config["coverage"]["levels"], config["coverage"]["arms"]
    if sorted(set(levels)) != levels or levels[-1] > arms / (arms + 1):
        expected = f"rising shares that {arms} arms can calibrate, {arms / (arms + 1):.4g} at most"
        yield (("coverage", "levels"), ("coverage", "arms")), expected
    spread = config["spread"]
    if len(spread["seeds"]) % spread["arms"]:
        yield (("spread", "arms"), ("spread", "seeds")), "as many specimens of every arm"
    if round(experiment["lead_in_s"] / h) < 1:
        yield (("experiment", "lead_in_s"),), f"at least one sampling period ({h} s)"
    first, second = config["arm"]["link_lengths_m"]
    if abs(first - second) > NEAREST * (first + second):
        yield (("arm", "link_lengths_m"),), "links of which the shorter one reaches the circle of T2"
    board = config["board"]
    for gain in ("kp_nm_per_rad", "kv_nm_per_rad"):
        if max(g * PWM_LIMIT / t for g, t in zip(board[gain], board["full_torque_nm"], strict=True)) > LARGEST:
            yield (("board", gain),), "gains that single precision holds"
    if max(board["pwm_hz"]) > LARGEST:
        yield (("board", "pwm_hz"),), "frequencies that single precision holds"
    if not is_positive_definite(np.array(config["arm"]["parameters"], dtype=np.float64)):
        yield (("arm", "parameters"),), "an inertia matrix that is positive definite in every pose"


def check_config(config: Mapping[str, Any], schema: Path, files: Iterable[Path] = ()) -> None:
    """Check a configuration against its schema, and its values against each other."""
    sources = _Sources(config, files)
    for place, key in _odd_keys(config):
        raise InputError.at(f"{sources.name(place)}: {spelled(place) or 'configuration'}", f"the key {key!r}", "text")
    # libyaml, where PyYAML was built with it, reads this ten times as fast.
    rules = yaml.load(schema.read_text(encoding="utf-8"), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    _check(config, rules, sources)
    if not config["refinement"]["passes"]:
        place = ("refinement", "passes")
        raise InputError.at(f"{sources.name(place)}: {spelled(place)}", 0, "at least 1; 0 is for section networks")
    for name, changes in config["networks"].items():
        _check(merged(config, changes), rules, sources, ("networks", name))


def _check(config: Mapping[str, Any], schema: Mapping[str, Any], sources: _Sources, network: Place = ()) -> None:
    """Raise an `InputError` at the first violation; `network` leads to the changes of a network in `config`."""
    if wrong := violation(config, schema):
        place, found, expected = wrong
        place = (*network, *place)
        raise InputError.at(f"{sources.name(place)}: {spelled(place)}", found, expected)
    for places, expected in _contradictions(config):
        own = [(*network, *place) for place in places if sources.hold((*network, *place))]
        place = max(own, key=sources.rank)  # the one that was set last
        raise InputError.at(f"{sources.name(place)}: {spelled(place)}", _at(config, place[len(network) :]), expected)
