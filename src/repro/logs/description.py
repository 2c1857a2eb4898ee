"""What is told about a log before anything is computed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Description:
    """What a log holds, told before anything is computed.

    Attributes
    ----------
    name : str
        File name.
    facts : tuple of (str, str)
        What was found and its value with unit: rate, length, motion range, gaps, saturation, quantisation ...
    notes : tuple of str
        Assumptions and conversions on reading.
    warnings : tuple of str
        What may spoil the result, one line each.
    simulated : bool
        Whether the simulated board made it.
    """

    name: str
    facts: tuple[tuple[str, str], ...]
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    simulated: bool = False
