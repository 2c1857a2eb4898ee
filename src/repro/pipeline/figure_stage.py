"""Stage render of one figure: its numbers, then the drawing."""

from repro.files import write_csv
from repro.pipeline.named import Config, Named, paths
from repro.pipeline.outputs import FIGURE_DATA
from repro.render.figures import draw


def make_figure(name: str, named_inputs: Named, named_outputs: Named, config: Config) -> None:
    """Stage render: numbers of a figure, then the figure drawn from them."""
    out = {key: files[0] for key, files in paths(named_outputs).items()}
    write_csv(out["csv"], FIGURE_DATA[name](paths(named_inputs), config))
    draw(name, out["csv"], out["pdf"], out["png"])
