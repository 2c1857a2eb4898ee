"""Figures and tables: what is drawn is what the CSV holds, whole, readable and the same every time."""

import itertools
import os
import re
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from repro.errors import InputError
from repro.model.parameters import DESCRIPTIONS, EXPRESSIONS, NAMES, UNITS
from repro.render import markup, style
from repro.render.figures import FIGURES, draw
from repro.render.tables import LAYOUTS, lay_out

CASES = ("N1", "N2", "N3", "N4")
METHODS = ("algorithm1+refinement+scale-aware", "algorithm1+refinement", "a further_one", "algorithm1")


def long_table(panels: dict[str, tuple[str, ...]], x: np.ndarray, y: Callable[[int], np.ndarray]) -> pd.DataFrame:
    rows = [(panel, name) for panel, series in panels.items() for name in series]
    frames = [pd.DataFrame({"panel": p, "series": s, "x": x, "y": y(i)}) for i, (p, s) in enumerate(rows)]
    return pd.concat(frames, ignore_index=True)


def waves(panels: dict[str, tuple[str, ...]], n: int = 60) -> pd.DataFrame:
    t = np.linspace(0.0, 9.4, n)
    return long_table(panels, t, lambda i: np.sin(t + 0.3 * i) * (1 + i))


def bands(panels: dict[str, tuple[str, ...]]) -> pd.DataFrame:
    k = np.arange(200.0)
    return long_table(panels, k / 18.85, lambda i: 30.0 * np.cos(k + i) * np.exp(-k / 8))


def case_panels(*cases: str) -> dict[str, tuple[str, ...]]:
    return {f"{case}/joint{joint}": ("actual", "rebuilt") for case in cases for joint in (1, 2)}


def subsampling_frame() -> pd.DataFrame:
    t = np.arange(64.0)
    parts = {("signal", "x"): t / 10, ("spectrum", "kept"): t[:16], ("spectrum", "dropped"): t[16:]}
    parts[("subsampled", "xs")] = t[:16] * 0.4
    frames = [pd.DataFrame({"panel": p, "series": s, "x": x, "y": np.cos(x)}) for (p, s), x in parts.items()]
    return pd.concat(frames, ignore_index=True)


def network_frame() -> pd.DataFrame:
    rows = [
        ("input", "input", 100, 100, 2, "", 0),
        ("conv1", "convolution", 92, 92, 10, "9x9x2x10", 1630),
        ("pool1", "max pool", 46, 46, 10, "2x2", 0),
        ("conv2", "convolution", 42, 42, 10, "5x5x10x10", 2510),
        ("pool2", "max pool", 21, 21, 10, "2x2", 0),
        ("conv3", "convolution", 19, 19, 10, "3x3x10x10", 910),
        ("fc4", "fully connected", 1, 1, 100, "", 361100),
        ("fc5", "fully connected", 1, 1, 50, "", 5050),
        ("output", "output", 1, 1, 9, "", 459),
    ]
    return pd.DataFrame(rows, columns=["layer", "kind", "height", "width", "channels", "kernel", "parameters"])


def index_frame(shape: dict[str, int]) -> pd.DataFrame:
    return pd.DataFrame(itertools.product(*(range(n) for n in shape.values())), columns=list(shape))


def examples_frame() -> pd.DataFrame:
    pixels = index_frame({"row": 12, "column": 12})
    shade = (pixels["row"] * 12 + pixels["column"]) / 143
    pixels = pixels.assign(red=shade, green=1 - shade, blue=0.5)
    return pd.concat([pixels.assign(kind=k, image=i) for k in ("Mp", "Mn") for i in "abcdefghi"], ignore_index=True)


def kernels_frame() -> pd.DataFrame:
    frames = []
    for layer, size, inputs in (("conv1", 9, 2), ("conv2", 5, 10), ("conv3", 3, 10)):
        frame = index_frame({"input": inputs, "output": 10, "row": size, "column": size}).assign(layer=layer)
        frames.append(frame.assign(power=np.linspace(0.0, 1.0, len(frame))))
    return pd.concat(frames, ignore_index=True)


def candidates_frame() -> pd.DataFrame:
    rows = [
        (factor, f"{factor} candidate {i}", 0.3 + 0.1 * i, i == chosen)
        for factor, chosen in (("time", 1), ("frequency", 17))
        for i in range(20)
    ]
    return pd.DataFrame(rows, columns=["factor", "candidate", "rms_log_error", "chosen"])


MOTION = dict.fromkeys(("position", "velocity", "acceleration"), ("joint1", "joint2"))

FRAMES: dict[str, Callable[[], pd.DataFrame]] = {
    "fig05": subsampling_frame,
    "fig06": lambda: waves(MOTION),
    "fig07": network_frame,
    "fig08": examples_frame,
    "fig09": lambda: waves(dict.fromkeys(("joint1", "joint2"), ("p05", "p25", "p50", "p75", "p95", "mean"))),
    "fig10": lambda: waves({"loss": ("train", "test")}).assign(y=lambda f: np.exp(-f["x"])),
    "fig11": kernels_frame,
    "fig12": lambda: waves(case_panels("N1", "N2")),
    "fig13": lambda: waves(case_panels("N3", "N4")),
    "fig14": lambda: bands(case_panels(*CASES)),
    "fig15": lambda: waves(case_panels(*CASES), 600),
    "fig16": lambda: waves(MOTION, 600),
    "fig17": lambda: bands(case_panels(*CASES)).assign(y=lambda f: np.sin(7 * f["x"])),
    "metric_search": candidates_frame,
}


def parameters_frame(cases: tuple[str, ...]) -> pd.DataFrame:
    rows = [
        (case, method, name, unit, 0.1 + 0.01 * i, 0.2 + 0.0101 * i, 0.003)
        for i, (method, case, (name, unit)) in enumerate(
            itertools.product(METHODS, cases, zip(NAMES, UNITS, strict=True))
        )
    ]
    return pd.DataFrame(rows, columns=["case", "method", "parameter", "unit", "true", "estimate", "estimate_sd"])


def similarity_frame(seeds: int = 5) -> pd.DataFrame:
    rows = [
        (case, method, joint, 0.99 - i * 1e-4, 0.98 - i * 1e-4, 0.97 - i * 1e-4, 0.0042, seeds)
        for i, (method, case, joint) in enumerate(itertools.product(METHODS, CASES, (1, 2)))
    ]
    columns = ["case", "method", "joint", "time", "frequency", "total", "total_sd", "seeds"]
    return pd.DataFrame(rows, columns=columns)


def search_frame() -> pd.DataFrame:
    frame = candidates_frame()
    rank = frame.groupby("factor").cumcount() + 1
    return frame.rename(columns={"rms_log_error": "rms_log_error_best"}).assign(
        formula="1 - |x-y|^2/|x|^2", rms_log_error_mean=0.777, best_bandwidth=1.5, rank=rank, abstract_mean_total=0.9731
    )


TABLES: dict[str, Callable[[], pd.DataFrame]] = {
    "table02": lambda: pd.DataFrame(
        {"parameter": NAMES, "description": DESCRIPTIONS, "expression": EXPRESSIONS, "unit": UNITS}
    ),
    "table03": lambda: pd.DataFrame(
        {"feature": ["Input", "Rate & loss_1", "Images"], "value": ["100 x 100 x 2", "50% #3", 8000]}
    ),
    "table04": lambda: parameters_frame(("N1", "N2")),
    "table05": lambda: parameters_frame(("N3", "N4")),
    "table06": similarity_frame,
    "table07": similarity_frame,
    "metric_search": search_frame,
}


def written(folder: Path, name: str, frame: pd.DataFrame) -> Path:
    path = folder / f"{name}.csv"
    frame.to_csv(path, index=False)
    return path


def drawn(folder: Path, name: str, frame: pd.DataFrame) -> tuple[bytes, bytes]:
    pdf, png = folder / f"{name}.pdf", folder / f"{name}.png"
    draw(name, written(folder, name, frame), pdf, png)
    return pdf.read_bytes(), png.read_bytes()


def laid_out(folder: Path, name: str, frame: pd.DataFrame) -> tuple[str, str]:
    tex, md = folder / f"{name}.tex", folder / f"{name}.md"
    lay_out(name, written(folder, name, frame), tex, md)
    return tex.read_text(encoding="utf-8"), md.read_text(encoding="utf-8")


def refused(act: Callable[[Path, str, pd.DataFrame], object], folder: Path, name: str, frame: pd.DataFrame) -> str:
    with pytest.raises(InputError) as caught:
        act(folder, name, frame)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert f"{name}.csv" in message
    assert "found" in message
    assert "expected" in message
    return message


@pytest.fixture(params=list(FIGURES))
def figure(request: pytest.FixtureRequest) -> Iterator[Figure]:
    with style.house_style():
        made = FIGURES[request.param](FRAMES[request.param]())
        FigureCanvasAgg(made).draw()
        made.set_label(request.param)
        yield made


def shown_texts(figure: Figure) -> list[tuple[Text, Bbox]]:
    """Every text that can be seen, with its box; ticks outside the view are not drawn."""
    hidden = set()
    for axes in figure.findobj(mpl.axes.Axes):
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not low - 1e-9 <= tick.get_loc() <= high + 1e-9 or not axes.axison:
                    hidden |= {tick.label1, tick.label2}
    texts = [t for t in figure.findobj(Text) if t.get_text().strip() and t.get_visible() and t not in hidden]
    axes_off = [a for a in figure.findobj(mpl.axes.Axes) if not a.axison]
    labels_off = {label for a in axes_off for label in (a.xaxis.label, a.yaxis.label)}
    return [(t, Text.get_window_extent(t)) for t in texts if t not in labels_off and t.figure is not None]


def test_every_figure_has_an_example() -> None:
    assert set(FRAMES) == set(FIGURES)
    assert set(TABLES) == set(LAYOUTS)


@pytest.mark.parametrize("name", list(FIGURES))
def test_figure_files_are_whole_and_the_same_twice(name: str, tmp_path: Path) -> None:
    first = drawn(tmp_path, name, FRAMES[name]())
    with mpl.rc_context({"font.size": 20.0, "axes.edgecolor": "red", "savefig.transparent": True}):
        second = drawn(tmp_path, name, FRAMES[name]())
        assert mpl.rcParams["axes.edgecolor"] == "red"
    assert first == second
    pdf, png = first
    assert pdf.startswith(b"%PDF")
    assert b"CreationDate" not in pdf
    width, height = struct.unpack(">II", png[16:24])
    assert width in (1050, 2148)
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", pdf)
    assert box is not None
    assert float(box[1]) / 72 == pytest.approx(width / 300, abs=0.01)
    assert float(box[2]) / 72 == pytest.approx(height / 300, abs=0.01)


def test_bytes_do_not_depend_on_the_process(tmp_path: Path) -> None:
    name = "fig12"
    here = drawn(tmp_path, name, FRAMES[name]())
    code = (
        "import sys; from pathlib import Path; from repro.render.figures import draw;"
        "draw(sys.argv[1], *(Path(p) for p in sys.argv[2:]))"
    )
    paths = [str(tmp_path / file) for file in (f"{name}.csv", "other.pdf", "other.png")]
    subprocess.run([sys.executable, "-c", code, name, *paths], check=True, env={**os.environ, "PYTHONHASHSEED": "7"})
    assert here == tuple((tmp_path / f"other.{kind}").read_bytes() for kind in ("pdf", "png"))


def test_nothing_is_clipped_small_or_overlapping(figure: Figure) -> None:
    assert figure.get_size_inches()[0] in (3.5, 7.16)
    whole = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    assert whole.x0 > -0.01
    assert whole.y0 > -0.01
    assert whole.x1 < width + 0.01
    assert whole.y1 < height + 0.01
    texts = shown_texts(figure)
    assert len(texts) > 4
    for text, box in texts:
        assert text.get_fontsize() >= 7.0, text.get_text()
        assert box.x0 >= 0 <= box.y0, text.get_text()
        assert box.x1 <= figure.bbox.x1, text.get_text()
        assert box.y1 <= figure.bbox.y1, text.get_text()
    for (one, box), (other, second) in itertools.combinations(texts, 2):
        common = Bbox.intersection(box, second)
        overlap = common is not None and min(common.width, common.height) > 1.0
        assert not overlap, (one.get_text(), other.get_text())


def test_axis_labels_carry_a_unit(figure: Figure) -> None:
    axes = [a for a in figure.findobj(mpl.axes.Axes) if a.axison]
    labels = [label for a in axes for label in (a.get_xlabel(), a.get_ylabel()) if label]
    for part in (figure, *figure.subfigs):
        labels += [word for word in (part.get_supxlabel(), part.get_supylabel()) if word and "Not shown" not in word]
    assert all(re.search(r"\([^()]+\)$", label) for label in labels)
    assert len(labels) >= 2 or figure.get_label() == "fig07"


def test_pairs_that_meet_differ_in_greyscale() -> None:
    def lightness(name: str) -> float:
        return float(np.dot(to_rgb(style.STROKES[name]["color"]), (0.299, 0.587, 0.114)))

    for one, other in (("joint1", "joint2"), ("actual", "rebuilt"), ("train", "test"), ("median", "mean")):
        assert abs(lightness(one) - lightness(other)) > 0.2
        first, second = style.STROKES[one], style.STROKES[other]
        assert (first["linestyle"], first["linewidth"]) != (second["linestyle"], second["linewidth"])


def test_curves_are_the_numbers_given() -> None:
    frame = FRAMES["fig12"]().sample(frac=1.0, random_state=0).sort_values(["panel", "x"], kind="stable")
    with style.house_style():
        made = FIGURES["fig12"](frame)
    panels = dict(zip(case_panels("N1", "N2"), made.axes, strict=True))
    for (panel, name), rows in frame.groupby(["panel", "series"]):
        line = panels[panel].lines[("actual", "rebuilt").index(name)]
        np.testing.assert_array_equal(line.get_xdata(), rows["x"])
        np.testing.assert_array_equal(line.get_ydata(), rows["y"])


def test_spectrum_says_what_it_leaves_out() -> None:
    frame = FRAMES["fig14"]()
    with style.house_style():
        made = FIGURES["fig14"](frame)
    left_out = re.search(r"Not shown: ([\d.]+) to ([\d.]+) Hz", made.get_supxlabel())
    assert left_out is not None
    assert float(left_out[2]) == pytest.approx(frame["x"].max(), rel=1e-2)
    beyond = frame[frame["x"] > float(left_out[1]) * 1.01]
    largest = frame["y"].abs().groupby(frame["panel"]).max()
    assert (beyond["y"].abs() < 0.05 * beyond["panel"].map(largest)).all()
    with style.house_style():
        assert FIGURES["fig17"](FRAMES["fig17"]()).get_supxlabel() == ""


def test_kernels_stand_at_their_maps() -> None:
    frame = kernels_frame()
    with style.house_style():
        made = FIGURES["fig11"](frame)
    picture = made.axes[0].images[0]
    array, (left, right, bottom, top) = np.ma.getdata(picture.get_array()), picture.get_extent()
    one = frame.query("layer == 'conv1' and input == 1 and output == 7 and row == 4 and column == 4")["power"].item()
    row = int((7 - top) / (bottom - top) * array.shape[0])
    column = int((1 - left) / (right - left) * array.shape[1])
    assert array[row, column] == pytest.approx(one)


def test_a_chosen_candidate_is_shown_whatever_its_rank() -> None:
    with style.house_style():
        made = FIGURES["metric_search"](candidates_frame())
    names = [[tick.get_text() for tick in axes.get_yticklabels()] for axes in made.axes]
    assert [len(shown) for shown in names] == [12, 13]
    assert names[1][-1] == "frequency candidate 17"


def test_long_lines_stay_light(tmp_path: Path) -> None:
    t = np.arange(3770) * 2.5e-3
    frame = long_table(case_panels("N1", "N2"), t, lambda i: np.sin(t + i))
    pdf, _ = drawn(tmp_path, "fig12", frame)
    assert len(pdf) < 60_000


@pytest.mark.parametrize("name", list(FIGURES))
def test_figures_refuse_a_wrong_table(name: str, tmp_path: Path) -> None:
    frame = FRAMES[name]()
    for column in frame.columns:
        assert column in refused(drawn, tmp_path, name, frame.drop(columns=column))
    refused(drawn, tmp_path, name, frame.iloc[:0])
    numbers = [c for c in frame.columns if pd.api.types.is_float_dtype(frame[c])] or ["height"]
    for wrong in (None, np.inf, "many"):
        spoilt = frame.astype({numbers[0]: object})
        spoilt.loc[3, numbers[0]] = wrong
        assert f"line 5: {numbers[0]}" in refused(drawn, tmp_path, name, spoilt)


@pytest.mark.parametrize(
    ("name", "spoil", "words"),
    [
        ("fig06", lambda f: f.replace({"panel": {"velocity": "speed"}}), "'speed'"),
        ("fig06", lambda f: f[f["panel"] != "velocity"], "'velocity'"),
        ("fig12", lambda f: f.replace({"series": {"actual": "true"}}), "'true'"),
        ("fig12", lambda f: f.replace({"panel": {"N1/joint1": "N9/joint1"}}), "'N9/joint1'"),
        ("fig12", lambda f: f.iloc[::-1], "rise"),
        ("fig12", lambda f: f.drop(index=range(1, 60)), "1 point"),
        ("fig10", lambda f: f.assign(y=-1.0), "above 0"),
        ("fig09", lambda f: f.drop(index=3), "times"),
        ("fig05", lambda f: f.replace({"series": {"kept": "dropped", "dropped": "kept"}}), "band"),
        ("fig07", lambda f: f.replace({"layer": {"conv2": "conv9"}}), "'conv9'"),
        ("fig07", lambda f: f.replace({"kernel": {"2x2": "two"}}), "'two'"),
        ("fig07", lambda f: pd.concat([f, f.iloc[:1]]), "10 rows"),
        ("fig07", lambda f: f.assign(height=0), "at least 1"),
        ("fig08", lambda f: f.assign(red=1.5), "between 0 and 1"),
        ("fig08", lambda f: f.drop(index=7), "144"),
        ("fig08", lambda f: f[f["image"] != "i"], "'i'"),
        ("fig08", lambda f: f.assign(row=f["row"] + 0.5), "whole numbers"),
        ("fig11", lambda f: pd.concat([f, f.iloc[:1]]), "each index once"),
        ("fig11", lambda f: f.assign(power=2.0), "between 0 and 1"),
        ("metric_search", lambda f: f.assign(chosen="perhaps"), "'perhaps'"),
        ("metric_search", lambda f: f.assign(factor=None), "text"),
    ],
)
def test_figures_name_what_is_wrong(
    name: str, spoil: Callable[[pd.DataFrame], pd.DataFrame], words: str, tmp_path: Path
) -> None:
    assert words in refused(drawn, tmp_path, name, spoil(FRAMES[name]()))


def test_unknown_names_and_missing_files(tmp_path: Path) -> None:
    nowhere = tmp_path / "nowhere.csv"
    with pytest.raises(InputError, match="fig99"):
        draw("fig99", nowhere, tmp_path / "a.pdf", tmp_path / "a.png")
    with pytest.raises(InputError, match="nowhere"):
        draw("fig06", nowhere, tmp_path / "a.pdf", tmp_path / "a.png")
    with pytest.raises(InputError, match="table99"):
        lay_out("table99", nowhere, tmp_path / "a.tex", tmp_path / "a.md")
    with pytest.raises(InputError, match="nowhere"):
        lay_out("table02", nowhere, tmp_path / "a.tex", tmp_path / "a.md")
    assert not list(tmp_path.iterdir())
    with pytest.raises(ValueError, match="width"):
        style.new_figure(5.0, 2.0)


@pytest.mark.parametrize("name", list(LAYOUTS))
def test_tables_are_well_formed(name: str, tmp_path: Path) -> None:
    tex, md = laid_out(tmp_path, name, TABLES[name]())
    assert laid_out(tmp_path, name, TABLES[name]()) == (tex, md)
    bare = re.sub(r"\\.", "", tex)
    assert bare.count("{") == bare.count("}")
    assert bare.count("$") % 2 == 0
    for part in (
        r"\begin{table*}",
        r"\caption{",
        rf"\label{{tab:{name}}}",
        r"\toprule",
        r"\bottomrule",
        r"\end{table*}",
    ):
        assert tex.count(part) == 1
    columns = re.search(r"\\begin\{tabular\}\{@\{\}(\w+)@\{\}\}", tex)
    assert columns is not None
    for line in tex.splitlines():
        if line.endswith(r"\\") and "multicolumn" not in line:
            assert len(re.findall(r"(?<!\\)&", line)) == len(columns[1]) - 1
    rows = [line for line in md.splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {len(columns[1]) + 1}


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
        "Algorithm 1 + refinement + scale-aware image",
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
    assert md.count("candidate") == 10 + 11 + 1  # the caption says it once
    assert "| 18 | frequency candidate 17 | 1 - \\|x-y\\|²/\\|x\\|² | 2.000 | 1.5 | 0.777 | 97.31 | yes |" in md
    assert r"$1 - \vert x-y\vert ^{2}/\vert x\vert ^{2}$" in tex


@pytest.mark.parametrize("name", list(LAYOUTS))
def test_tables_refuse_a_wrong_table(name: str, tmp_path: Path) -> None:
    frame = TABLES[name]()
    for column in frame.columns:
        assert column in refused(laid_out, tmp_path, name, frame.drop(columns=column))
        spoilt = frame.astype({column: object})
        spoilt.loc[2, column] = None
        assert f"line 4: {column}" in refused(laid_out, tmp_path, name, spoilt)
    refused(laid_out, tmp_path, name, frame.iloc[:0])


@pytest.mark.parametrize(
    ("name", "spoil", "words"),
    [
        ("table04", lambda f: f[:-1], "0 rows"),
        ("table04", lambda f: pd.concat([f, f[:1]]), "2 rows"),
        ("table05", lambda f: f.replace({"case": {"N3": "N1"}}), "'N1'"),
        ("table05", lambda f: f.assign(estimate_sd=-0.1), "0 or more"),
        ("table06", lambda f: f.assign(total=97.1), "fraction of 1"),
        ("table06", lambda f: f.assign(seeds=range(len(f))), "one number of seeds"),
        ("table07", lambda f: f.assign(joint=f["joint"] + 1), "'3'"),
        ("table07", lambda f: f[f["case"] != "N4"], "'N4'"),
    ],
)
def test_tables_name_what_is_wrong(
    name: str, spoil: Callable[[pd.DataFrame], pd.DataFrame], words: str, tmp_path: Path
) -> None:
    assert words in refused(laid_out, tmp_path, name, spoil(TABLES[name]()))


@given(st.text(st.characters(codec="ascii", categories=("L", "N", "P", "S", "Zs"))))
def test_text_is_escaped(text: str) -> None:
    tex = markup.plain(text).tex
    # What is left once every command and escape is taken away holds nothing that LaTeX would read as a command.
    words = r"\$\\times\$|\\text(backslash|asciitilde|asciicircum|less|greater|bar)\{\}|\\[{}$&%#_]"
    assert not set(re.sub(words, "", tex)) & set("\\{}$&%#_~^<>|")
    assert "|" not in re.sub(r"\\.", "", markup.plain(text).md)


@given(st.text("mlcx12 ()|^*+-/_%&#{}$<>~.", max_size=30))
def test_formulas_balance(text: str) -> None:
    made = markup.formula(text)
    bare = re.sub(r"\\[^A-Za-z]", "", made.tex)
    assert bare.count("{") == bare.count("}")
    assert bare.count("$") % 2 == 0
    assert not set("&%#_") & set(re.sub(r"_\{", "", bare)) - set("{")
    assert "|" not in re.sub(r"\\.", "", made.md)


def test_markup_of_formulas_and_units() -> None:
    assert markup.formula("tau1") == markup.Text(r"$\tau_{1}$", "τ₁")
    assert markup.formula("beta").tex == r"$\beta $"
    assert markup.formula("sqrt(x)^0.4").tex == r"$\mathrm{sqrt}(x)^{0.4}$"
    assert markup.formula("x^p").md == "x^p"
    assert markup.formula("||x - y||^2").tex == r"$\vert \vert x - y\vert \vert ^{2}$"
    assert markup.formula("|x|_1") == markup.Text(r"$\vert x\vert _{1}$", r"\|x\|₁")
    remark = markup.formula("corr(x, y), in the signal's unit")
    assert remark.tex == r"$\mathrm{corr}(x,\,y)$, in the signal's unit"
    assert markup.unit("1").md == "\N{EN DASH}"
    assert markup.unit("N m").md == "N·m"
    assert markup.number(-0.12345, 4).md == "-0.1235"
