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


def stored_capture(wildcards):
    """Files that a stored capture is read from; a simulated or real board needs none."""
    stored = config["experiment"]["captures"] if config["experiment"]["source"] == "stored" else None
    return [f"{stored}/{wildcards.motion}.{ext}" for ext in ("bin", "json")] if stored else []


def captures(motions):
    """Captures of these motions with their sidecars."""
    return expand(f"{R}/experiment/{{motion}}.{{ext}}", motion=motions, ext=["bin", "json"])


def experiment_identifications():
    """Identifications of the arm: both networks with every seed, and least squares."""
    numbered = expand(
        f"{R}/identification/experiment{{suffix}}-seed{{seed}}.json",
        suffix=["", "-scale-aware"],
        seed=config["experiment"]["search_seeds"],
    )
    return [*numbered, f"{R}/identification/experiment-least-squares.json"]


def spread_scores():
    """Scores of every identification duration."""
    return expand(f"{R}/spread/scores-{{index}}.csv", index=range(len(config["spread"]["durations_s"])))
