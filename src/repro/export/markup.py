"""What URDF and MJCF share: a safe name, safe comments, exact numbers."""

import re
from xml.sax.saxutils import quoteattr

#: Characters that XML 1.0 allows and does not advise against, except tab and line ends.
_RANGES = ((0x20, 0x7E), (0xA0, 0xD7FF), (0xE000, 0xFFFD), (0x10000, 0x10FFFF))

#: Name of an arm that has none.
UNNAMED = "arm"


def name_attribute(name: str) -> str:
    """Quoted and escaped attribute value of a name."""
    text = " ".join(name.split())
    clean = "".join(c if any(low <= ord(c) <= high for low, high in _RANGES) else "_" for c in text)
    return quoteattr(clean or UNNAMED)


def comment(lines: tuple[str, ...], indent: str) -> str:
    """XML comment, one line of text to a line."""
    body = re.sub("-(?=-)", "- ", "\n".join(f"{indent}  {line}" for line in lines))
    return f"{indent}<!--\n{body}\n{indent}-->"


def numbers(*values: float) -> str:
    """Decimal numbers that read back as the same floats, parted by blanks."""
    return " ".join(repr(float(value) + 0.0) for value in values)  # + 0.0: no negative zero
