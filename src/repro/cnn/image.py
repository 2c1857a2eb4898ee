"""From torque, motion and a guess to the 100 x 100 x 2 image (Eq. 8 and 9), and its colours (Eq. 16).

Each channel of Eq. 9 is a sum of two outer products, so it has rank 2 and is kept as its factors: with
``u = (psi / m1, psi2 / m2)`` and ``v = (alpha, alpha2)`` the image is ``Z[d] = sum_r u[d, r] v[d, r]^T``. Only figures
build the image itself (`assemble`).
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.keys import SECTION, Key, Positive
from repro.model.dynamics import check_motion, inverse_dynamics
from repro.model.parameters import NAMES

Floats = NDArray[np.floating]

Scale = Literal["shared-max", "channel-max", "constant"]

#: Added before the logarithms of Eq. 9.
LOG_OFFSET = 1e-3
#: Weights of both channels in red, green and blue (Eq. 16).
COLOUR_WEIGHTS = ((2 / 3, 0.7 / 3), (2 / 3, 0.0), (2 / 3, 1.0))


@dataclass(frozen=True)
class ImageSettings:
    """Scaling of the image."""

    __pydantic_config__ = SECTION

    #: With a constant, a guess that is wrong by a common factor looks different from a right one (in the ablation).
    scale: Annotated[
        Scale, Key("divisor of Z1: its maximum over both channels, over each, or a constant", source="Eq. 9")
    ] = "shared-max"
    constant: Annotated[Positive, Key("divisor of Z1 if `scale` is `constant`", source="ours")] = 4.0


PUBLISHED_IMAGE = ImageSettings()


def _unit_range(x: Floats, axes: tuple[int, ...]) -> Floats:
    """Shift and scale to the range 0 to 1 over `axes` (**normalize** of Eq. 9); a constant becomes 0."""
    low = x.min(axes, keepdims=True)
    span = x.max(axes, keepdims=True) - low
    return np.asarray((x - low) / np.where(span > 0, span, 1))


def _axes(settings: ImageSettings) -> tuple[int, ...]:
    """Axes of signals (..., 2, S) that a maximum of Eq. 9 goes over."""
    return (-1,) if settings.scale == "channel-max" else (-2, -1)


def torque_factors(alpha: Floats, settings: ImageSettings) -> Floats:
    """Compute the factors v (..., channel, rank, S), which no guess changes, from the torque alpha (..., 2, S)."""
    offset = np.asarray(LOG_OFFSET, alpha.dtype)
    return np.stack([alpha, np.log(_unit_range(alpha, _axes(settings)) + offset)], -2)


def guess_factors(psi: Floats, v: Floats, settings: ImageSettings) -> Floats:
    """Compute the factors u (..., channel, rank, S) from psi (..., 2, S) and the factors v of the torque."""
    axes = _axes(settings)
    psi2 = np.log10(_unit_range(psi, axes) + np.asarray(LOG_OFFSET, psi.dtype))
    u = np.stack([psi, psi2], -2)
    # max |a b^T| over a channel is the product of the factors' largest magnitudes.
    product = np.maximum(u.max(-1), -u.min(-1)) * np.abs(v).max(-1)  # (..., channel, rank)
    if settings.scale != "channel-max":
        product = product.max(-2, keepdims=True)
    divisor = np.where(product > 0, product, 1)
    if settings.scale == "constant":
        divisor[..., 0] = settings.constant
    u /= divisor[..., None]
    return u


def image_factors(alpha: Floats, psi: Floats, settings: ImageSettings) -> tuple[Floats, Floats]:
    """Compute the factors u and v (..., channel, rank, S) of the image of Eq. 9, in the dtype of the signals.

    alpha (..., 2, S) is the normalised torque tau_r of Eq. 8, psi (..., 2, S) is 2 tau_r - f(q_r, dq_r, ddq_r, beta_n).
    """
    v = torque_factors(alpha, settings)
    u = guess_factors(psi, v, settings)
    return u, np.broadcast_to(v, u.shape)


def assemble(u: Floats, v: Floats) -> Floats:
    """Build the image (..., 2, S, S): channel, row (psi), column (alpha). Only figures need it, not the network."""
    return np.swapaxes(u, -1, -2) @ v


def images(
    q: ArrayLike,
    dq: ArrayLike,
    ddq: ArrayLike,
    tau: ArrayLike,
    guess: ArrayLike,
    settings: ImageSettings = PUBLISHED_IMAGE,
) -> Floats:
    """Build the images that the network reads, from a torque and from what Eq. 1 gives for a guess (Eq. 8 and 9).

    Parameters
    ----------
    q, dq, ddq : array_like of shape (2, S)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2), subsampled; the paper has S = 100.
    tau : array_like of shape (2, S)
        Torque at the same instants, N m, not zero throughout.
    guess : array_like of shape (..., 9)
        Guesses of the parameters in units of the largest torque, as line 17 draws them.
    settings : ImageSettings
        Divisors of Eq. 9, not public: leave it out, as the networks in ``data/networks`` are trained with the default.

    Returns
    -------
    array of shape (..., 2, S, S)
        Channel, row (the guess) and column (the torque).

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, or the torque is zero throughout.

    Examples
    --------
    >>> t = np.linspace(0.0, 9.4, 100)
    >>> q = np.stack([np.sin(t), np.sin(2.5 * t)])
    >>> repro.images(q, 0 * q, 0 * q, np.cos(q), np.full((3, 9), 0.5)).shape
    (3, 2, 100, 100)
    """
    q, dq, ddq, tau = check_motion(q, dq, ddq, tau)
    if np.shape(guess)[-1:] != (len(NAMES),):
        raise ValueError(f"guess: the last axis must hold {len(NAMES)} parameters, got shape {np.shape(guess)}.")
    largest = np.abs(tau).max()
    if largest == 0.0:
        raise ValueError("tau: the torque is zero throughout.")
    alpha = tau / largest
    psi = 2.0 * alpha - inverse_dynamics(q, dq, ddq, guess)
    return assemble(*image_factors(np.broadcast_to(alpha, psi.shape), psi, settings))


def colours(image: Floats) -> Floats:
    """Compute the colours (..., S, S, 3) of Eq. 16, clipped to 0 to 1, of images (..., 2, S, S)."""
    z1, z2 = image[..., 0, :, :], image[..., 1, :, :]
    (red1, red2), (green1, _), (blue1, _) = COLOUR_WEIGHTS
    rgb = np.stack([red1 * z1 + red2 * z2, green1 * z1, blue1 * z1 + z2], -1)
    return np.asarray(np.clip(rgb, 0.0, 1.0))
