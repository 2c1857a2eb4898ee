"""What a user may ask of `repro identify`."""

from dataclasses import dataclass
from pathlib import Path

from repro.identification.filters import FILTERS


@dataclass(frozen=True)
class Options:
    """Choices of one run.

    Attributes
    ----------
    methods : tuple of str
        Names, in the order of the report.
    filter : str
        Key of `repro.identification.filters.FILTERS`.
    cutoff : float or None
        Hz; None: chosen from the log.
    seed : int
        Of the bootstrap, of training and of the search.
    steps : int
        Steps of training of the CNN.
    cache : Path
        Folder of trained networks.
    friction : bool
        Whether friction beyond Eq. 1 is taken out of the torque where a log asks for it.
    """

    methods: tuple[str, ...]
    cache: Path
    filter: str = "dct"
    cutoff: float | None = None
    seed: int = 1
    steps: int = 1500
    friction: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot be done."""
        if not self.methods:
            raise ValueError("methods: at least one must be asked for.")
        if self.filter not in FILTERS:
            raise ValueError(f"filter: must be one of {tuple(FILTERS)}, got {self.filter!r}.")
        if self.cutoff is not None and not 0.0 < self.cutoff < float("inf"):
            raise ValueError(f"cutoff: must be positive and finite, got {self.cutoff}.")
