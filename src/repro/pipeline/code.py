"""The code that a job reaches, as one digest: a rule whose digest is another one is run anew.

A module counts by its syntax tree without docstrings, and so does every module of the package that it imports.
"""

import ast
import hashlib
import json
from pathlib import Path

from repro.files import write_text

PACKAGE = Path(__file__).resolve().parents[1]


class CodeDigests:
    """Digests of the package's code; trees that were read before are taken from a file."""

    def __init__(self, kept: Path, package: Path = PACKAGE) -> None:
        self._kept, self._package = kept, package
        self._modules: dict[str, tuple[str, list[str]]] = {}
        try:
            self._read: dict[str, tuple[str, list[str]]] = json.loads(kept.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self._read = {}
        self._known = len(self._read)

    def of_script(self, script: Path, *modules: str) -> str:
        """Digest of a script with all that it imports, and of further modules."""
        return self.of(*modules, *self.reached_by(script), salt=self._parse(script.read_bytes())[0])

    def reached_by(self, script: Path) -> set[str]:
        """Modules of the package that a script imports, and all that they do."""
        return self.reached(*self._parse(script.read_bytes())[1])

    def of(self, *modules: str, salt: str = "") -> str:
        """Digest of modules with all that they import."""
        digest = hashlib.sha256(salt.encode())
        for name in sorted(self.reached(*modules)):
            digest.update(f"{name} {self._module(name)[0]}\n".encode())
        return digest.hexdigest()

    def keep(self) -> None:
        """Write down what was read, for the next process."""
        if len(self._read) > self._known:
            write_text(self._kept, json.dumps(self._read))
            self._known = len(self._read)

    def reached(self, *modules: str) -> set[str]:
        """Modules of the package that these import, themselves among them."""
        reached: set[str] = set()
        ahead = [name for name in modules if self._path(name)]
        while ahead:
            name = ahead.pop()
            if name not in reached:
                reached.add(name)
                ahead += [other for other in self._module(name)[1] if self._path(other)]
        return reached

    def _path(self, name: str) -> Path | None:
        """File of a module of the package, and nothing for any other name."""
        top, *rest = name.split(".")
        if top != self._package.name:
            return None
        path = self._package.joinpath(*rest)
        return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.is_file()), None)

    def _module(self, name: str) -> tuple[str, list[str]]:
        if name not in self._modules:
            path = self._path(name)
            self._modules[name] = self._parse(path.read_bytes()) if path else ("", [])
        return self._modules[name]

    def _parse(self, source: bytes) -> tuple[str, list[str]]:
        """Digest of the tree without docstrings, and every name that is imported from the package."""
        key = hashlib.sha256(source).hexdigest()
        if key not in self._read:
            tree = ast.parse(source)
            imported = []
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom) and node.module:
                    imported += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
                elif isinstance(node, ast.Import):
                    imported += [alias.name for alias in node.names]
                if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(
                    node, clean=False
                ):
                    node.body = node.body[1:]
            own = sorted({name for name in imported if name.split(".")[0] == self._package.name})
            self._read[key] = hashlib.sha256(ast.dump(tree).encode()).hexdigest(), own
        return self._read[key]
