"""Text and tables in LaTeX and Markdown: escaped, balanced, and a message that names what is wrong."""

import re

from exhibit_examples import TABLES, laid_out
from experiment_example import refused
from hypothesis import given
from hypothesis import strategies as st
from kept import same

from repro.drawing import markup


@given(st.text(st.characters(codec="ascii", categories=("L", "N", "P", "S", "Zs"))))
def test_text_is_escaped(text):
    tex = markup.plain(text).tex
    # What is left once every command and escape is taken away holds nothing that LaTeX would read as a command.
    words = r"\$\\times\$|\\text(backslash|asciitilde|asciicircum|less|greater|bar)\{\}|\\[{}$&%#_]"
    assert not set(re.sub(words, "", tex)) & set("\\{}$&%#_~^<>|")
    assert "|" not in re.sub(r"\\.", "", markup.plain(text).md)


@given(st.text("mlcx12 ()|^*+-/_%&#{}$<>~.", max_size=30))
def test_formulas_balance(text):
    made = markup.formula(text)
    bare = re.sub(r"\\[^A-Za-z]", "", made.tex)
    assert bare.count("{") == bare.count("}")
    assert bare.count("$") % 2 == 0
    assert not set("&%#_") & set(re.sub(r"_\{", "", bare)) - set("{")
    assert "|" not in re.sub(r"\\.", "", made.md)


def test_a_table_names_what_is_missing(tmp_path):
    frame = TABLES["table07"]()
    error = refused(laid_out, tmp_path, "table07", frame[frame["case"] != "N4"])
    assert "table07.csv" in error.place and "N4" in str(error)


def test_losses_of_interpretations_are_times_10000(tmp_path, file_regression):
    tex, md = laid_out(tmp_path, "ablation", TABLES["ablation"]())
    assert "| as configured | 40000 | 1.25 |" in md
    file_regression.check(f"{tex}\n{md}", check_fn=same, basename="ablation")


def test_formulas_within_sentences(tmp_path):
    finding = TABLES["audit"]().iloc[:1].assign(arithmetic="I3 - lambda_R1^max >= -2 x 10^-3 m^2 & 5 %, g_f -> exp(x)")
    tex, md = laid_out(tmp_path, "audit", finding)
    assert r"$I_{3}$ $-$ $\lambda _{R1}^{\max}$ $\geq$ $-$2 $\times$ 10$^{-3}$ m$^{2}$ \& 5 \%," in tex
    assert r", $g_{f}$ $\rightarrow$ exp(x) &" in tex
    assert "| I₃ - λ\\_R1^max ≥ -2 \N{MULTIPLICATION SIGN} 10⁻³ m² & 5 %, g\\_f → exp(x) |" in md
