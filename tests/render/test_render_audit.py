"""Table of the audit: every finding once, what does not agree first, and running text that LaTeX can break."""

import re
from pathlib import Path

import pandas as pd
import pytest
from render_examples import TABLES, laid_out

from repro.exhibits import style
from repro.exhibits.markup import LongTable, plain


def one_finding(**fields: object) -> pd.DataFrame:
    usual = {"place": "Table 7", "what": "a total", "arithmetic": "1 + 1", "verdict": "misprint"}
    return pd.DataFrame([{**usual, "found": None, "printed": None, "unit": None, "note": None, **fields}])


def rows_of(md: str) -> list[list[str]]:
    return [re.split(r" ?(?<!\\)\| ?", line)[1:-1] for line in md.splitlines() if line.startswith("|")][2:]


def test_every_finding_stands_once_and_what_agrees_comes_last(tmp_path: Path) -> None:
    frame = TABLES["audit"]()
    _, md = laid_out(tmp_path, "audit", frame)
    rows = rows_of(md)
    headings = [cells[0].strip("*") for cells in rows if cells[1] == ""]
    counts = frame["verdict"].value_counts()
    assert {heading.split(" (")[0]: int(re.findall(r"\((\d+)\)", heading)[0]) for heading in headings} == dict(counts)
    assert headings[-1].startswith("consistent")
    verdicts = [cells[3].split(":")[0] for cells in rows if cells[1]]
    assert len(verdicts) == len(frame)
    assert "consistent" not in verdicts[: -counts["consistent"]]


def test_values_and_notes_stand_where_there_are_any(tmp_path: Path) -> None:
    whole = {"found": 88.479185, "printed": 85.82, "unit": "%", "note": "One of them is wrong."}
    tex, md = laid_out(tmp_path, "audit", one_finding(**whole))
    assert "| Table 7 | a total. One of them is wrong. | 1 + 1 | misprint: found 88.4792, printed 85.82 (%) |" in md
    assert r"misprint: found~$88.4792$, printed~$85.82$ ($\mathrm{\%}$)" in tex
    assert "| a total | 1 + 1 | misprint |" in laid_out(tmp_path, "audit", one_finding())[1]
    both = pd.concat([one_finding(found=3, unit="1"), one_finding(unit="%")])
    assert "misprint: found 3 |" in laid_out(tmp_path, "audit", both)[1]
    _, md = laid_out(tmp_path, "audit", one_finding(**whole, verdict="consistent"))
    assert "| a total | 1 + 1 | consistent |" in md


def test_formulas_within_sentences(tmp_path: Path) -> None:
    arithmetic = "I3 - lambda_R1^max >= -2 x 10^-3 m^2 & 5 %, g_f -> exp(x)"
    tex, md = laid_out(tmp_path, "audit", one_finding(arithmetic=arithmetic))
    assert r"$I_{3}$ $-$ $\lambda _{R1}^{\max}$ $\geq$ $-$2 $\times$ 10$^{-3}$ m$^{2}$ \& 5 \%," in tex
    assert r", $g_{f}$ $\rightarrow$ exp(x) &" in tex
    assert "| I₃ - λ\\_R1^max ≥ -2 \N{MULTIPLICATION SIGN} 10⁻³ m² & 5 %, g\\_f → exp(x) |" in md


def test_columns_fill_the_page(tmp_path: Path) -> None:
    tex, _ = laid_out(tmp_path, "audit", TABLES["audit"]())
    widths = [float(width) for width in re.findall(r"\}p\{([\d.]+)in\}", tex)]
    gap = 2 * float(re.findall(r"tabcolsep\}\{([\d.]+)pt", tex)[0]) / 72.27
    assert sum(widths) + (len(widths) - 1) * gap == pytest.approx(style.PAGE, abs=0.005)
    assert "inf" not in tex.split()
    with pytest.raises(ValueError, match="shares"):
        LongTable(plain(""), "ll", (), (), (0.5, 0.4))
