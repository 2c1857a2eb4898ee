"""Runs a script of the workflow as its rule does, in this process."""

import runpy
from pathlib import Path
from types import SimpleNamespace

from repro.pipeline import job

SCRIPTS = Path(__file__).resolve().parents[1] / "workflow" / "scripts"


class Files(list):
    """Files of a rule: by position, and by name where they have one."""

    def __init__(self, named):
        self._named = {
            name: str(file) if isinstance(file, str | Path) else [*map(str, file)] for name, file in named.items()
        }
        flat = [file for files in self._named.values() for file in (files if isinstance(files, list) else [files])]
        super().__init__(flat)

    def __getattr__(self, name):
        try:
            return self._named[name]
        except KeyError as error:
            raise AttributeError(name) from error

    def items(self):
        return self._named.items()

    def get(self, name, default=None):
        return self._named.get(name, default)


def run_script(name, inputs, outputs, folder, wildcards=(), **params):
    """Run it; an `InputError` comes through, since no job catches it."""
    told = SimpleNamespace(
        input=Files(inputs),
        output=Files(outputs),
        params=SimpleNamespace(**params),
        wildcards=SimpleNamespace(**dict(wildcards)),
        log=[str(Path(folder) / "script.log")],
        threads=1,
    )
    kept, job.job = job.job, lambda *_: _Open()
    try:
        runpy.run_path(str(SCRIPTS / f"{name}.py"), {"snakemake": told})
    finally:
        job.job = kept


class _Open:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        return False
