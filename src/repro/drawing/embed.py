"""What self-contained pages share: files read whole, templates, a policy without requests, files as data URIs."""

import base64
import hashlib
import io
import os
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from PIL import Image, UnidentifiedImageError

from repro.errors import InputError, failure


def read_bytes(path: Path, expected: str) -> bytes:
    """Read a file that must be there and hold something."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError.at(str(path), failure(error), expected) from error
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
    sources = {"style": style} if script is None else {"style": style, "script": script}
    digests = {name: _base64(hashlib.sha256(text.encode()).digest()) for name, text in sources.items()}
    allowed = [f"{name}-src 'sha256-{digest}'" for name, digest in digests.items()]
    return "; ".join(["default-src 'none'", "img-src data:", *allowed, "base-uri 'none'", "form-action 'none'"])


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode()


#: A file up to this many bytes is held in the page; a larger one is linked where it lies.
LARGEST_DOWNLOAD = 64_000


class Picture(NamedTuple):
    """A picture in the page: its data URI and the size it is shown at, in CSS pixels."""

    uri: str
    width: int
    height: int


class Link(NamedTuple):
    """A link to data."""

    text: str  # what the link says: the kind of file and its size
    href: str  # a data URI, or the way from the page to the file
    download: str  # name to save it under; empty for a file that is only linked


def embedded(png: bytes, scale: float) -> Picture:
    """Embed an image, shown at `scale` CSS pixels for a pixel."""
    with Image.open(io.BytesIO(png), formats=["PNG"]) as image:
        width, height = (round(scale * pixels) for pixels in image.size)
    return Picture(f"data:image/png;base64,{_base64(png)}", width, height)


def picture(path: Path) -> Picture:
    """Embed a PNG file."""
    try:
        # Drawn at 300 dpi, shown at 1.25 times the printed size.
        return embedded(read_bytes(path, "a PNG image"), 1.25 * 96.0 / 300.0)
    except (UnidentifiedImageError, OSError) as error:
        raise InputError.at(str(path), "a file that is not an image", "a PNG image") from error


def link(path: Path, page: Path) -> Link:
    """Link to a data file, held in the page if it is small."""
    kind = path.suffix[1:].upper()
    content = read_bytes(path, f"a {kind} file")
    count = len(content)
    size = f"{count / 1e6:.1f} MB" if count >= 100_000 else f"{max(count / 1e3, 0.1):.1f} kB"
    if count <= LARGEST_DOWNLOAD and kind != "PDF":
        media = "text/csv" if kind == "CSV" else "text/plain"
        return Link(f"{kind} ({size})", f"data:{media};charset=utf-8;base64,{_base64(content)}", path.name)
    return Link(f"{kind} ({size}, next to this report)", quote(Path(os.path.relpath(path, page.parent)).as_posix()), "")
