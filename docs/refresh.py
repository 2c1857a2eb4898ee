"""Copy a full run into the repository: small pictures to docs/gallery, tables, config and provenance to docs/reference.

Usage, after ``snakemake --cores 2``: ``python docs/refresh.py``
"""

import shutil
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
GALLERY, REFERENCE = ROOT / "docs/gallery", ROOT / "docs/reference"
WIDTH = 800


def refresh_gallery() -> None:
    """Shrink every figure to the width of a page on a screen, in 64 colours."""
    GALLERY.mkdir(parents=True, exist_ok=True)
    for figure in sorted((ROOT / "paper_figures").glob("*.png")):
        with Image.open(figure) as picture:
            height = round(picture.height * WIDTH / picture.width)
            small = picture.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS).quantize(64)
            small.save(GALLERY / figure.name, optimize=True)


def refresh_reference() -> None:
    """Copy what a reader compares their own run with."""
    shutil.rmtree(REFERENCE / "tables", ignore_errors=True)
    (REFERENCE / "tables").mkdir(parents=True)
    for table in sorted((ROOT / "results/tables").glob("*.*")):
        shutil.copy(table, REFERENCE / "tables")
    for file in ("config/config.yaml", "results/logs/provenance.json", "results/model/training.csv"):
        shutil.copy(ROOT / file, REFERENCE)
    shutil.copy(ROOT / "results/model/model-card.md", REFERENCE)


if __name__ == "__main__":
    refresh_gallery()
    refresh_reference()
