def sections(*names):
    """Parts of the configuration that jobs depend on: changing another part does not run them again."""
    return {name: config[name] for name in names}


def identifications(suffixes):
    """Results of every seed for the networks with these suffixes."""
    return expand(
        f"{R}/identification/numeric{{suffix}}-seed{{seed}}.json",
        suffix=suffixes,
        seed=config["numeric"]["seeds"],
    )
