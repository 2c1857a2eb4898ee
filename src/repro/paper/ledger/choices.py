"""Our side of what the authors chose and a configuration holds: gains, ranges, budgets, thresholds, test arms."""

import math
from collections.abc import Mapping
from typing import Any

from repro.comparison.classes import LEDGER
from repro.model.parameters import NAMES
from repro.paper.claims import Ours
from repro.signals.validation_motions import CIRCLE_RADIUS

Config = Mapping[str, Any]

FILE = "config/config.yaml"
_PAPER_RECIPE = "of target paper_recipe; the default network is trained by the streamed recipe"


def chosen(value: float, key: str, note: str = "", unused: bool = False) -> Ours:
    """Compare a number of the configuration, with its key."""
    place = f"{FILE}: {key}"
    return Ours(float(value), LEDGER, strict=True, unused=unused, note=f"{place}, {note}" if note else place)


def choices(config: Config) -> dict[str, Ours]:
    """Published settings that are keys of the configuration, or follow from them."""
    return {**_arms(config), **_signals(config), **_training(config), **_search(config), **_experiment(config)}


def _arms(config: Config) -> dict[str, Ours]:
    arms = config["numeric"]["arms"]
    found = {
        f"{'table04' if case in ('N1', 'N2') else 'table05'}/{case}/true/{name}": chosen(beta, f"numeric.arms.{case}")
        for case, values in arms.items()
        for name, beta in zip(NAMES, values, strict=True)
    }
    count = chosen(len(arms), "numeric.arms")
    return {**found, "abstract/numeric-arms": count, "section5b/arms": count}


def _signals(config: Config) -> dict[str, Ours]:
    s = config["signals"]
    period = chosen(1e3 * s["sampling_period_s"], "signals.sampling_period_s")
    samples = chosen(s["image_samples"], "signals.image_samples")
    c_f = chosen(s["filter_coefficient"], "signals.filter_coefficient")
    sizes = (
        "section4a/image/rows", "section4a/image/columns", "section4a/bands", "eq08/samples", "section4b/input/rows",
        "section4b/input/columns", "section4c/samples", "algorithm1/samples", "section6/image/rows",
        "section6/image/columns",
    )  # fmt: skip
    return {
        **dict.fromkeys(sizes, samples),
        **dict.fromkeys((f"{s}/sampling-period" for s in ("section3", "section4a", "section4c", "section7")), period),
        **dict.fromkeys(("section4c/filter-coefficient", "table08/cf/joint1", "table08/cf/joint2"), c_f),
        "section4a/time-high": chosen(s["duration_s"] / math.pi, "signals.duration_s"),
        "section4c/power": chosen(config["metric"]["exponent"], "metric.exponent"),
    }


def _training(config: Config) -> dict[str, Ours]:
    paper, unused = config["training"]["paper"], config["training"]["recipe"] != "paper"

    def recipe(value: float, key: str) -> Ours:
        return chosen(value, f"training.paper.{key}", _PAPER_RECIPE, unused)

    images, share = paper["images"], paper["train_share"]
    sets = recipe(images, "images")
    iterations = config["networks"]["paper-recipe"]["training"]["steps"]
    steps = chosen(iterations, "networks.paper-recipe.training.steps", _PAPER_RECIPE, unused)
    return {
        "section4b/learning-rate": recipe(paper["learning_rate"], "learning_rate"),
        "section4b/learning-rate-slope": recipe(paper["learning_rate_slope"], "learning_rate_slope"),
        "section4b/gradient-gain": recipe(paper["gradient_gain"], "gradient_gain"),
        "section4b/iterations": steps,
        "section5a/iterations": steps,
        "section4b/train-images": recipe(share * images, "train_share"),
        "section4b/test-images": recipe(images - share * images, "train_share"),
        "section5a/train-share": recipe(100.0 * share, "train_share"),
        "section5a/test-share": recipe(100.0 - 100.0 * share, "train_share"),
        "section5a/parameter-sets": sets,
        "section6/parameter-sets": sets,
    }


def _search(config: Config) -> dict[str, Ours]:
    a, d = config["algorithm1"], config["data"]
    found = {f"section4a/guess-{end}": chosen(d[f"guess_{end}"], f"data.guess_{end}") for end in ("low", "high")}
    for place in ("section4c", "algorithm1"):
        found |= {f"{place}/guess-{e}": chosen(a[f"guess_{e}"], f"algorithm1.guess_{e}") for e in ("low", "high")}
    executions = chosen(a["executions"], "algorithm1.executions")
    return {
        **found,
        "section6/numeric/threshold": chosen(100.0 * a["threshold_numeric"], "algorithm1.threshold_numeric"),
        "section6/numeric/executions": executions,
        "section6/experimental/executions": executions,
    }


def _experiment(config: Config) -> dict[str, Ours]:
    board, e = config["board"], config["experiment"]
    lengths, speed = config["arm"]["link_lengths_m"], board["speed_limit_rad_s"]
    reach, limit = sum(lengths), e["random_range_rad"]
    found: dict[str, Ours] = {}
    for k in (0, 1):
        found |= {
            f"table08/kp/joint{k + 1}": chosen(board["kp_nm_per_rad"][k], "board.kp_nm_per_rad"),
            f"table08/kv/joint{k + 1}": chosen(board["kv_nm_per_rad"][k], "board.kv_nm_per_rad"),
            f"section5c/full-torque/joint{k + 1}": chosen(board["full_torque_nm"][k], "board.full_torque_nm"),
        }
    joints = ("abstract", "section1a", "section2", "section3", "section4a", "section5", "section5c", "section7")
    return {
        **found,
        **{f"{place}/joints": chosen(len(lengths), "arm.link_lengths_m") for place in joints},
        "section3/motors": chosen(len(board["full_torque_nm"]), "board.full_torque_nm"),
        "table08/pwm/joint1": chosen(1e-3 * board["pwm_hz"][0], "board.pwm_hz"),
        "section3/joint-speed": chosen(speed, "board.speed_limit_rad_s"),
        "section3/tip-speed": chosen(reach * speed, "arm.link_lengths_m", "their sum times board.speed_limit_rad_s"),
        "section6/experimental/threshold": chosen(100.0 * e["threshold"], "experiment.threshold"),
        "section6/T1/range-low": chosen(-limit, "experiment.random_range_rad"),
        "section6/T1/range-high": chosen(limit, "experiment.random_range_rad"),
        "section6/T2/circle": chosen(100.0 * CIRCLE_RADIUS * reach, "arm.link_lengths_m", "radius, a tenth of the sum"),
    }
