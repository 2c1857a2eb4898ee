"""The one stage that reads published numbers: which formula of **metr2ev** explains them."""

from repro.files import write_csv
from repro.paper.metric_checks import abstract_check, composition, pair_bounds
from repro.paper.metric_search import search as search_metric
from repro.pipeline.named import Config, Named, paths


def search_metric_formula(named_outputs: Named, config: Config) -> None:
    """Search of the metric's formula and the checks of the published similarities."""
    out = {name: files[0] for name, files in paths(named_outputs).items()}
    settings = config["metric_search"]
    write_csv(out["search"], search_metric(settings["seed"], repeats=settings["repeats"]))
    write_csv(out["composition"], composition())
    write_csv(out["abstract"], abstract_check().cells)
    write_csv(out["bounds"], pair_bounds())
