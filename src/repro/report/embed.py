"""What self-contained pages share: files read whole, templates, a policy without requests, files as data URIs."""

import base64
import hashlib
import io
import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from PIL import Image, UnidentifiedImageError

from repro.errors import InputError


def read_bytes(path: Path, expected: str) -> bytes:
    """Read a file that must be there and hold something."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", expected) from error
    if not content.strip():
        raise InputError.at(str(path), "an empty file", expected)
    return content


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


#: A file up to this many bytes is held in the page; a larger one is linked where it lies.
LARGEST_DOWNLOAD = 64_000
#: Pixels on the screen for one pixel of the picture: drawn at 300 dpi, shown at 1.25 times the printed size.
_SHOWN = 1.25 * 96.0 / 300.0


@dataclass(frozen=True)
class Picture:
    """A picture in the page: its data URI and the size it is shown at, in CSS pixels."""

    uri: str
    width: int
    height: int


@dataclass(frozen=True)
class Link:
    """A link to data."""

    text: str  # what the link says: the kind of file and its size
    href: str  # a data URI, or the way from the page to the file
    download: str  # name to save it under; empty for a file that is only linked


def embedded(png: bytes, scale: float) -> Picture:
    """Embed an image, shown at `scale` CSS pixels for a pixel."""
    with Image.open(io.BytesIO(png), formats=["PNG"]) as image:
        width, height = (round(scale * pixels) for pixels in image.size)
    return Picture(_uri(png, "image/png"), width, height)


def picture(path: Path) -> Picture:
    """Embed a PNG file."""
    try:
        return embedded(read_bytes(path, "a PNG image"), _SHOWN)
    except (UnidentifiedImageError, OSError) as error:
        raise InputError.at(str(path), "a file that is not an image", "a PNG image") from error


def link(path: Path, page: Path) -> Link:
    """Link to a data file, held in the page if it is small."""
    content = read_bytes(path, f"a {path.suffix[1:].upper()} file")
    media = "text/csv" if path.suffix == ".csv" else "text/plain"
    kind, size = path.suffix[1:].upper(), _size(len(content))
    if len(content) <= LARGEST_DOWNLOAD and path.suffix != ".pdf":
        return Link(f"{kind} ({size})", _uri(content, f"{media};charset=utf-8"), path.name)
    return Link(f"{kind} ({size}, next to this report)", quote(Path(os.path.relpath(path, page.parent)).as_posix()), "")


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 100_000 else f"{max(count / 1e3, 0.1):.1f} kB"


def _uri(content: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
