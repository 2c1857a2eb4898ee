"""Readings of what the paper leaves open: what each does to the headline numbers, as a table."""

import pandas as pd

from repro.render.markup import Table, Text, number, plain
from repro.signals.programs import SPAN

#: Question under which the reading stands that every other one is compared with.
DEFAULT = "default"


def grouped(frame: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Rows of each question in the order of the file, the default reading first."""
    groups = [(str(question), rows) for question, rows in frame.groupby("question", sort=False)]
    return sorted(groups, key=lambda group: group[0] != DEFAULT)


def table(frame: pd.DataFrame) -> Table:
    """Headline numbers under each reading of the paper."""
    of_arm = ("arm_id", "arm_validation", "arm_refined", "arm_least_squares", "arm_true")
    shares = ("id_mean", "id_lowest", "validation_mean", *of_arm)
    blocks = []
    for question, chosen in grouped(frame):
        rows = []
        for row in chosen.to_dict("records"):
            cells = [plain(row["reading"]), number(row["steps"], 0), number(1e4 * row["held_out_loss"], 2)]
            rows.append([*cells, *(number(100.0 * row[name], 2) for name in shares)])
        blocks.append((plain(f"{question[:1].upper()}{question[1:]}" if question == DEFAULT else question), rows))
    caption = plain(
        "Readings of what the paper leaves open: mean total similarity (%). N1 to N4: literal Algorithm 1, median "
        "of the seeds, on the identification (ID) and the validation (val.) trajectory; lowest is the lowest of the"
        " eight torques. Simulated arm: literal Algorithm 1 on its identification run (arm ID) and its mean over "
        f"{SPAN} (arm val.), medians of the seeds; the same mean for the refined Algorithm 1 (refined), least "
        "squares (LS) and the true parameters (true). The networks are trained with a reduced budget (steps), so "
        "the numbers do not compare with Tables 6 and 7; a reading that needs no network of its own has the "
        "default's. Held-out losses under different labels or images do not compare."
    )
    names = ("ID mean", "ID lowest", "Val. mean", "Arm ID", "Arm val.", "Arm refined", "Arm LS", "Arm true")
    loss = Text(r"Loss~($10^{-4}$)", "Loss (10\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT FOUR})")
    header = [plain("Reading"), plain("Steps"), loss, *(plain(name) for name in names)]
    return Table("Ablation", "tab:ablation", caption, "l" + "r" * 10, header, blocks)
