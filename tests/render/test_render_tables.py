"""Tables one by one: cells are the numbers given, and a message names what is wrong with them."""

import re
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from render_examples import CASES, TABLES, laid_out, parameters_frame, refused, search_frame, similarity_frame


def test_parameter_table_holds_the_numbers(tmp_path: Path) -> None:
    frame = parameters_frame(("N1", "N2"))
    tex, md = laid_out(tmp_path, "table04", frame)
    for row in frame.itertuples():
        assert f"| {row.true:.4f} | {row.estimate:.4f} ± 0.0030 |" in md
        assert f"${row.true:.4f}$ & ${row.estimate:.4f} \\pm 0.0030$" in tex
    assert r"$I_{1}$~($\mathrm{kg\,m^{2}}$)" in tex
    assert "| b₂ (kg·m²/s) |" in md
    assert "N1 true | N1 identified | N2 true | N2 identified" in md
    headings = re.findall(r"^\| \*\*(.*?)\*\*", md, flags=re.MULTILINE)
    assert [heading.split(" (")[0] for heading in headings] == [
        "Algorithm 1",
        "Algorithm 1 + refinement",
        "Algorithm 1 + the refinement's selection without the network",
        "a further\\_one",
    ]
    _, alone = laid_out(tmp_path, "table04", frame.assign(estimate_sd=0.0))
    assert "±" not in alone


def test_similarity_table_holds_the_numbers(tmp_path: Path) -> None:
    frame = similarity_frame()
    tex, md = laid_out(tmp_path, "table06", frame)
    for row in frame.itertuples():
        assert f"{100 * row.total:.2f} ± 0.42" in md
        assert f"${100 * row.total:.2f} \\pm 0.42$" in tex
        for value in (row.time, row.frequency):
            assert f"| {100 * value:.2f} |" in md
            assert f"${100 * value:.2f}$" in tex
    first = frame[(frame["method"] == "algorithm1") & (frame["joint"] == 2)].set_index("case")["time"]
    assert "| Time τ₂ | " + " | ".join(f"{100 * first[case]:.2f}" for case in CASES) + " |" in md
    assert "median of 5 seeds" in md
    assert "median of 5 seeds" in tex
    _, alone = laid_out(tmp_path, "table07", similarity_frame(1))
    assert "one seed" in alone
    assert "±" not in alone


def test_a_block_of_one_run_has_no_spread_and_the_caption_says_why(tmp_path: Path) -> None:
    one = similarity_frame(1, methods=("algorithm1/one-run",)).assign(total=0.8123)
    tex, md = laid_out(tmp_path, "table06", pd.concat([similarity_frame(), one], ignore_index=True))
    headings = re.findall(r"^\| \*\*(.*?)\*\*", md, flags=re.MULTILINE)
    assert headings[:2] == ["Algorithm 1", "Algorithm 1, one run"]
    assert "| Total τ₁ | 81.23 | 81.23 | 81.23 | 81.23 |" in md
    for text in (tex, md):
        assert "median of 5 seeds" in text
        assert "All cells of a block without ± have the same seed." in text.replace("$\\pm$", "±")
    _, alone = laid_out(tmp_path, "table06", similarity_frame())
    assert "without ±" not in alone


def test_description_tables(tmp_path: Path) -> None:
    tex, md = laid_out(tmp_path, "table02", TABLES["table02"]())
    assert "$m_{2}\\,l_{c2}^{2} + J_{2}$ & $\\mathrm{kg\\,m^{2}}$" in tex
    assert "| m₂ lc₂² + J₂ | kg·m² |" in md
    tex, md = laid_out(tmp_path, "table03", TABLES["table03"]())
    assert "$\\times$".join(("100", "100", "2")) in tex
    assert r"Rate \& loss\_1 & 50\% \#3 \\" in tex
    assert "| Rate & loss\\_1 | 50% #3 |" in md
    assert "8000" in tex
    tex, md = laid_out(tmp_path, "metric_search", search_frame())
    assert (md.count("time candidate"), md.count("frequency candidate")) == (10, 11)
    shown = "frequency candidate 17 | 1 - \\|x-y\\|²/\\|x\\|² | 2.000 | 4567 | 1.50 | 0.777 | 97.31 | yes |"
    assert f"| 18 | 17 to 21 | {shown}" in md
    assert r"$1 - \vert x-y\vert ^{2}/\vert x\vert ^{2}$" in tex
    tex, md = laid_out(tmp_path, "metric_motions", TABLES["metric_motions"]())
    assert "| 12000 | 30.0 | 10.5 | 100 | 0.885 to 3.22 | 6 | 0.502 | 0.897 | 0.355 | 0.435 | yes |" in md
    assert "| 3770 | 9.43 | 2.50 | 7.50 | 0.0140 to 0.787 | 8 | 1.649 | 1.268 | 1.417 | 1.537 |  |" in md
    assert r"$628$ & $1885$ & $2.0 \times 10^{8}$ & $0$ &" in tex


@pytest.mark.parametrize(
    ("name", "spoil", "words"),
    [
        ("table04", lambda f: f[:-1], "0 rows"),
        ("table04", lambda f: pd.concat([f, f[:1]]), "2 rows"),
        ("table06", lambda f: f.assign(seeds=range(len(f))), "one number of seeds"),
        ("table06", lambda f: f.assign(seeds=f["method"].map({"algorithm1": 3}).fillna(5)), "3, 5"),
        ("table06", lambda f: f.assign(seeds=f["case"].map({"N3": 1}).fillna(5)), "1, 5"),
        ("table07", lambda f: f[f["case"] != "N4"], "case N4"),
        ("table08", lambda f: pd.concat([f, f]), "2 rows"),
        ("table09", lambda f: f[1:], "0 rows"),
        ("verdict", lambda f: f.drop(index=4), "0 rows"),
    ],
)
def test_tables_name_what_is_wrong(
    name: str, spoil: Callable[[pd.DataFrame], pd.DataFrame], words: str, tmp_path: Path
) -> None:
    assert words in refused(laid_out, tmp_path, name, spoil(TABLES[name]()))
