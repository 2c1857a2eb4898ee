"""Comparison of what a block of code prints with what a page shows."""

import re

NUMBER = re.compile(r"(?<![A-Za-z\d_])-?\d+(?:\.\d*)?")


def same_output(printed: str, shown: str) -> bool:
    """Compare texts without blanks, and decimals to one unit of the last digit: processors round differently."""
    if "".join(NUMBER.sub("#", printed).split()) != "".join(NUMBER.sub("#", shown).split()):
        return False
    pairs = list(zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=True))
    digits = [max(len(number.partition(".")[2]) for number in pair) for pair in pairs]
    both = zip(pairs, digits, strict=True)
    return all(a == b or (n and abs(float(a) - float(b)) < 1.01 * 10.0**-n) for (a, b), n in both)
