"""Write the tables of README.md and docs/*.md: numbers of docs/reference, options of commands, arm file, Python API.

Such a table stands between ``<!-- table: NAME -->`` and ``<!-- end -->``; NAME is a function's name here. Usage, in the
project's folder: ``python docs/pages.py``. ``docs/refresh.py`` does it after each copy of a run.
"""

import argparse
import dataclasses
import inspect
import json
import re
import runpy
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from statistics import fmean as mean
from typing import Any, cast

import pandas as pd

import repro
from repro.cli import parser
from repro.drawing.style import MEANINGS, METHODS, title_of
from repro.keys import Key
from repro.paper.published import load_published
from repro.report.headline import COLUMNS, NUMERIC, PRINTED, means, published_headline
from repro.report.headline import headline as similarities

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT / "docs/reference"
PAGES = (
    "README.md",
    "docs/api.md",
    "docs/board.md",
    "docs/commands.md",
    "docs/log-files.md",
    "docs/results.md",
    "docs/explanation/causes.md",
    "docs/explanation/experiment.md",
    "docs/explanation/least-squares.md",
    "docs/explanation/methods-and-intervals.md",
    "docs/explanation/study.md",
)
#: Kinds of effect whose coverage the page on intervals shows, and the generators of their arms.
COVERED = ("clean", "coarse", "constant", "position", "friction", "temperature", "rotor30", "rotor30+flexible")
GENERATORS = ("board", "planar")
MOTIONS = ("ID", "T1", "T2", "T3", "T4")
VALIDATION = MOTIONS[1:]

#: Rows of the README's table, each with its targets; a published row stands before its method.
HEADLINE = {
    "algorithm1": ("Algorithm 1", "`table06` `table07` `table10`"),
    "algorithm1/one-run": ("Algorithm 1, one run", "`table10`"),
    "algorithm1+paper-recipe-ranges": ("Algorithm 1, trained as printed", "`paper_recipe`"),
    "least-squares": ("Least squares", "as Algorithm 1"),
    "true": ("True parameters", "`table10`"),
}
#: Headline similarities with other trainings of the network.
NETWORKS = ROOT / "benchmarks/results/networks.csv"
#: Targets whose costs a page shows, with the label of each row.
COSTS = {
    "table06": "`table04` to `table07`",
    "table10": "`table10`, `stability`",
    "training": "`training`",
    "table08": "`table08`",
    "table09": "`table09`",
    "board_size": "`board_size`",
    "claims": "settings, constants and arithmetic: the ledger's own job",
    None: "none: only the hardware can decide",
}


def markdown(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table of a page."""
    header = list(header)
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def percent(value: float) -> str:
    """Percentage with two decimals, empty where there is none."""
    return "" if pd.isna(value) else f"{100 * value:.2f}"


def totals(name: str) -> pd.DataFrame:
    """Totals of a table, a row for each method and a column for each case and joint."""
    frame = pd.read_csv(REFERENCE / f"tables/{name}.csv")
    return frame.pivot(index="method", columns=["case", "joint"], values="total")


def published(prefix: str, cases: Iterable[str], suffix: str) -> list[float]:
    """Published totals of some cases, as fractions."""
    numbers = load_published()
    return [numbers[f"{prefix}/{case}{suffix}/total/joint{joint}"].value / 100 for case, joint in cells(cases)]


def cells(cases: Iterable[str]) -> list[tuple[str, int]]:
    """Both joints of each case."""
    return [(case, joint) for case in cases for joint in (1, 2)]


def table_of_totals(name: str, cases: tuple[str, ...], first: dict[str, list[float]], average: str = "") -> str:
    """Methods by cases, both joints in a cell; published rows first, a mean over the validation motions first, too."""
    values = {**first, **{title_of(str(key)): row[cells(cases)].tolist() for key, row in totals(name).iterrows()}}
    rows = []
    for label in (*first, *(title for title in map(title_of, METHODS) if title in values)):
        joints = zip(values[label][::2], values[label][1::2], strict=True)
        shown = [percent(mean(values[label][2:]))] if average else []
        rows.append([label, *shown, *(f"{percent(one)} / {percent(two)}" for one, two in joints)])
    return markdown(["τ1 / τ2", *([average] if average else []), *cases], rows)


def methods() -> str:
    """What the names of methods in the tables of totals leave unsaid."""
    shown = {method for table in ("table06", "table07", "table10") for method in totals(table).index}
    return markdown(["row", "what it is"], [[title_of(k), meaning] for k, meaning in MEANINGS.items() if k in shown])


def table06() -> str:
    """Totals on the identification trajectory; the published ones are lost."""
    return table_of_totals("table06", NUMERIC, {})


def table07() -> str:
    """Totals on the random validation motion."""
    return table_of_totals("table07", NUMERIC, {PRINTED["algorithm1"]: published("table07", NUMERIC, "")})


def table10() -> str:
    """Totals on the simulated arm."""
    first = {PRINTED[method]: published("table10", MOTIONS, f"/{method}") for method in PRINTED}
    return table_of_totals("table10", MOTIONS, first, "mean T1 to T4")


def headline() -> str:
    """Means over N1 to N4 and over the motions of the simulated arm."""
    printed, own = published_headline(), similarities(REFERENCE / "tables")
    recipe = pd.read_csv(REFERENCE / "tables/paper_recipe.csv")
    tested = next(iter(COLUMNS))  # on the arm its networks compare with another one than ours
    own = own.combine_first(pd.DataFrame({tested: means(recipe, tested)}, columns=own.columns))
    rows = []
    for key, (label, targets) in HEADLINE.items():
        if key in PRINTED:
            rows.append([PRINTED[key], *printed.loc[key], ""])
        rows.append([label, *map(percent, own.loc[key]), targets])
    several = pd.read_csv(NETWORKS).set_index("training").agg(["min", "max"]).mul(100.0)
    ranges = [f"{low:.1f} to {high:.1f}" for low, high in several.T.to_numpy()]
    rows.insert(2, ["Algorithm 1, twelve networks", *ranges, ""])
    return markdown(["", *own, "target"], rows)


def verdicts() -> str:
    """Counts of the ledger, by verdict and by what a comparison rests on: the first table of its page."""
    page = (REFERENCE / "claims.md").read_text(encoding="utf-8")
    return page[page.index("| verdict |") :].partition("\n\n")[0].replace("| 0 ", "|  ")


def costs() -> str:
    """What the claims of a target cost."""
    frame = pd.read_csv(REFERENCE / "logs/costs.csv")
    # Each table of Tables 4 to 7 needs the same jobs.
    shared = {"table06": ["table04", "table05", "table06", "table07"], "table10": ["table10", "stability"]}
    rows = []
    for target, label in COSTS.items():
        names = shared.get(target, [target])
        of = frame[frame["target"].isna()] if target is None else frame[frame["target"].isin(names)]
        decimals = {"jobs": 0, "minutes": 1, "memory_mib": 0, "disk_mb": 1}
        figures = ["" if target is None else f"{of.iloc[0][name]:.{n}f}" for name, n in decimals.items()]
        rows.append([label, str(len(of)), *figures])
    return markdown(["target", "claims", "jobs", "minutes", "memory, MiB", "disk, MB"], rows)


def verdict() -> str:
    """Differences of the mean total in points, all intervals valid at once."""
    rows = [
        [
            *(title_of(row[name]) for name in ("method", "opponent")),
            "{:.1f} ({:.1f} to {:.1f}), {}".format(
                *(100 * row[name] for name in ("difference", "low", "high")), row["conclusion"]
            ),
        ]
        for row in pd.read_csv(REFERENCE / "tables/verdict.csv").to_dict("records")
    ]
    return markdown(["", "against", "difference"], rows)


def causes() -> str:
    """Similarity on T1 to T4 and error of single estimates, by training motion and by what estimates."""
    frame = pd.read_csv(REFERENCE / "tables/factorial_cells.csv").query("metric == 'mean-square'")
    frame["by"] = frame["reader"].str.cat(frame["image_motion"], sep=" ", na_rep="").str.strip()
    frame["cell"] = [f"{100 * a:.1f} ({b:.2f})" for a, b in frame[["validation", "error"]].to_numpy()]
    of = frame.pivot(index="training", columns="by", values="cell")
    columns = {
        "Algorithm 1, f on the measured motion": "cnn measured",
        "Algorithm 1, f on the desired motion": "cnn desired",
        "plain network": "plain",
    }
    labels = {"ideal": "Eq. 10 (as the paper)", "tracked": "closed-loop motions"}
    rows = [[label, *of.loc[training, list(columns.values())]] for training, label in labels.items()]
    return markdown(["network trained on", *columns], rows)


def laid_out(name: str) -> str:
    """A table as the reference has it, without its caption."""
    return (REFERENCE / f"tables/{name}.md").read_text(encoding="utf-8").partition("\n\n")[2].strip()


def accepted() -> str:
    """The table over the accepted experiments without the extensions of Algorithm 1."""
    heads, rule, *rows = ([*line.strip("|").split("|")] for line in laid_out("accepted").splitlines())
    shown = [row for row in rows if "desired" not in row[0] and "closed" not in row[0]]
    for row in shown:
        if "Algorithm 1" not in row[0]:
            row[-1] = "  "  # only estimates from guesses meet the threshold
        if row[0].strip() == title_of("least-squares"):
            row[-2] = "  "  # which is not compared with itself
    return "\n".join(f"|{'|'.join(row)}|" for row in (heads, rule, *shown))


def arm_file() -> str:
    """Keys of an arm file: what is expected of each, and its default."""
    rows = []
    for name, key in repro.Arm.__pydantic_fields__.items():
        if not key.exclude:
            default, stated = getattr(repro.Arm(), name), key.json_schema_extra
            # JSON spells the values as YAML does.
            shown = f"`{json.dumps(default).strip(chr(34))}`" if default not in (None, {}) else stated["absent"]
            rows.append([f"`{name}`", stated["expected"], re.sub(r"\.0\b", "", shown), key.description or ""])
    return markdown(["key", "value", "default", "note"], rows)


def commands() -> str:
    """Options of every subcommand of `repro`."""
    (subcommands,) = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    return "\n\n".join(options(name, command) for name, command in subcommands.choices.items())


def options(name: str, command: argparse.ArgumentParser) -> str:
    """One subcommand: what it does, and its options."""
    formatter = command._get_formatter()
    rows = []
    for action in command._actions:
        if action.dest != "help":
            value = action.metavar or action.dest.upper()
            value = "" if action.nargs == 0 else f" {' '.join(value) if isinstance(value, tuple) else value}"
            names = ", ".join(action.option_strings) or value.strip()
            shown = f"`{names}{value if action.option_strings else ''}`"
            choices = f"; one of {', '.join(f'`{each}`' for each in action.choices)}" if action.choices else ""
            needed = "; required" if action.required and action.option_strings else ""
            rows.append([shown, formatter._expand_help(action) + choices + needed])
    return f"## repro {name}\n\n{command.description}\n\n{markdown(['option', 'meaning'], rows)}"


def api() -> str:
    """Heading, signature and docstring of every public name, each followed by its methods."""
    parts = []
    for name, what in public(repro):
        parts.append(described(name, what, "##"))
        if what is repro.Identification:
            parts += [described(f"{name}.{member}", each, "###") for member, each in public(what)]
    return "\n\n".join(parts)


def public(of: object) -> list[tuple[str, object]]:
    """Public names of the package, or methods and properties of a class, in their order."""
    names = repro.__all__ if of is repro else [name for name in vars(of) if not name.startswith("_")]
    members = [(name, getattr(of, name)) for name in names]
    return [(name, each) for name, each in members if callable(each) or isinstance(each, property)]


def described(name: str, what: object, heading: str) -> str:
    """One name: heading, call with its defaults, and the sections of its docstring."""
    parts = [f"{heading} {name}"]
    if inspect.isroutine(what) or what in (repro.Arm, repro.Log):
        signature = inspect.signature(what)
        bare = [each.replace(annotation=each.empty) for each in signature.parameters.values() if each.name != "self"]
        call = name + str(signature.replace(parameters=bare, return_annotation=signature.empty))
        parts.append(f"```pycon\n{call}\n```")
    opening, *sections = SECTION.split(inspect.getdoc(what) or "")
    parts.append(prose(opening))
    for title, body in zip(sections[::2], sections[1::2], strict=True):
        shown = examples(body) if title == "Examples" else items(body)
        parts.append(f"**{title}**\n\n{shown}")
    return "\n\n".join([*parts, *settings_fields(what), *([arm_file()] if what is repro.Arm else [])])


def prose(text: str) -> str:
    """Text of a docstring as Markdown: literals, and links from public names to their headings."""
    text = text.strip().replace("``", "`")
    return PUBLIC_NAME.sub(lambda match: f"[`{match[1]}`](#{match[1].lower()})", text)


def items(body: str) -> str:
    """Entries of a section of numpydoc as a list: name, type, and the indented meaning."""
    lines = []
    for head, meaning in re.findall(r"^(\S.*)\n((?:[ ]+.*(?:\n|$)|\n)*)", f"{body.strip()}\n", re.MULTILINE):
        name, _, kind = head.partition(" : ")
        kind = re.sub(rf"\b({'|'.join(repro.__all__)})\b", lambda match: f"[{match[1]}](#{match[1].lower()})", kind)
        said = prose(" ".join(meaning.split()))
        shown = prose(f"`{name}`") if name in repro.__all__ else f"`{name}`"
        lines.append(f"- {shown}{f' ({kind})' if kind else ''}{f': {said}' if said else ''}")
    return "\n".join(lines)


def examples(body: str) -> str:
    """Text between examples as text, each run of prompts with its output as a block."""
    blocks = [block.strip("\n") for block in body.strip("\n").split("\n\n")]
    return "\n\n".join(f"```pycon\n{block}\n```" if block.startswith(">>>") else prose(block) for block in blocks)


def interval_coverage() -> str:
    """Coverage of the intervals of `repro identify`, as the benchmark measured it."""
    measured = pd.read_csv(ROOT / "benchmarks/results/interval_coverage.csv").set_index(["kind", "generator"])
    effects = runpy.run_path(str(ROOT / "benchmarks/planar_arms.py"))["KINDS"]
    columns = {"coverage": ".3g", "half width": ".2g", "plain coverage": ".3g"}
    rows = []
    for kind in COVERED:
        of_kind = measured.loc[kind].reindex(GENERATORS)
        shown = [
            " / ".join("\N{EN DASH}" if pd.isna(x) else f"{x:{form}}" for x in of_kind[name])
            for name, form in columns.items()
        ]
        wrong, claims = of_kind[["wrong claims", "claims"]].sum().astype(int)
        rows.append([effects[kind], *shown, f"{wrong} of {claims}"])
    heads = ["unmodelled effect", "coverage, %", "half width, %", "coverage of noise alone, %", "wrong verdicts"]
    return markdown(heads, rows)


def settings_fields(what: object) -> list[str]:
    """Table of the fields of a class of settings, from their keys; empty for anything else."""
    if what not in (repro.SearchSettings, repro.SignalSettings):
        return []
    rows = []
    for field in dataclasses.fields(cast(Any, what)):
        (key,) = [each for each in getattr(field.type, "__metadata__", ()) if isinstance(each, Key)] or [NOT_PUBLIC]
        default = "" if key is NOT_PUBLIC else f"`{field.default!r}`"
        rows.append([f"`{field.name}`", default, key.unit or "", key.meaning])
    return [markdown(["field", "default", "unit", "meaning"], rows)]


COMPUTED = (
    *(headline, verdicts, table06, table07, table10, methods, costs, verdict, causes),
    *(interval_coverage, accepted, arm_file, commands, api),
)
TABLES: dict[str, Callable[[], str]] = {table.__name__: table for table in COMPUTED}
TABLES |= {name: partial(laid_out, name) for name in ("hypotheses", "board_size", "study_claims")}
#: Title of a section of numpydoc, and the line below it.
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
#: A public name as a docstring refers to it.
PUBLIC_NAME = re.compile(rf"(?<![`\w])`({'|'.join(repro.__all__)})`")
#: Of a field that no section of the configuration has.
NOT_PUBLIC = Key("not public: leave it out")
MARKED = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def written(text: str) -> str:
    """The text of a page with its tables from the reference."""
    return MARKED.sub(lambda match: match[1] + "\n" + TABLES[match[2]]() + "\n\n" + match[3], text)


def write_pages() -> None:
    """Write the tables of all pages."""
    for name in PAGES:
        path = ROOT / name
        path.write_text(written(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    write_pages()
