"""Every table by name, and laying one out from its CSV in LaTeX and Markdown."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from repro.errors import InputError
from repro.files import read_csv, write_text
from repro.render import (
    ablation_table,
    audit_table,
    coverage,
    description_tables,
    experiment_tables,
    result_tables,
    why,
)
from repro.render.markup import Table

#: Table from the tidy table that holds its numbers.
LAYOUTS: dict[str, Callable[[pd.DataFrame], Table]] = {
    "table01": description_tables.related_work,
    "table02": description_tables.parameters,
    "table03": description_tables.characteristics,
    "table04": result_tables.parameters_12,
    "table05": result_tables.parameters_34,
    "table06": result_tables.similarity,
    "table07": result_tables.validation,
    "table08": experiment_tables.control,
    "table09": experiment_tables.parameters,
    "table10": result_tables.experiment,
    "stability": experiment_tables.stability,
    "verdict": experiment_tables.verdict,
    "why": why.table,
    "paper_recipe": result_tables.paper_recipe,
    "coverage": coverage.table,
    "intervals": coverage.intervals,
    "metric_search": description_tables.metric_search,
    "ablation": ablation_table.table,
    "audit": audit_table.audit,
}


def lay_out(name: str, csv_path: Path, tex_path: Path, md_path: Path) -> None:
    r"""Lay out one table from its CSV."""
    if name not in LAYOUTS:
        raise InputError.at("table", repr(name), f"one of {', '.join(LAYOUTS)}")
    frame = read_csv(csv_path)
    try:
        table = LAYOUTS[name](frame)
    except InputError as error:
        raise InputError(f"{csv_path}: {error}") from error
    write_text(tex_path, table.tex())
    write_text(md_path, table.md())
