"""Where training arms and guesses come from (Section IV-A).

The published ranges (lengths to 0.1 m, masses to 1 kg) cannot give an I2 above 0.02, yet the paper tests
arms with I2 of 0.42 to 0.98. The default is therefore a mixture that covers both.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from repro.keys import Key, Positive, Share
from repro.model.parameters import Array, Links, inertial_from_links

Prior = Literal["mixture", "uniform", "log-uniform", "links", "published"]

Law = Callable[[np.random.Generator, int], Array]  # draws so many parameter sets (n, 9)
LOW, HIGH = 1e-3, 1.0
#: Ranges that Section IV-A prints, SI units: l1, l2, lc1, lc2 and J1; m1, m2 and J2; friction coefficients.
PUBLISHED_LENGTH, PUBLISHED_MASS, PUBLISHED_FRICTION = (LOW, 0.1), (LOW, HIGH), (LOW, HIGH)


def _log_uniform(rng: np.random.Generator, low: float, high: float, shape: tuple[int, ...]) -> Array:
    return np.exp(rng.uniform(np.log(low), np.log(high), shape))


def _links_beta(rng: np.random.Generator, n: int) -> Array:
    """Physically consistent arms: log-uniform links, friction log-uniform on [1e-3, 1]."""
    l1, l2 = _log_uniform(rng, 0.05, 0.6, (2, n))
    m1, m2 = _log_uniform(rng, 0.05, 3.0, (2, n))
    lc1, lc2 = l1 * rng.uniform(0.1, 0.9, n), l2 * rng.uniform(0.1, 0.9, n)
    # The inertia of a slender rod, up to three times as much for motors and flanges.
    j1, j2 = m1 * l1**2 / 12 * rng.uniform(0.5, 3, n), m2 * l2**2 / 12 * rng.uniform(0.5, 3, n)
    inertial = inertial_from_links(Links(m1, m2, l1, lc1, lc2, j1, j2))
    return np.concatenate([inertial, _log_uniform(rng, LOW, HIGH, (n, 4))], -1)


def _published_beta(rng: np.random.Generator, n: int) -> Array:
    """Draw links and friction from the ranges as printed."""
    l1, lc1, lc2, j1 = rng.uniform(*PUBLISHED_LENGTH, (4, n))
    m1, m2, j2 = rng.uniform(*PUBLISHED_MASS, (3, n))
    inertial = inertial_from_links(Links(m1, m2, l1, lc1, lc2, j1, j2))
    return np.concatenate([inertial, rng.uniform(*PUBLISHED_FRICTION, (n, 4))], -1)


#: All but the mixture. Log-uniform arms have some parameters that are much smaller than others.
DRAWS: dict[str, Law] = {
    "uniform": lambda rng, n: rng.uniform(LOW, HIGH, (n, 9)),
    "log-uniform": lambda rng, n: _log_uniform(rng, LOW, HIGH, (n, 9)),
    "links": _links_beta,
    "published": _published_beta,
}
#: Fractions of the mixture.
MIXTURE = {"uniform": 0.5, "log-uniform": 0.25, "links": 0.25}


@dataclass(frozen=True, eq=False, repr=False)
class ListedPrior:
    """Arms of a list, each as probable as any other."""

    arms: Array  # (N, 9)

    def __call__(self, rng: np.random.Generator, n: int) -> Array:
        """Draw n parameter sets (n, 9)."""
        return self.arms[rng.integers(len(self.arms), size=n)]

    def __repr__(self) -> str:
        """Give a text that differs for other arms: it is a part of the fingerprint of a training."""
        return f"ListedPrior({hashlib.sha256(self.arms.tobytes()).hexdigest()})"


def sample_beta(rng: np.random.Generator, n: int, prior: Prior | ListedPrior = "mixture") -> Array:
    """Draw n parameter sets (n, 9) of training arms, all positive."""
    if not isinstance(prior, str):
        return prior(rng, n)
    if prior == "mixture":
        counts = rng.multinomial(n, [*MIXTURE.values()])
        parts = [DRAWS[part](rng, int(k)) for part, k in zip(MIXTURE, counts, strict=True)]
        return rng.permutation(np.concatenate(parts))
    return DRAWS[prior](rng, n)


@dataclass(frozen=True)
class GuessSettings:
    """Distribution of the guesses beta_n of the training images."""

    guess_low: Annotated[Positive, Key("lower end of uniform guesses", "largest torque", "published: Section IV-A")] = (
        1e-3
    )
    guess_high: Annotated[
        Positive, Key("upper end of uniform guesses", "largest torque", "published: Section IV-A", "above `guess_low`")
    ] = 3.0
    exact_share: Annotated[Share, Key("share of M_p images, whose guess is right", source="Section IV-A")] = 0.1
    #: As refinement meets them.
    near_share: Annotated[
        Share, Key("share of guesses with a small error", "", "ours", "with `exact_share` 1 at most")
    ] = 0.2
    near_low: Annotated[
        Positive, Key("lower end of the log-uniform deviation of near guesses", "largest torque", "ours")
    ] = 3e-3
    near_high: Annotated[
        Positive, Key("upper end of the deviation of near guesses", "largest torque", "ours", "above `near_low`")
    ] = 0.5


def training_guess(rng: np.random.Generator, beta_bar: Array, settings: GuessSettings) -> Array:
    """Draw guesses (n, 9) for right answers (n, 9) in units of the largest torque: uniform, near and exact ones."""
    n = len(beta_bar)
    kind = rng.uniform(size=(n, 1))
    size = _log_uniform(rng, settings.near_low, settings.near_high, (n, 1))
    near = np.maximum(beta_bar + size * rng.standard_normal((n, 9)), settings.guess_low)
    uniform = rng.uniform(settings.guess_low, settings.guess_high, (n, 9))  # as line 17 of Algorithm 1 draws them
    guess = np.where(kind < settings.exact_share + settings.near_share, near, uniform)
    return np.where(kind < settings.exact_share, beta_bar, guess)
