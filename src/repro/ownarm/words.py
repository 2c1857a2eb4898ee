"""A plain verdict on each parameter."""

import math

from repro.identification.sensitivity import UNMODELLED_EFFECTS

#: What the intervals are valid for, in one sentence.
ALLOWED = (
    "the 95 % intervals allow for noise, the choice of filters and delay, errors of the motion, "
    f"{', '.join(UNMODELLED_EFFECTS)}, "
    "one of these effects at a time; not for a wrong scale of both torques, elasticity or backlash"
)
#: Half an interval over the estimate: up to this the parameter is known.
KNOWN = 0.5


NOT_EXCITED = "not excited by this motion"
IMPOSSIBLE = "negative, which no arm has: something is wrong with the log or the model"
COMBINED = "determined in a combination only, see the base parameters"


def verdict(
    estimate: float,
    low: float | None,
    high: float | None,
    excited: bool,
    held: bool,
    determined: bool = True,
    possible: bool = True,
    doubt: str = "",
) -> str:
    """What a roboticist may say about a parameter.

    Parameters
    ----------
    estimate : float
        Value.
    low, high : float or None
        Ends of the 95 % interval, if there is one.
    excited : bool
        Whether the motion moves a torque through it that is worth mentioning.
    held : bool
        Whether a condition of the method holds it at its bound.
    determined : bool
        Whether the motion determines it by itself.
    possible : bool
        Whether an arm can have such a value.
    doubt : str
        Why there is no interval; empty where the method claims none.

    Returns
    -------
    str
        One phrase.
    """
    if not determined:
        return COMBINED if excited else NOT_EXCITED
    if held:
        return "held at zero: the log alone would make it negative"
    if low is None or high is None:
        none = f"no interval: {doubt}" if doubt else "no interval claimed by this method"
        return none if excited else NOT_EXCITED
    if low <= 0.0 <= high:
        return "not told from zero" if excited else NOT_EXCITED
    share = 0.5 * (high - low) / abs(estimate)
    known = f"known to {_percent(share)} %" if share <= KNOWN else "sign known, size only roughly"
    return known if possible else IMPOSSIBLE


def _percent(share: float) -> str:
    """Percent rounded up to one or two digits: 0.4, 3, 12."""
    percent = 100.0 * share
    if percent >= 1.0:
        return str(math.ceil(percent - 1e-9))
    return f"{max(math.ceil(percent * 10.0 - 1e-9) / 10.0, 0.1):g}"
