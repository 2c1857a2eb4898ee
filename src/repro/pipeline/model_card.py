"""The model card of a network, and its layers."""

import hashlib
from math import prod
from pathlib import Path

import pandas as pd

from repro.cnn.architecture import NetworkSettings, TrainingSettings
from repro.cnn.dataset import DataSettings


def architecture(settings: NetworkSettings) -> pd.DataFrame:
    """Figure 7: every layer with its size and number of parameters."""
    k, maps, (p1, p2, p3) = settings.kernels, settings.maps, settings.pooled

    def count(name: str) -> int:
        return sum(prod(settings.weights[f"{name}.{part}"]) for part in ("weight", "bias"))

    rows = [
        ("input", "input", settings.image_size, settings.image_size, 2, "", 0),
        ("conv1", "convolution", 2 * p1, 2 * p1, maps, f"{k[0]}x{k[0]}x2x{maps}", count("conv1")),
        ("pool1", "max pool", p1, p1, maps, "2x2", 0),
        ("conv2", "convolution", 2 * p2, 2 * p2, maps, f"{k[1]}x{k[1]}x{maps}x{maps}", count("conv2")),
        ("pool2", "max pool", p2, p2, maps, "2x2", 0),
        ("conv3", "convolution", p3, p3, maps, f"{k[2]}x{k[2]}x{maps}x{maps}", count("conv3")),
        ("fc4", "fully connected", 1, 1, settings.hidden[0], "", count("fc4")),
        ("fc5", "fully connected", 1, 1, settings.hidden[1], "", count("fc5")),
        ("output", "output", 1, 1, 9, "", count("fc6")),
    ]
    return pd.DataFrame(rows, columns=["layer", "kind", "height", "width", "channels", "kernel", "parameters"])


def model_card(
    weights: Path,
    history: pd.DataFrame,
    network: NetworkSettings,
    data: DataSettings,
    training: TrainingSettings,
    seconds_at: list[float],
    motions: str,
) -> str:
    """What a user of the weights wants to know, as Markdown."""
    layers = architecture(network)
    last = history.iloc[-1]
    below = history.index[history["test_loss"] <= 1e-3]
    reached = (
        f"step {int(history['step'][below[0]])}, after {seconds_at[below[0]]:.0f} s"
        if len(below)
        else "not reached in this budget"
    )
    digest = hashlib.sha256(weights.read_bytes()).hexdigest()
    size = [f"| {r.layer} | {r.kind} | {r.height} x {r.width} x {r.channels} | {r.kernel} | {r.parameters} |"
            for r in layers.itertuples()]  # fmt: skip
    lines = [
        f"# Model card: {weights.name}",
        "",
        "Reads the nine parametric residuals of a two-joint arm off the 100 x 100 x 2 signal image of Eq. 9.",
        "Trained on torques computed by numeric substitution in Eq. 1; no measured data.",
        "",
        "| layer | kind | output | kernel | parameters |",
        "|---|---|---|---|---|",
        *size,
        "",
        f"- Parameters: {int(layers['parameters'].sum())}",
        f"- Recipe: {training.recipe}, {training.steps} steps of {training.batch} images, seed {training.seed}, "
        f"{training.precision} arithmetic in layers 1 to 4",
        f"- Arms: {data.prior} prior; guesses: {data.guess.exact_share:.0%} exact, {data.guess.near_share:.0%} near, "
        f"the rest uniform on {data.guess.low:g} to {data.guess.high:g}",
        f"- Motions: {motions}",
        f"- Torque beyond Eq. 1, at most: {data.unmodelled}",
        f"- Image: Z1 divided by {data.image.scale}"
        + (f" ({data.image.constant:g})" if data.image.scale == "constant" else ""),
        f"- Final loss: training {last['train_loss']:.3e}, held-out {last['test_loss']:.3e}",
        f"- Held-out loss of 1e-3: {reached}",
        f"- Training time: {seconds_at[-1]:.0f} s of wall time",
        f"- SHA-256 of the weights: `{digest}`",
        "",
        "Use: identification of arms that are sent Eq. 10's trajectory. Not for other motions: the image's meaning",
        "depends on the motion. Parameters are read in units of the largest torque.",
        "",
    ]
    return "\n".join(lines)
