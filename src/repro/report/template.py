"""What all self-contained pages share: how templates are filled, and a policy that forbids every request."""

import base64
import hashlib
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined


def environment(folder: Path) -> Environment:
    """Jinja environment that escapes everything and refuses unknown names."""
    return Environment(
        loader=FileSystemLoader(folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def policy(style: str, script: str | None = None) -> str:
    """Content security policy: this style, this script if any, pictures in data URIs, nothing else."""
    allowed = [f"style-src 'sha256-{_digest(style)}'"]
    if script is not None:
        allowed.append(f"script-src 'sha256-{_digest(script)}'")
    return "; ".join(["default-src 'none'", "img-src data:", *allowed, "base-uri 'none'", "form-action 'none'"])


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
