"""Every figure and table: what is drawn is whole, readable, and the same every time."""

import io
import itertools
import re
import struct

import exhibit_examples as examples
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.transforms import Bbox
from PIL import Image

from repro.drawing import style

pytestmark = pytest.mark.slow

#: Its results take longer than a run.
NOT_KEPT = "ablation"
#: Percent of all brightness: rounding moves a few pixels by a level; a line a tenth wider moves hundreds by tens.
A_LEVEL = 2e-3


@pytest.fixture(scope="module", params=list(examples.FIGURES))
def figure(request):
    """Each figure, drawn once, at the resolution of its PNG."""
    made = examples.made(request.param, examples.figure_numbers(request.param))
    made.set_dpi(style.PNG_DPI)
    with style.house_style():
        FigureCanvasAgg(made).draw()
    made.set_label(request.param)
    return made


def test_figures_look_as_they_did(figure, image_regression):
    small = io.BytesIO()
    Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB").reduce(4).save(small, "png", optimize=True)
    image_regression.check(small.getvalue(), diff_threshold=A_LEVEL, basename=f"look-{figure.get_label()}")


# Two of them, one for each width: they share one style, and CI compares all figures of two runs of the workflow.
@pytest.mark.parametrize(("name", "width"), [("fig10", 1050), ("fig20", 2148)])
def test_files_of_figures_are_whole_and_the_same_under_any_settings(name, width, tmp_path):
    pdf, png = examples.drawn(tmp_path, name, examples.figure_numbers(name))
    with mpl.rc_context({"font.size": 20.0, "axes.edgecolor": "red", "savefig.transparent": True}):
        assert examples.drawn(tmp_path, name, examples.figure_numbers(name)) == (pdf, png)
        assert mpl.rcParams["axes.edgecolor"] == "red"
    assert pdf.startswith(b"%PDF") and b"CreationDate" not in pdf
    size = struct.unpack(">II", png[16:24])
    assert size[0] == width
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", pdf)
    assert [float(points) / 72 for points in box.groups()] == pytest.approx(np.array(size) / 300, abs=0.01)


def test_words_are_whole_large_and_apart_and_say_what_is_simulated(figure):
    assert figure.get_size_inches()[0] in (3.5, 7.16)
    whole = figure.get_tightbbox()
    assert min(whole.min) > -0.01 and (whole.max < figure.get_size_inches() + 0.01).all()
    texts = examples.shown_texts(figure)
    assert len(texts) > 4
    words = " ".join(text.get_text() for text, _ in texts).lower()
    assert ("simulated" in words) == examples.EXHIBITS["figure", figure.get_label()].simulated
    for text, box in texts:
        assert text.get_fontsize() >= 7.0, text.get_text()
        assert (box.min >= 0).all() and (box.max <= figure.bbox.max).all(), text.get_text()
    for (one, box), (other, second) in itertools.combinations(texts, 2):
        common = Bbox.intersection(box, second)
        overlap = common is not None and min(common.width, common.height) > 0.01 * figure.dpi
        assert not overlap, (one.get_text(), other.get_text())


def test_axis_labels_carry_a_unit(figure):
    axes = [a for a in figure.findobj(mpl.axes.Axes) if a.axison]
    labels = [label for a in axes for label in (a.get_xlabel(), a.get_ylabel()) if label]
    for part in (figure, *figure.subfigs):
        labels += [word for word in (part.get_supxlabel(), part.get_supylabel()) if word and "Not shown" not in word]
    assert all(re.search(r"\([^()]+\)$", label) for label in labels)
    assert len(labels) >= 2 or figure.get_label() in examples.WITHOUT_AXES


@pytest.mark.parametrize("name", list(examples.LAYOUTS))
def test_tables_are_well_formed_and_laid_out_as_the_reference_keeps_them(name, tmp_path):
    tex, md = examples.laid_out(tmp_path, name, examples.TABLES[name]())
    for kind, text in (("tex", tex), ("md", md)):
        assert name == NOT_KEPT or text == (examples.REFERENCE / f"{name}.{kind}").read_text(encoding="utf-8")
    bare = re.sub(r"\\.", "", tex)
    assert bare.count("{") == bare.count("}")
    assert bare.count("$") % 2 == 0
    kind = "longtable" if name in examples.LONG else "table*"
    parts = (rf"\begin{{{kind}}}", r"\caption{", rf"\label{{tab:{name}}}", r"\bottomrule", rf"\end{{{kind}}}")
    assert [tex.count(part) for part in parts] == [1] * 5
    assert tex.count(r"\toprule") == (2 if name in examples.LONG else 1)  # again on every further page
    if name in examples.LONG:
        columns = re.findall(r">\{\\raggedright\\arraybackslash\}p\{[\d.]+in\}", tex)
    else:
        columns = list(re.findall(r"\\begin\{tabular\}\{@\{\}(\w+)@\{\}\}", tex)[0])
    for line in tex.splitlines():
        if re.search(r" \\\\(\[2pt\])?$", line) and "multicolumn" not in line:
            assert len(re.findall(r"(?<!\\)&", line)) == len(columns) - 1
    rows = [line for line in md.splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {len(columns) + 1}
