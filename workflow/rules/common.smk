def sections(*names):
    """Parts of the configuration that jobs depend on: changing another part does not run them again."""
    parts = {name: config[name] for name in names}
    if "numeric" in parts:  # each seed is a job of its own, so one more seed changes nothing for the others
        parts["numeric"] = {key: value for key, value in config["numeric"].items() if key != "seeds"}
    if "experiment" in parts:  # likewise
        parts["experiment"] = {key: value for key, value in config["experiment"].items() if key != "search_seeds"}
    return parts


def training_sections(wildcards):
    """What one network's training depends on: its own image, and the paper's schedule only if it is used."""
    image = "scale-aware" if wildcards.suffix == "-scale-aware" else "published"
    parts = sections("signals", "network", "data", "training")
    if wildcards.suffix != "-paper-recipe":
        parts["training"] = {key: value for key, value in config["training"].items() if key != "paper"}
    return {**parts, "images": {image: config["images"][image]}}


def identifications(suffixes):
    """Results of every seed for the networks with these suffixes."""
    return expand(
        f"{R}/identification/numeric{{suffix}}-seed{{seed}}.json",
        suffix=suffixes,
        seed=config["numeric"]["seeds"],
    )
