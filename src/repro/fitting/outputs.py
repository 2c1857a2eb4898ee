"""Write the files of a result; the report is one HTML text that opens anywhere and fetches nothing."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from markupsafe import Markup, escape

from repro.drawing.embed import embedded, environment, policy
from repro.drawing.markup import unit
from repro.files import fill_folder, finite, write_csv, write_json, write_text
from repro.fingerprint import fingerprint
from repro.fitting import tables, text
from repro.fitting.export import horizontal_links_of, links_of, mjcf, urdf
from repro.fitting.figures import figures_of
from repro.fitting.recommend import unusable
from repro.fitting.result import MJCF_FILE, URDF_FILE, Curves, Result
from repro.identification.armfile import Arm
from repro.identification.extra_terms import ROTOR
from repro.provenance import write_provenance

METHODS_FILE = Path(__file__).with_name("methods.bib")  # BibTeX entries of the methods
KEYS = {"calibration_errors": "setup", "calibration_limits": "hidden"}  # of `parameters.json`, by field of a result
OPTIONAL = {URDF_FILE, MJCF_FILE, "no-links.txt", "runs.csv"}  # files that are written or not, as the result has it

#: BibTeX keys of the intervals, and of the solvers of some methods.
INTERVALS = ("kunsch1989jackknife", "kott2001delete", "jcgm2008gum", "baranchik1970family", "cook1994simex")
SOLVERS = {
    "consistent": ("goulart2024clarabel",),
    "weighted-consistent": ("goulart2024clarabel",),
    "parsimonious": ("goulart2024clarabel",),
    "algorithm1+refinement": ("storn1997differential",),
}


def write_result(out: Path, result: Result, curves: Curves, arm: Arm, inputs: Iterable[Path] = ()) -> list[str]:
    """Write every file of a result, or none; no input is replaced."""
    return fill_folder(out, lambda folder: _write_files(folder, result, curves, arm), OPTIONAL, inputs)


def _write_files(folder: Path, result: Result, curves: Curves, arm: Arm) -> None:
    write_json(folder / "parameters.json", finite(as_json(result)))
    write_csv(folder / "parameters.csv", tables.parameters_table(result))
    write_csv(folder / "scores.csv", tables.scores_table(result))
    write_csv(folder / "residuals.csv", tables.residuals_table(result, curves))
    if result.spread:
        write_csv(folder / "runs.csv", tables.runs_table(result))
    write_text(folder / "methods.bib", bibtex(citations(result)))
    _write_links(folder, result, arm)
    names = sorted(path.name for path in folder.iterdir())
    write_text(folder / "report.html", render_page(result, curves, figures_of(result, curves), names))
    write_provenance(folder / "provenance.json", Path(__file__).parent, 1, fingerprint())


def as_json(result: Result) -> dict[str, Any]:
    """Convert a result to the form of ``parameters.json``."""
    return {KEYS.get(field, field): value for field, value in asdict(result).items()}


def citations(result: Result) -> list[str]:
    """List the BibTeX keys of everything that a result relies on."""
    keys = ["cnn_identification"]
    for method in result.methods:
        keys += [method.citation, *SOLVERS.get(method.method, ())]
    if any(method.claims_intervals for method in result.methods):
        keys += INTERVALS
    if result.preparation.filter.startswith("Savitzky"):
        keys.append("savitzky1964smoothing")
    return list(dict.fromkeys(keys))


def entries() -> dict[str, str]:
    """Read every entry of ``methods.bib``, by key in the order of the file."""
    # An entry starts with @type{key, in the first column and ends with the next brace there.
    text = METHODS_FILE.read_text(encoding="utf-8")
    return {m[1]: m[0] for m in re.finditer(r"^@\w+\{([^,\s]+),.*?^\}", text, re.DOTALL | re.MULTILINE)}


def bibtex(keys: Sequence[str]) -> str:
    """Write the entries of some keys."""
    known = entries()
    return "".join(f"{known[key]}\n\n" for key in dict.fromkeys(keys)).removesuffix("\n")


def _write_links(folder: Path, result: Result, arm: Arm) -> None:
    """Write URDF and MJCF if a set of two links has these parameters, else a file with the reason."""
    unknown = [p.name for p in result.best.parameters[:5] if p.verdict in (text.NOT_EXCITED, text.COMBINED)]
    beta = np.array([p.estimate for p in result.best.parameters])
    reason = f"The motion does not determine {', '.join(unknown)}, which masses and lengths depend on."
    if not unknown:
        try:
            if arm.plane == "horizontal":
                links = horizontal_links_of(beta, arm.link_lengths)
            else:
                links = links_of(beta, arm.gravity, arm.link_lengths)
        except ValueError as error:
            reason = f"No two links have these parameters. {error}"
        else:
            links = replace(links, rotor=sum(t.value for t in result.terms if t.taken and t.kind == ROTOR))
            if vague := text.by_verdict(result.best.parameters).get(text.NOT_FROM_ZERO):
                links = replace(links, notes=(f"{', '.join(vague)} {text.NOT_FROM_ZERO} in this log", *links.notes))
            if poor := unusable(result.best):
                links = replace(links, notes=(f"DO NOT USE: {poor}", *links.notes))
            for name, export in ((URDF_FILE, urdf), (MJCF_FILE, mjcf)):
                notes = [line for line in text.export_lines(result) if name in line.partition(" omit")[0]]
                write_text(folder / name, export(replace(links, notes=(*links.notes, *notes)), result.arm))
            return
    write_text(folder / "no-links.txt", f"No URDF or MJCF. {reason}\n")


#: Contents of the files next to the page.
FILES = {
    "parameters.json": "everything on this page, for programs",
    "parameters.csv": "the parameters of every method, a row each",
    "runs.csv": "the parameters from each log alone, a row each, with their range",
    "residuals.csv": "measured and rebuilt torque over time",
    "scores.csv": "the errors of every method on every log, a row each",
    URDF_FILE: "two links with these inertias, for ROS and most simulators",
    MJCF_FILE: "the same links for MuJoCo",
    "no-links.txt": "why there is no URDF or MJCF",
    "methods.bib": "sources of the methods, to cite",
}

_SHOWN = 1.25 * 96.0 / 200.0  # screen pixels per picture pixel: drawn at 200 dpi, shown at 1.25 times the printed size
_SYMBOL = re.compile(r"\b([Igbk])([123])\b")  # a parameter's name in a text
_NAME = re.compile(r"\w+\.\w|(q|tau)\d\b")  # a file or a signal at the beginning of a text


def render_page(
    result: Result, curves: Curves, figures: Mapping[str, bytes], files: Sequence[str] = tuple(FILES)
) -> str:
    """Lay out the report, the recommended method before the others."""
    best = result.best
    result = replace(result, methods=(best, *(method for method in result.methods if method is not best)))
    package, logs = Path(__file__).parent, (*result.fitted_logs, *result.validation_logs)
    facts = dict.fromkeys(name for log in logs for name, _ in log.facts)
    # The styles of the reproduction's report, then those of this page.
    paths = (package.parent / "report" / "report.css", package / "page.css")
    style = Markup("".join(path.read_text(encoding="utf-8") for path in paths))
    jinja = environment(package)
    texts = (symbols, sentence, text.term_line, text.self_test_rows, text.self_test_verdict, text.spread_rows)
    functions = (*texts, tables.rounded, tables.percent, tables.significant)
    jinja.filters |= {function.__name__: function for function in functions} | {"unit": lambda text: unit(text).md}
    return jinja.get_template("page.html").render(
        result=result,
        best=best,
        style=style,
        policy=policy(style),
        logs=logs,
        fitted=len(result.fitted_logs),
        export_lines=text.export_lines(result),
        verdicts=text.by_verdict(best.parameters),
        detection_limits=text.detection_limits(result),
        facts=[(name, [dict(log.facts).get(name, "") for log in logs]) for name in facts],
        predictions=tables.predictions(best),
        blocks=tables.blocks(result),
        pictures={name: embedded(content, _SHOWN) for name, content in figures.items()},
        overlays=sum(name.startswith("overlay-") for name in figures),
        lengths=[(float(signals.t[-1] - signals.t[0]), signals.t.size) for signals in curves.signals],
        allowed=text.ALLOWED,
        allowed_groups=text.ALLOWED_GROUPS,
        files=[(name, quote(name), FILES.get(name, "")) for name in files],
        largest_share=max(1.0, *result.excitation.share),
    )


def symbols(text: str) -> Markup:
    """Escape a text and lower the digit of every parameter's name in it: I1 becomes I with index 1."""
    return Markup(re.sub(_SYMBOL, r"<i>\1</i><sub>\2</sub>", str(escape(text))))


def sentence(text: str) -> str:
    """Begin a text with a capital, unless a parameter, file or signal comes first, and end it with a full stop."""
    start = text if _SYMBOL.match(text) or _NAME.match(text) else text[:1].upper() + text[1:]
    return start if not start or start[-1] in ".!?:" else f"{start}."
