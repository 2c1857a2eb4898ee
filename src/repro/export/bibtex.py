"""BibTeX of the methods behind a result."""

import re
from collections.abc import Sequence
from pathlib import Path

METHODS_FILE = Path(__file__).with_name("methods.bib")


def entries() -> dict[str, str]:
    """Every entry of ``methods.bib`` under its key, in the order of the file."""
    # An entry starts with @type{key, in the first column and ends with the next brace there.
    found = re.finditer(r"^@\w+\{([^,\s]+),.*?^\}", METHODS_FILE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return {entry[1]: entry[0] for entry in found}


def bibtex(keys: Sequence[str]) -> str:
    """Entries for some sources."""
    known = entries()
    missing = [key for key in keys if key not in known]
    if missing:
        raise ValueError(f"keys: no BibTeX entry {missing[0]!r}; there are {', '.join(known)}.")
    return "".join(f"{known[key]}\n\n" for key in dict.fromkeys(keys)).removesuffix("\n")
