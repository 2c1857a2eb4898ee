"""The code that a job reaches, a digest for each definition: Snakemake runs a job again if one of them changes.

Each digest is a parameter of its rule, so that the reason which Snakemake prints names the definitions that changed.

Definitions are followed by name. A function counts with the functions, classes and constants that it names, in whatever
module of the package they stand, each by its syntax tree without docstrings; statements that define nothing count with
every definition of their module. ``import_module(f"package.{name}")`` counts with all modules of the package.
"""

import ast
import hashlib
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypedDict

from repro.files import write_text

PACKAGE = Path(__file__).resolve().parents[1]

#: Digest of a definition, and the names in it.
Definition = tuple[str, list[str]]
#: Of a module's statements that define nothing.
REST = ""
#: Digest of a module without such statements.
NOTHING = hashlib.sha256().hexdigest()


class Module(TypedDict):
    """What a source defines, and what its imported names stand for."""

    definitions: dict[str, Definition]
    imported: dict[str, str]


class CodeDigests:
    """Digests of the package's code; sources that were read before are taken from a file."""

    def __init__(self, kept: Path, package: Path = PACKAGE) -> None:
        self._kept, self._package = kept, package
        self._reader = Path(__file__).read_bytes()  # what another version of it has read is read anew
        self._modules: dict[str, Module] = {}
        try:
            self._read: dict[str, Module] = json.loads(kept.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self._read = {}
        self._known = len(self._read)

    def of_script(self, script: Path, *names: str) -> list[str]:
        """Digests of what a script and all further names reach."""
        own = self._parse(script.read_bytes())["definitions"]
        reached = self._reached([*self._in_script(script), *self._named(names)])
        return [*self._digests(reached), *(f"{script.name}:{name} {digest[:12]}" for name, (digest, _) in own.items())]

    def of(self, *names: str) -> list[str]:
        """Digests of what modules (``package.module``) or definitions (``package.module:name``) reach."""
        return self._digests(self._reached(self._named(names)))

    def keep(self) -> None:
        """Write down what was read, for the next process."""
        if len(self._read) > self._known:
            write_text(self._kept, json.dumps(self._read))
            self._known = len(self._read)

    def _digests(self, reached: Iterable[tuple[str, str]]) -> list[str]:
        found = [(f"{module}:{name}", self._module(module)["definitions"][name][0]) for module, name in sorted(reached)]
        # Snakemake would take braces, as in a table's key, for wildcards.
        braces = str.maketrans("{}", "<>")
        return [f"{name} {digest[:12]}".translate(braces) for name, digest in found if digest != NOTHING]

    def _in_script(self, script: Path) -> Iterator[tuple[str, str]]:
        source = self._parse(script.read_bytes())
        for _, names in source["definitions"].values():
            for name in names:
                yield from self._stands_for(source, name)

    def _named(self, names: Iterable[str]) -> Iterator[tuple[str, str]]:
        for name in names:
            module, _, definition = name.partition(":")
            yield from [(module, definition)] if definition else self._whole(module)

    def _reached(self, ahead: Iterable[tuple[str, str]]) -> set[tuple[str, str]]:
        """Definitions that can be come to from these, themselves among them."""
        reached: set[tuple[str, str]] = set()
        todo = list(ahead)
        while todo:
            found = todo.pop()
            if found in reached:
                continue
            reached.add(found)
            module, name = found
            todo += [(package, REST) for package in (module, *_above(module))]
            for used in self._module(module)["definitions"][name][1]:
                known = used.split(".")[0] in self._module(module)["definitions"]
                todo += [(module, used.split(".")[0])] if known else self._stands_for(self._module(module), used)
        return reached

    def _stands_for(self, source: Module, used: str) -> Iterator[tuple[str, str]]:
        """Definitions of the package that a name used in a source means; none if it is not the package's."""
        if used.endswith(".*"):
            folder = self._package.parent.joinpath(*used.split(".")[:-1])
            for file in sorted(folder.glob("*.py")) if folder.is_relative_to(self._package) else ():
                yield from self._whole(f"{used[:-2]}.{file.stem}")
            return
        first, *attributes = used.split(".")
        parts = [*source["imported"].get(first, "").split("."), *attributes]
        for end in range(len(parts), 0, -1):
            module = ".".join(parts[:end])
            if self._path(module):
                yield from self._defined(module, parts[end:])
                return

    def _defined(self, module: str, attributes: list[str]) -> Iterator[tuple[str, str]]:
        """What an attribute of a module is: defined there, imported there, or the module as a whole."""
        if attributes and attributes[0] in self._module(module)["definitions"]:
            yield module, attributes[0]
        elif attributes and attributes[0] in self._module(module)["imported"]:
            yield from self._stands_for(self._module(module), ".".join(attributes))
        else:
            yield from self._whole(module)

    def _whole(self, module: str) -> list[tuple[str, str]]:
        return [(module, name) for name in self._module(module)["definitions"]]

    def _path(self, name: str) -> Path | None:
        """File of a module of the package, and nothing for any other name."""
        top, *rest = name.split(".")
        if top != self._package.name:
            return None
        path = self._package.joinpath(*rest)
        return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.is_file()), None)

    def _module(self, name: str) -> Module:
        if name not in self._modules:
            path = self._path(name)
            self._modules[name] = self._parse(path.read_bytes() if path else b"")
        return self._modules[name]

    def _parse(self, source: bytes) -> Module:
        key = hashlib.sha256(self._reader + source).hexdigest()
        if key not in self._read:
            self._read[key] = parse(source)
        return self._read[key]


def _above(module: str) -> list[str]:
    """Packages that are loaded before a module."""
    parts = module.split(".")
    return [".".join(parts[:end]) for end in range(1, len(parts))]


def parse(source: bytes) -> Module:
    """Definitions of a source with the names that each uses, and what its imports bring."""
    tree = _Bare().visit(ast.parse(source))
    imported: dict[str, str] = {}
    parts: dict[str, list[ast.AST]] = {REST: []}
    dotted = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            imported |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            imported |= {alias.asname: alias.name for alias in node.names if alias.asname}
            plain = [alias.name for alias in node.names if not alias.asname]
            imported |= {name.split(".")[0]: name.split(".")[0] for name in plain}
            dotted += plain
    for statement in tree.body:
        if not isinstance(statement, ast.Import | ast.ImportFrom):
            for name in _defines(statement) or [REST]:
                parts.setdefault(name, []).append(statement)
            for key, value in _entries(statement):
                parts[key] = [value]
    names = {name: sorted({used for node in nodes for used in _used(node)}) for name, nodes in parts.items()}
    idle = imported.keys() - {used.split(".")[0] for node in tree.body for used in _used(node, annotations=True)}
    names[REST] += sorted(idle) + dotted  # imported for what loading does
    digests = {name: "".join(ast.dump(node) for node in nodes) for name, nodes in parts.items()}
    definitions = {name: (hashlib.sha256(text.encode()).hexdigest(), names[name]) for name, text in digests.items()}
    return {"definitions": definitions, "imported": imported}


class _Bare(ast.NodeTransformer):
    """Takes out docstrings, and what is imported for types alone."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        super().generic_visit(node)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node, clean=False):
            node.body = node.body[1:]
        return node

    def visit_If(self, node: ast.If) -> ast.AST | None:
        typing = isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        return None if typing else self.generic_visit(node)


def _defines(statement: ast.stmt) -> list[str]:
    """Names that a statement of a module defines and does nothing else."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return [statement.name]
    if isinstance(statement, ast.AnnAssign | ast.Assign):
        targets = [statement.target] if isinstance(statement, ast.AnnAssign) else statement.targets
        flat = [each for target in targets for each in (target.elts if isinstance(target, ast.Tuple) else [target])]
        return [each.id for each in flat if isinstance(each, ast.Name)]
    return []


def _entries(statement: ast.stmt) -> Iterator[tuple[str, ast.expr]]:
    """Entries of a dictionary that is written out, each a definition of its own: ``NAME[key]``."""
    if isinstance(statement, ast.Assign | ast.AnnAssign) and isinstance(statement.value, ast.Dict):
        for key, value in zip(statement.value.keys, statement.value.values, strict=True):
            if key is not None and not any(isinstance(part, ast.Name) for part in ast.walk(key)):
                for name in _defines(statement):
                    yield f"{name}[{ast.literal_eval(key)!r}]", value


def _used(node: ast.AST, annotations: bool = False) -> Iterator[str]:
    """Names that a definition uses, with attributes: ``numpy.sin``; those of annotations do nothing in a run."""
    if isinstance(node, ast.Name):
        yield node.id
    elif isinstance(node, ast.Attribute):
        inner = list(_used(node.value, annotations))
        whole = isinstance(node.value, ast.Name | ast.Attribute) and len(inner) == 1
        yield from [f"{inner[0]}.{node.attr}"] if whole else inner
    else:
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            yield from _packages(node.args)
        for name, value in ast.iter_fields(node):
            if annotations or name not in ("annotation", "returns"):
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST):
                        yield from _used(child, annotations)


def _packages(arguments: Iterable[ast.expr]) -> Iterator[str]:
    """Packages of which a module is chosen by an f-string: ``package.*``."""
    for argument in arguments:
        match argument:
            case ast.JoinedStr(values=[ast.Constant(value=str(prefix)), *_]) if prefix.endswith("."):
                yield f"{prefix}*"
