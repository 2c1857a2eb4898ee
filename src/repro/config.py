"""The configuration: checked against its schema, then turned into settings."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import yaml

from repro.cnn.dataset import DataSettings, SignalSettings
from repro.cnn.image import ImageSettings
from repro.cnn.network import NetworkSettings
from repro.cnn.priors import GuessSettings
from repro.cnn.train import PaperSchedule, TrainingSettings
from repro.errors import InputError
from repro.identify.algorithm1 import SearchSettings
from repro.identify.refinement import RefinementSettings
from repro.model.parameters import Array
from repro.signals.dct import FrequencyReading
from repro.signals.metric import MetricSettings


@dataclass(frozen=True)
class NumericSettings:
    """The numeric experiment of Section V-B.

    Attributes
    ----------
    seeds : tuple of int
        One repetition each; they seed the guesses and the validation trajectory.
    margin : int
        Samples recorded before and after the trajectory, which **cut** removes.
    validation_reading : {"rad_per_s", "hertz", "index"}
        Unit of omega in the filter that makes the validation trajectory.
    arms : dict
        Name of each test arm and its nine parameters.
    """

    seeds: tuple[int, ...]
    margin: int
    validation_reading: FrequencyReading
    arms: dict[str, Array]


@dataclass(frozen=True)
class Settings:
    """Everything a rule needs, from one configuration."""

    signals: SignalSettings
    metric: MetricSettings
    network: NetworkSettings
    data: dict[str, DataSettings]
    training: TrainingSettings
    search: SearchSettings
    refinement: RefinementSettings
    numeric: NumericSettings


def _finite(value: object, place: str) -> None:
    """Refuse NaN and infinity, which YAML can spell and a schema lets through."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            _finite(item, f"{place}.{key}" if place else str(key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            _finite(item, f"{place}[{index}]")
    elif isinstance(value, float) and not np.isfinite(value):
        raise InputError.at(place, value, "a finite number")


def _origin(files: Iterable[Path], path: Iterable[str | int]) -> str:
    """Name of the last configuration file that sets `path`, or the command line."""
    origin = ""
    keys = [k for k in path if isinstance(k, str)]
    for file in files:
        node: object = yaml.safe_load(file.read_text(encoding="utf-8"))
        for key in keys:
            node = node.get(key) if isinstance(node, Mapping) else None
        if node is not None:
            origin = str(file)
    return origin or "configuration"


def _expected(error: jsonschema.ValidationError) -> tuple[str, str, str]:
    """Field, found and expected of a schema violation, in words."""
    field = ".".join(str(p) for p in error.absolute_path)
    rule, limit = str(error.validator), error.validator_value
    if rule == "additionalProperties":
        schema: Mapping[str, Any] = error.schema  # type: ignore[assignment]
        known = [*schema.get("properties", {}), *error.schema.get("required", [])]  # type: ignore[union-attr]
        unknown = [k for k in error.instance if k not in known]  # type: ignore[union-attr]
        field = ".".join([*(str(p) for p in error.absolute_path), str(unknown[0])])
        return field, "an unknown key", f"one of {', '.join(sorted(set(known)))}"
    if rule == "required":
        missing = next(k for k in limit if k not in error.instance)  # type: ignore[union-attr,operator]
        return ".".join(filter(None, [field, str(missing)])), "nothing", "a value"
    words = {
        "type": f"{limit}",
        "enum": f"one of {limit}",
        "const": f"{limit}",
        "minimum": f"at least {limit}",
        "maximum": f"at most {limit}",
        "exclusiveMinimum": f"more than {limit}",
        "exclusiveMaximum": f"less than {limit}",
        "minItems": f"at least {limit} values",
        "maxItems": f"at most {limit} values",
        "uniqueItems": "values that differ",
        "pattern": f"text like {limit}",
    }
    return field or "configuration", repr(error.instance), words.get(rule, f"{rule} {limit}")


def check_config(config: Mapping[str, Any], schema: Path, files: Iterable[Path] = ()) -> None:
    """Check a configuration against its schema.

    Parameters
    ----------
    config : mapping
        Merged configuration.
    schema : Path
        JSON schema in YAML.
    files : iterable of Path
        Configuration files in the order they were merged, to name the one at fault.

    Raises
    ------
    InputError
        At the first violation: file, field, found and expected in one line.
    """
    rules = yaml.safe_load(schema.read_text(encoding="utf-8"))
    violations = list(jsonschema.Draft202012Validator(rules).iter_errors(config))
    if violations:
        error = min(violations, key=lambda e: [str(p) for p in e.absolute_path])
        field, found, expected = _expected(error)
        raise InputError.at(f"{_origin(files, field.split('.'))}: {field}", found, expected)
    try:
        _finite(config, "")
    except InputError as error:
        raise InputError(f"{_origin(files, str(error).split(':')[0].split('.'))}: {error}") from error


def load_settings(config: Mapping[str, Any]) -> Settings:
    """Turn a checked configuration into settings.

    Parameters
    ----------
    config : mapping
        Configuration that `check_config` accepted.

    Returns
    -------
    Settings
        Frozen settings.

    Raises
    ------
    InputError
        If values are each valid but do not go together.
    """
    signals, data, search, numeric = (config[k] for k in ("signals", "data", "algorithm1", "numeric"))
    try:
        guess = GuessSettings(
            data["guess_low"],
            data["guess_high"],
            data["exact_share"],
            data["near_share"],
            data["near_low"],
            data["near_high"],
        )
        metric = MetricSettings(**config["metric"])
        training = {k: v for k, v in config["training"].items() if k != "paper"}
        return Settings(
            signals=SignalSettings(
                signals["sampling_period_s"],
                signals["filter_coefficient"],
                signals["frequency_reading"],
                signals["image_samples"],
                signals["duration_s"],
                signals["normalise_motion"],
            ),
            metric=metric,
            network=NetworkSettings(
                signals["image_samples"],
                hidden=tuple(config["network"]["hidden"]),
                sigmoid_gain=config["network"]["sigmoid_gain"],
            ),
            data={
                name: DataSettings(data["prior"], guess, ImageSettings(**image))
                for name, image in config["images"].items()
            },
            training=TrainingSettings(**training, paper=PaperSchedule(**config["training"]["paper"])),
            search=SearchSettings(
                search["executions"],
                search["inner_limit"],
                search["threshold_numeric"],
                search["guess_low"],
                search["guess_high"],
                search["feasibility"],
                metric,
            ),
            refinement=RefinementSettings(**config["refinement"]),
            numeric=NumericSettings(
                tuple(numeric["seeds"]),
                numeric["margin_samples"],
                numeric["validation_frequency_reading"],
                {name: np.array(beta, dtype=np.float64) for name, beta in numeric["arms"].items()},
            ),
        )
    except ValueError as error:
        raise InputError(f"configuration: {error}") from error
