def sections(*names):
    """Parts of the configuration that jobs depend on: changing another part does not run them again."""
    parts = {name: config[name] for name in names}
    if "numeric" in parts:  # each seed is a job of its own, so one more seed changes nothing for the others
        parts["numeric"] = {key: value for key, value in config["numeric"].items() if key != "seeds"}
    return parts


def identifications(suffixes):
    """Results of every seed for the networks with these suffixes."""
    return expand(
        f"{R}/identification/numeric{{suffix}}-seed{{seed}}.json",
        suffix=suffixes,
        seed=config["numeric"]["seeds"],
    )
