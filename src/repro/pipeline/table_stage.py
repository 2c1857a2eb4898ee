"""Stage render of one table: its numbers, then the layouts."""

from repro.files import write_csv
from repro.pipeline.named import Config, Named, paths
from repro.pipeline.outputs import TABLE_DATA
from repro.render.tables import lay_out


def make_table(name: str, named_inputs: Named, named_outputs: Named, config: Config) -> None:
    """Stage render: a tidy table, then its TeX and Markdown layouts."""
    out = {key: files[0] for key, files in paths(named_outputs).items()}
    write_csv(out["csv"], TABLE_DATA[name](paths(named_inputs), config))
    lay_out(name, out["csv"], out["tex"], out["md"])
