"""Makes one exhibit: its numbers, then its layouts or its drawing from them."""

from repro.exhibits.catalogue import Kind
from repro.files import write_csv
from repro.pipeline.named import Config, Named, paths
from repro.pipeline.outputs import FIGURE_DATA, TABLE_DATA
from repro.render.figures import draw
from repro.render.tables import lay_out


def make_exhibit(kind: Kind, name: str, named_inputs: Named, named_outputs: Named, config: Config) -> None:
    """Write an exhibit's tidy table, then its TeX and Markdown, or its PDF and PNG."""
    out = {key: files[0] for key, files in paths(named_outputs).items()}
    numbers = (TABLE_DATA if kind == "table" else FIGURE_DATA)[name]
    write_csv(out["csv"], numbers(paths(named_inputs), config))
    if kind == "table":
        lay_out(name, out["csv"], out["tex"], out["md"])
    else:
        draw(name, out["csv"], out["pdf"], out["png"])
