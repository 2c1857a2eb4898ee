"""A small but whole set of results for the report: every file that it reads."""

import hashlib

import exhibit_examples
import pandas as pd
from PIL import Image, ImageDraw

from repro.exhibits.catalogue import FIGURES, TABLES
from repro.files import read_rows, write_csv
from repro.report.page import ReportInputs

#: What must be escaped wherever it is shown.
TRICKY = "a < b & \"c\" > 'd' <script>alert(1)</script>"


def claim_rows():
    """Some rows of the ledger of the reference, among them every verdict; one that differs has other numbers."""
    rows = [dict(row) for row in read_rows(exhibit_examples.REFERENCE.parent / "claims.csv")[::5]]
    changed = next(row for row in rows if row["verdict"] == "differs")
    changed |= {"id": "table06/N3/total/2", "unit": "%", "published": "95.38", "ours": "95.503456789"}
    changed |= {"difference": "0.123456789", "tolerance": "0.005", "note": f"Of the published ranges; {TRICKY}."}
    return rows


def make_example(folder):
    """Write everything a report reads and return its `ReportInputs`; nothing optional is there."""
    results, figures = folder / "results", folder / "paper_figures"
    write_csv(results / "claims.csv", pd.DataFrame(claim_rows()))
    for exhibit in TABLES:
        if not exhibit.optional:
            path = results / "tables" / exhibit.name
            write_csv(path.with_suffix(".csv"), exhibit_examples.TABLES[exhibit.name]())
            path.with_suffix(".tex").write_text("\\begin{table}\\end{table}\n", encoding="utf-8")
    finding = {"id": "ls-t2", "place": "Table 10", "what": TRICKY, "arithmetic": "0.9 x 0.98", "found": "88.48"}
    findings = pd.DataFrame([{**finding, "printed": "85.82", "verdict": "off", "note": "LS, T2"}])
    write_csv(results / "tables" / "audit.csv", findings)
    figures.mkdir()
    for number, exhibit in enumerate(FIGURES):
        if not exhibit.optional:
            image = Image.new("RGB", (2148, 800) if number % 4 else (1050, 600), "white")
            ImageDraw.Draw(image).rectangle((10, 10, 1000, 590), outline="black", width=4)
            image.save(figures / f"{exhibit.name}.png")
            (figures / f"{exhibit.name}.pdf").write_bytes(b"%PDF-1.4 example\n")
            write_csv(results / "figures" / f"{exhibit.name}.csv", pd.DataFrame({"x": [0.0], "y": [1.0]}))
    capture = folder / "ID.bin"
    capture.write_bytes(b"run")
    provenance = {"commit": "0123abc", "packages.numpy": "2.4.6"}
    return ReportInputs(results, figures, [capture], hashlib.sha256(b"config").hexdigest(), provenance)
