"""Every table and figure, in the order of the paper: one entry makes the target and the report's section."""

from dataclasses import dataclass
from typing import Literal

from repro.signals.programs import SPAN

Kind = Literal["table", "figure"]

METHOD, SIGNALS, DATA, MODEL, METRIC = "Method", "Signals", "Data", "Model", "Metric"
NUMERIC, VALIDATION, ABLATION = "Numeric results", "Numeric validation", "Ablation"
EXPERIMENT = "Experiment (simulated)"


@dataclass(frozen=True)
class Exhibit:
    """One table or figure."""

    kind: Kind  # which of the two
    name: str  # stem of its files
    target: str  # target of the workflow that makes it; also its anchor in the page and the stem of its caption's file
    label: str  # what the paper calls it; an addition of ours has a label of its own
    title: str  # what it shows, in a few words
    category: str  # chapter of the workflow's own report
    family: str  # module of `repro.exhibits` that makes it
    inputs: tuple[str, ...] = ()  # what its numbers are made from: keys of SOURCES in `workflow/rules/exhibits.smk`
    sections: tuple[str, ...] = ()  # sections of the configuration that its numbers depend on
    optional: bool = False  # whether it is made only when asked for: a report is whole without it

    @property
    def simulated(self) -> bool:
        """Whether its numbers come from the simulated arm."""
        return self.category in (EXPERIMENT, ABLATION)


_FAMILIES = {NUMERIC: "numeric", VALIDATION: "numeric", EXPERIMENT: "arm"}
_FAMILIES |= dict.fromkeys((METHOD, SIGNALS, DATA, MODEL), "method")


def _paper(number: int, kind: Kind, title: str, category: str, *inputs: str, of: tuple[str, ...] = ()) -> Exhibit:
    """A table or figure of the paper; `of` are its sections."""
    name, label = (f"table{number:02d}", "Table") if kind == "table" else (f"fig{number:02d}", "Figure")
    return Exhibit(kind, name, name, f"{label} {number}", title, category, _FAMILIES[category], inputs, of)


def _ours(
    kind: Kind,
    name: str,
    label: str,
    title: str,
    category: str,
    family: str,
    *inputs: str,
    target: str = "",
    of: tuple[str, ...] = (),
    optional: bool = False,
) -> Exhibit:
    """A table or figure that the paper does not have."""
    return Exhibit(kind, name, target or f"{name}_{kind}", label, title, category, family, inputs, of, optional)


_TRAINING = ("signals", "data", "image", "training")
_NUMERIC = ("signals", "numeric")
_ARM = ("signals", "arm", "board", "experiment")

TABLES = (
    _paper(1, "table", "Related work", METHOD),
    _paper(2, "table", "Dynamic parameters", MODEL),
    _paper(3, "table", "Characteristics of the network", MODEL, of=("signals", "network", "training")),
    _paper(4, "table", "Parameters of N1 and N2", NUMERIC, "networks"),
    _paper(5, "table", "Parameters of N3 and N4", NUMERIC, "networks"),
    _paper(6, "table", "Similarity on the identification trajectory", NUMERIC, "networks"),
    _paper(7, "table", "Similarity on the validation trajectory", VALIDATION, "networks"),
    _paper(8, "table", "Position control of the board", EXPERIMENT, "ID", of=(*_ARM, "metric")),
    _paper(9, "table", "Parameters of the arm", EXPERIMENT, "arm"),
    _paper(10, "table", f"Similarity on the identification run and on {SPAN}", EXPERIMENT, "arm"),
    _ours("table", "why", "Why", "Motions of the training and of line 18, crossed", EXPERIMENT, "study", "arm"),
    _ours("table", "coverage", "Coverage", "Do the intervals of the network cover", EXPERIMENT, "study", "coverage"),
    _ours(
        "table",
        "intervals",
        "Intervals",
        "The arm's parameters with the network's intervals",
        EXPERIMENT,
        "study",
        "coverage",
        target="intervals",
    ),
    _ours(
        "table",
        "verdict",
        "Verdict",
        "Algorithm 1 against the field's methods",
        EXPERIMENT,
        "study",
        "spread",
        target="verdict",
    ),
    _ours(
        "table",
        "stability",
        "Stability",
        "Conditions of the appendix",
        EXPERIMENT,
        "arm",
        "arm",
        target="stability",
        of=("arm",),
    ),
    _ours(
        "table",
        "both_metrics",
        "Both metrics",
        "Headline rows under both time factors",
        EXPERIMENT,
        "study",
        "headline",
        target="both_metrics",
        of=(*_ARM, "metric", "numeric"),
    ),
    _ours("table", "metric_search", "Metric search", "Ranking of the formulas of metr2ev", METRIC, "paper", "search"),
    _ours(
        "table",
        "metric_motions",
        "Metric motions",
        "Random motions that explain Table 7",
        METRIC,
        "paper",
        "search",
        target="metric_motions",
    ),
    _ours(
        "table",
        "paper_recipe",
        "The paper's training",
        "Literal Algorithm 1 with it",
        ABLATION,
        "numeric",
        "paper_recipe",
        optional=True,
    ),
    _ours(
        "table",
        "factorial",
        "Factorial",
        "Effects of the causes",
        ABLATION,
        "study",
        "factorial",
        optional=True,
    ),
    _ours(
        "table",
        "factorial_cells",
        "Factorial, cells",
        "Similarities under each combination of the causes",
        ABLATION,
        "study",
        "factorial",
        target="factorial_cells",
        optional=True,
    ),
    _ours(
        "table",
        "ablation",
        "Ablation",
        "Headline numbers under other readings",
        ABLATION,
        "study",
        "readings",
        optional=True,
    ),
)

FIGURES = (
    _paper(1, "figure", "Schematic of the arm", METHOD),
    _paper(2, "figure", "Hardware blocks of the FPGA", METHOD),
    _paper(3, "figure", "Flow chart of the PD control", METHOD),
    _paper(4, "figure", "Identification method", METHOD),
    _paper(5, "figure", "Subsampling technique", SIGNALS, of=_NUMERIC),
    _paper(6, "figure", "Identification trajectory", SIGNALS, of=("signals",)),
    _paper(7, "figure", "Architecture of the CNN", MODEL, of=("signals", "network")),
    _paper(8, "figure", "Images of the training data", DATA, of=_TRAINING),
    _paper(9, "figure", "Distribution of the training torques", DATA, of=_TRAINING),
    _paper(10, "figure", "Loss over the training", MODEL, "history"),
    _paper(11, "figure", "Spectra of the kernels", MODEL, "weights", of=("signals", "network")),
    _paper(12, "figure", "Torques of N1 and N2", NUMERIC, "published", of=_NUMERIC),
    _paper(13, "figure", "Torques of N3 and N4", NUMERIC, "published", of=_NUMERIC),
    _paper(14, "figure", "Spectra of the numeric torques", NUMERIC, "published", of=_NUMERIC),
    _paper(15, "figure", "Validation torques", VALIDATION, "published", of=_NUMERIC),
    _paper(16, "figure", "Validation trajectory", VALIDATION, "published", of=_NUMERIC),
    _paper(17, "figure", "Spectra of the validation torques", VALIDATION, "published", of=_NUMERIC),
    _paper(18, "figure", "Experimental set-up", EXPERIMENT, of=_ARM),
    _paper(19, "figure", "Torques and motion of the identification run", EXPERIMENT, "ID", "arm", of=_ARM),
    _paper(20, "figure", "Spectra of the identification run's torques", EXPERIMENT, "ID", "arm", of=_ARM),
    _paper(21, "figure", f"Paths of the tip in {SPAN}", EXPERIMENT, "validation", of=_ARM),
    _paper(22, "figure", f"Motions of {SPAN}", EXPERIMENT, "validation", of=_ARM),
    _paper(23, "figure", f"Torques of {SPAN}", EXPERIMENT, "validation", "arm", of=_ARM),
    _paper(24, "figure", f"Spectra of the torques of {SPAN}", EXPERIMENT, "validation", "arm", of=_ARM),
    _ours("figure", "why", "Why", "Motions of the training and of line 18, crossed", EXPERIMENT, "study", "arm"),
    _ours(
        "figure", "coverage", "Coverage", "Levels at which intervals reach the truth", EXPERIMENT, "study", "coverage"
    ),
    _ours("figure", "spread", "Spread", "Similarity over many simulated arms", EXPERIMENT, "study", "spread"),
    _ours("figure", "metric_search", "Metric search", "Candidates for the metric's formula", METRIC, "paper", "search"),
    _ours(
        "figure",
        "paper_recipe",
        "The paper's training",
        "Loss beside ours",
        ABLATION,
        "numeric",
        "losses",
        of=("training", "networks"),
        optional=True,
    ),
    _ours("figure", "factorial", "Factorial", "Effects of the causes", ABLATION, "study", "factorial", optional=True),
    _ours(
        "figure", "ablation", "Ablation", "Headline numbers by reading", ABLATION, "study", "ablation", optional=True
    ),
)

#: Has a section of its own in the report.
AUDIT = Exhibit("table", "audit", "audit", "Audit", "Audit of the paper", "Claims", "paper")
EXHIBITS = (*TABLES, *FIGURES, AUDIT)

#: Targets that have a section of their own.
SECTIONS = ("claims", AUDIT.target)

TARGETS = frozenset((*SECTIONS, *(exhibit.target for exhibit in (*TABLES, *FIGURES))))
