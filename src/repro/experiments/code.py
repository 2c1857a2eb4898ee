"""The code that a job reaches, a digest for each definition: Snakemake runs a job again if one of them changes.

Each digest is a parameter of its rule, so that the reason which Snakemake prints names the definitions that changed. A
definition counts with those that it names, in any module of the package, each by its syntax tree without docstrings,
and by the contents of a table or template next to its module that it names; statements that define nothing count with
every definition of their module.
"""

import ast
import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

#: The packages whose code counts.
PACKAGES = tuple(Path(__file__).resolve().parents[2] / name for name in ("repro", "repro_studies"))
#: Name of a module's statements that define nothing.
MODULE_LEVEL = ""


@dataclass(frozen=True)
class Module:
    """What a source defines, each with its digest and the names in it, and what its imported names mean."""

    definitions: dict[str, tuple[str, list[str]]]
    imported: dict[str, str]


class CodeDigests:
    """Digests of the packages' code."""

    def __init__(self, *packages: Path) -> None:
        self._packages = {package.name: package for package in packages or PACKAGES}
        self._modules: dict[str, Module] = {}

    def of_script(self, script: Path, *names: str) -> list[str]:
        """Digests of what a script and all further names reach."""
        self._modules[script.name] = parse(script)
        return self.of(script.name, *names)

    def of(self, *names: str) -> list[str]:
        """Digests of what modules (``package.module``) or definitions (``package.module:name``) reach."""
        start = []
        for place in names:
            module, _, name = place.partition(":")
            start += [(module, name)] if name else self._whole(module)
        definitions = sorted(self._reach(start))
        digests = [(f"{module}:{name}", self._module(module).definitions[name][0]) for module, name in definitions]
        return [f"{name} {digest[:12]}" for name, digest in digests if digest]

    def _reach(self, start: list[tuple[str, str]]) -> set[tuple[str, str]]:
        """Definitions, by module and name, that these use directly or indirectly, with these themselves."""
        visited: set[tuple[str, str]] = set()
        pending = [*start]
        while pending:
            definition = pending.pop()
            if definition in visited:
                continue
            visited.add(definition)
            module_name, name = definition
            module, parts = self._module(module_name), module_name.split(".")
            # Python runs a package's statements before those of its modules.
            pending += [(".".join(parts[:end]), MODULE_LEVEL) for end in range(1, len(parts) + 1)]
            for used in module.definitions[name][1]:
                first = used.split(".")[0]
                pending += [(module_name, first)] if first in module.definitions else self._resolve(module, used)
        return visited

    def _resolve(self, source: Module, used: str) -> Iterator[tuple[str, str]]:
        """Definitions of the packages that a name in a source refers to; none for a name from elsewhere."""
        first, *attributes = used.split(".")
        parts = [*source.imported.get(first, "").split("."), *attributes]
        for end in range(len(parts), 0, -1):
            module = ".".join(parts[:end])
            if self._path(module):
                yield from self._defined(module, parts[end:])
                return

    def _defined(self, module_name: str, attributes: list[str]) -> Iterator[tuple[str, str]]:
        """Definitions behind an attribute of a module: its own, an imported one, or else the whole module."""
        module = self._module(module_name)
        if attributes and attributes[0] in module.definitions:
            yield module_name, attributes[0]
        elif attributes and attributes[0] in module.imported:
            yield from self._resolve(module, ".".join(attributes))
        else:
            yield from self._whole(module_name)

    def _whole(self, module: str) -> list[tuple[str, str]]:
        return [(module, name) for name in self._module(module).definitions]

    def _path(self, name: str) -> Path | None:
        """File of a module of the packages, and nothing for any other name."""
        top, *rest = name.split(".")
        if top not in self._packages:
            return None
        path = self._packages[top].joinpath(*rest)
        return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.is_file()), None)

    def _module(self, name: str) -> Module:
        if name not in self._modules:
            self._modules[name] = parse(self._path(name))
        return self._modules[name]


def parse(file: Path | None) -> Module:
    """Definitions of a source with the names that each uses, and what its imports bring; nothing of no file."""
    tree = _Bare().visit(ast.parse(file.read_bytes() if file else b""))
    imported: dict[str, str] = {}
    parts: dict[str, list[ast.AST]] = {MODULE_LEVEL: []}
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
            for name in _defines(statement) or [MODULE_LEVEL]:
                parts.setdefault(name, []).append(statement)
    names = {name: sorted({used for node in nodes for used in _used(node)}) for name, nodes in parts.items()}
    idle = imported.keys() - {used.split(".")[0] for node in tree.body for used in _used(node, annotations=True)}
    names[MODULE_LEVEL] += sorted(idle) + dotted  # imported for what loading does
    texts = {
        name: "".join(map(ast.dump, nodes)).encode() + (_contents(file.parent, nodes) if file else b"")
        for name, nodes in parts.items()
    }
    digests = {name: hashlib.sha256(text).hexdigest() if text else "" for name, text in texts.items()}
    return Module({name: (digest, names[name]) for name, digest in digests.items()}, imported)


def _contents(folder: Path, nodes: Iterable[ast.AST]) -> bytes:
    """Contents of the files in a folder that statements name."""
    texts = [each.value for node in nodes for each in ast.walk(node) if isinstance(each, ast.Constant)]
    files = [folder / text for text in texts if isinstance(text, str) and re.fullmatch(r"[\w-]+\.\w+", text)]
    return b"".join(file.read_bytes() for file in files if file.is_file())


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


def _used(node: ast.AST, annotations: bool = False) -> Iterator[str]:
    """Names that a definition uses, with attributes: ``numpy.sin``; those of annotations do nothing in a run."""
    if isinstance(node, ast.Name):
        yield node.id
    elif isinstance(node, ast.Attribute):
        inner = list(_used(node.value, annotations))
        whole = isinstance(node.value, ast.Name | ast.Attribute) and len(inner) == 1
        yield from [f"{inner[0]}.{node.attr}"] if whole else inner
    else:
        for name, value in ast.iter_fields(node):
            if annotations or name not in ("annotation", "returns"):
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST):
                        yield from _used(child, annotations)
