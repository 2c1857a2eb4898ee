"""Reading a page in Markdown."""

import re


def heading_anchors(text):
    """Anchors that a Markdown viewer gives to the headings of a page."""
    headings = [line.lstrip("# ").lower() for line in text.splitlines() if line.startswith("#")]
    return [re.sub(r"[^a-z0-9 -]", "", heading).replace(" ", "-") for heading in headings]
