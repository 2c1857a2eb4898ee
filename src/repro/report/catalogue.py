"""Every table and figure that the report shows, in the order of the paper."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Exhibit:
    """One table or figure.

    Attributes
    ----------
    kind : {"table", "figure"}
        Which of the two.
    name : str
        Stem of its files.
    target : str
        Target of the workflow that makes it; also its anchor in the page.
    label : str
        What the paper calls it; an addition of ours has a label of its own.
    title : str
        What it shows, in a few words.
    simulated : bool
        Whether its numbers come from the simulated arm.
    optional : bool
        Whether it is made only when asked for: a report is whole without it.
    """

    kind: Literal["table", "figure"]
    name: str
    target: str
    label: str
    title: str
    simulated: bool = False
    optional: bool = False


_TABLES = {
    1: "Related work",
    2: "Dynamic parameters",
    3: "Characteristics of the network",
    4: "Parameters of N1 and N2",
    5: "Parameters of N3 and N4",
    6: "Similarity on the identification trajectory",
    7: "Similarity on the validation trajectory",
    8: "Position control of the board",
    9: "Parameters of the arm",
    10: "Similarity on the identification run and on T1 to T4",
}

_FIGURES = {
    1: "The arm and its symbols",
    2: "Hardware blocks and buses",
    3: "Flow of the position control",
    4: "The method",
    5: "Subsampling with the DCT-II",
    6: "Identification trajectory",
    7: "Architecture of the network",
    8: "Signal images",
    9: "Distribution of the training torques",
    10: "Loss over the training",
    11: "Spectra of the kernels",
    12: "Torques of N1 and N2",
    13: "Torques of N3 and N4",
    14: "Spectra of the numeric torques",
    15: "Validation torques",
    16: "Validation trajectory",
    17: "Spectra of the validation torques",
    18: "Experimental set-up",
    19: "Torques and motion of the identification run",
    20: "Spectra of the identification run's torques",
    21: "Paths of the tip in T1 to T4",
    22: "Motions of T1 to T4",
    23: "Torques of T1 to T4",
    24: "Spectra of the torques of T1 to T4",
}

#: The experimental part of the paper, which here runs on a simulated arm.
_SIMULATED_TABLES = range(8, 11)
_SIMULATED_FIGURES = range(18, 25)

TABLES = (
    *(
        Exhibit("table", f"table{n:02d}", f"table{n:02d}", f"Table {n}", title, n in _SIMULATED_TABLES)
        for n, title in _TABLES.items()
    ),
    Exhibit("table", "why", "why_table", "Why", "From the ideal case to the recording, one cause at a time", True),
    Exhibit("table", "coverage", "coverage_table", "Coverage", "Do the intervals of the network cover", True),
    Exhibit("table", "intervals", "intervals", "Intervals", "The arm's parameters with the network's intervals", True),
    Exhibit("table", "verdict", "verdict", "Verdict", "Algorithm 1 against the field's methods", True),
    Exhibit("table", "stability", "stability", "Stability", "Conditions of the appendix", True),
    Exhibit("table", "metric_search", "metric_search_table", "Metric search", "Ranking of the formulas of metr2ev"),
    Exhibit(
        "table", "paper_recipe", "paper_recipe_table", "The paper's training", "Literal Algorithm 1 with it", True, True
    ),
    Exhibit("table", "ablation", "ablation_table", "Ablation", "Headline numbers under other readings", optional=True),
)

FIGURES = (
    *(
        Exhibit("figure", f"fig{n:02d}", f"fig{n:02d}", f"Figure {n}", title, n in _SIMULATED_FIGURES)
        for n, title in _FIGURES.items()
    ),
    Exhibit("figure", "why", "why_figure", "Why", "From the ideal case to the recording, one cause at a time", True),
    Exhibit("figure", "coverage", "coverage_figure", "Coverage", "Levels at which intervals reach the truth", True),
    Exhibit("figure", "spread", "spread_figure", "Spread", "Similarity over many simulated arms", True),
    Exhibit("figure", "metric_search", "metric_search_figure", "Metric search", "Candidates for the metric's formula"),
    Exhibit("figure", "paper_recipe", "paper_recipe_figure", "The paper's training", "Loss beside ours", optional=True),
    Exhibit("figure", "ablation", "ablation_figure", "Ablation", "Headline numbers by reading", optional=True),
)

#: Targets that have a section of their own.
SECTIONS = ("claims", "audit")

TARGETS = frozenset((*SECTIONS, *(exhibit.target for exhibit in (*TABLES, *FIGURES))))

SIMULATED = frozenset(exhibit.target for exhibit in (*TABLES, *FIGURES) if exhibit.simulated)
