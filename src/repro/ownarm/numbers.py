"""Numbers as the report prints them: an estimate has the decimals that its standard error deserves."""

import math
from dataclasses import dataclass

from repro.ownarm.result import Parameter

#: Powers of ten outside these are written as such.
_LOWEST_POWER, _HIGHEST_POWER = -4, 5

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Printed:
    """An estimate in print; all but `estimate` are empty where the method claims no interval.

    Attributes
    ----------
    estimate, error, low, high : str
        Estimate, standard error and ends of the interval, to the same decimals.
    power : str
        A power of ten that multiplies all four, such as ``×10⁻⁷``; mostly empty.
    """

    estimate: str
    error: str
    low: str
    high: str
    power: str

    @property
    def both(self) -> str:
        """Estimate and standard error in one."""
        if not self.error:
            return self.estimate + self.power
        text = f"{self.estimate} ± {self.error}"
        return f"({text}){self.power}" if self.power else text

    @property
    def interval(self) -> str:
        """Both ends; empty if there are none."""
        return f"{self.low} to {self.high}{self.power}" if self.low else ""


def _power(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _times_power(power: int) -> str:
    return f"\N{MULTIPLICATION SIGN}10{str(power).translate(_SUPERSCRIPTS)}"


def _fixed(value: float | None, decimals: int) -> str:
    """Text with this many decimals; empty for None, and never a negative zero."""
    return "" if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"


def printed(parameter: Parameter) -> Printed:
    """Round an estimate to two digits of its standard error, or to four digits without one."""
    estimate, error = parameter.estimate, parameter.standard_error
    values = (estimate, error, parameter.low, parameter.high)
    if not all(value is None or math.isfinite(value) for value in values):
        shown, spread, low, high = ("" if value is None else significant(value) for value in values)
        return Printed(shown, spread, low, high, "")
    largest = max(abs(estimate), error or 0.0)
    power = _power(largest) if largest > 0.0 else 0
    scaled = not _LOWEST_POWER <= power <= _HIGHEST_POWER
    scale = 10.0**power if scaled else 1.0
    last = _power(error) - 1 if error else (_power(estimate) - 3 if estimate else 0)  # power of the last digit shown
    decimals = min(max(0, (power if scaled else 0) - last), 12)
    shown, spread, low, high = (_fixed(None if value is None else value / scale, decimals) for value in values)
    return Printed(shown, "0" if error == 0.0 else spread, low, high, _times_power(power) if scaled else "")


def significant(value: float, digits: int = 3) -> str:
    """Text with this many significant digits, as a power of ten only where it is far from 1."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value + 0.0:g}"  # no negative zero
    power = _power(float(f"{value:.{digits - 1}e}"))
    if _LOWEST_POWER <= power <= _HIGHEST_POWER:
        return _fixed(value, max(0, digits - 1 - power))
    return _fixed(value / 10.0**power, digits - 1) + _times_power(power)


def percent(fraction: float) -> str:
    """Text of a fraction of 1 in percent."""
    return f"{100.0 * fraction:.1f}" if abs(fraction) < 10.0 else significant(100.0 * fraction)
