"""A small but whole set of results for the report: every file that it reads, with made-up numbers."""

import csv
import hashlib
import io
from functools import cache

import exhibit_examples
from PIL import Image, ImageDraw

from repro.exhibits.catalogue import FIGURES, TABLES
from repro.files import write_csv
from repro.paper.claims import CAUSES, VERDICTS, Basis
from repro.report.page import ReportInputs

#: What must be escaped wherever it is shown.
TRICKY = "a < b & \"c\" > 'd' <script>alert(1)</script>"

NOTES = {
    "reproduced": "",
    "better": "Refinement is an extension of ours.",
    "differs": f"The published ranges cannot produce these parameters; {TRICKY}.",
    "inconclusive": "",
    "not comparable": "A simulated arm.",
    "contradicts itself": "Time x Frequency is 88.48, the table prints 85.82.",
    "not run": "Of another target.",
    "needs the hardware": "A measurement of the real arm.",
}


def claim_rows(count=60):
    """Rows of ``claims.csv``: every verdict, blank numbers where there are none, a tiny one and a negative one."""
    rows = []
    of_results = [verdict for verdict in VERDICTS if verdict != "not run"]
    for n in range(count):
        verdict = "not run" if n == 41 else of_results[n % len(of_results)]
        known = verdict != "needs the hardware"
        rows.append(
            {
                "id": f"table{4 + n % 7:02d}/N{n % 4 + 1}/total/{n}{'@refinement' if n % 9 == 1 else ''}",
                "place": f"Table {4 + n % 7}",
                "quantity": f"total similarity {n}",
                "unit": "%",
                "kind": "setting" if n == 41 else "stochastic" if known else "hardware-only",
                "basis": str(list(Basis)[n % len(Basis)]),
                "published": f"{97.38 - n:g}",
                "ours": f"{97.38 - n + 0.123456789:.10g}" if known else "",
                "difference": "0.123456789" if known else "",
                "tolerance": "0.005" if known else "",
                "tolerance_from": "print precision",
                "verdict": verdict,
                "asserted": "" if n % 10 else verdict,
                "cause": list(CAUSES)[n % 3] if verdict == "differs" else "",
                "target": f"table{4 + n % 7:02d}",
                "note": NOTES[verdict],
            }
        )
    rows[0] |= {"quantity": "rate of the appendix", "unit": "kg m^2/s", "published": "7.1236e-08"}
    rows[0] |= {"ours": "7.123612345e-08", "difference": "-1.2345e-13", "tolerance": "5e-13", "target": "stability"}
    return rows


def write_rows(path, rows, columns=None):
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns or list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


@cache
def picture(size):
    """PNG of a frame, this many pixels wide and high."""
    image = Image.new("RGB", size, "white")
    ImageDraw.Draw(image).rectangle((10, 10, size[0] - 10, size[1] - 10), outline="black", width=4)
    file = io.BytesIO()
    image.save(file, "PNG")
    return file.getvalue()


def write_picture(path, size=(2148, 800)):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(picture(size))


def verdict_rows():
    words = {("algorithm1", 9.42): "worse", ("algorithm1", 19.53): "worse"}
    words |= {("algorithm1+refinement", 9.42): "equivalent", ("algorithm1+refinement", 19.53): "better"}
    return [
        {
            "set": name, "duration": duration, "method": method, "opponent": opponent, "arms": arms, "wins": 3,
            "difference": difference, "low": difference - 0.012, "high": difference + 0.004, "p": 0.001,
            "p_holm": 0.004, "conclusion": word,
        }
        for name, arms, difference in (("all", 14, -0.0523), ("without chatter", 11, -0.0611))
        for (method, duration), word in words.items()
        for opponent in ("least-squares", "bounded")
    ]  # fmt: skip


def make_example(folder, **changes):
    """Write everything a report reads and return its `ReportInputs`; nothing optional is there."""
    results, figures = folder / "results", folder / "paper_figures"
    write_rows(results / "claims.csv", claim_rows())
    for exhibit in TABLES:
        if not exhibit.optional:
            path = results / "tables" / exhibit.name
            write_csv(path.with_suffix(".csv"), exhibit_examples.TABLES[exhibit.name]())
            path.with_suffix(".tex").write_text("\\begin{table}\\end{table}\n", encoding="utf-8")
    write_rows(results / "tables" / "verdict.csv", verdict_rows())
    finding = {"id": "ls-t2", "place": "Table 10", "what": TRICKY, "arithmetic": "0.9 x 0.98", "found": "88.48"}
    write_rows(results / "tables" / "audit.csv", [{**finding, "printed": "85.82", "verdict": "off", "note": "LS, T2"}])
    for number, exhibit in enumerate(FIGURES):
        if not exhibit.optional:
            write_picture(figures / f"{exhibit.name}.png", (2148, 800) if number % 4 else (1050, 600))
            (figures / f"{exhibit.name}.pdf").write_bytes(b"%PDF-1.4 example\n")
            write_rows(results / "figures" / f"{exhibit.name}.csv", [{"x": 0.0, "y": 1.0}])
    captures = folder / "SHA256SUMS"
    captures.write_text(f"{hashlib.sha256(b'run').hexdigest()}  ID.bin\n", encoding="utf-8")
    provenance = {"commit": "0123abc", "packages.numpy": "2.4.6"}
    given = {"config_sha256": hashlib.sha256(b"config").hexdigest(), "provenance": provenance, **changes}
    return ReportInputs(results, figures, captures, **given)
