CODE = CodeDigests(Path(".snakemake/code.json"))


def code(script, *modules):
    """Digest of the code that a script reaches, and of further modules; a docstring changes nothing."""
    return CODE.of_script(HERE / "scripts" / script, *modules)


def network_name(wildcards):
    """Network of a suffix."""
    return wildcards.suffix.removeprefix("-") or "published"


def sections(*names, of=config):
    """Parts of the configuration that jobs depend on: changing another part does not run them again."""
    parts = {name: of[name] for name in names}
    if "numeric" in parts:  # one more seed changes nothing for the jobs that work on one motion or one arm
        parts["numeric"] = {key: value for key, value in config["numeric"].items() if key != "seeds"}
    if "experiment" in parts:  # likewise
        parts["experiment"] = {key: value for key, value in config["experiment"].items() if key != "search_seeds"}
    return parts


def network_sections(*names):
    """The same parts, as the network of a job changes them."""
    return lambda wildcards: sections(*names, of=of_network(config, network_name(wildcards)))


def trained_as(wildcards):
    """What the weights of a job's network say of themselves."""
    return configuration_digest(of_network(config, network_name(wildcards)))


def training_sections(wildcards):
    """What one network depends on; of where it comes from, stored networks only."""
    parts = training_config(of_network(config, network_name(wildcards)))
    source = {key: config["training"][key] for key in ("source", "networks")}
    return {**parts, "training": {**parts["training"], **source}}


# Networks of the tables, by the suffix of their files; the paper's own recipe is a target of its own.
SUFFIXES = ["", "-scale-aware", "-tracked"]


def is_stored(wildcards):
    """Whether a network is taken from those that come with the project."""
    return config["training"]["source"] == "stored" and wildcards.suffix in SUFFIXES


def stored_network(wildcards):
    """Files that a stored network is read from; one that is trained needs none."""
    stored = stored_files(config["training"]["networks"], wildcards.suffix)
    return list(stored.values()) if is_stored(wildcards) else []


def tracked_motions(wildcards):
    """Motions that a network is trained on, where they are not Eq. 10's own."""
    motions = of_network(config, network_name(wildcards))["data"]["motions"]
    return [] if is_stored(wildcards) or motions == "ideal" else f"{R}/data/tracked.safetensors"


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
    return [f"{stored}/{wildcards.motion}.{ext}" for ext in ("bin", "program", "json")] if stored else []


def captures(motions):
    """Captures of these motions with their sidecars."""
    return expand(f"{R}/experiment/{{motion}}.{{ext}}", motion=motions, ext=["bin", "program", "json"])


def experiment_identifications():
    """Identifications of the arm: every network with every seed, and least squares."""
    numbered = expand(
        f"{R}/identification/experiment{{suffix}}-seed{{seed}}.json",
        suffix=SUFFIXES,
        seed=config["experiment"]["search_seeds"],
    )
    return [*numbered, f"{R}/identification/experiment-least-squares.json"]


def spread_scores():
    """Scores of every identification duration."""
    return expand(f"{R}/spread/scores-{{index}}.csv", index=range(len(config["spread"]["durations_s"])))


def network_of(reading):
    """Network that a reading uses: its own, or another reading's."""
    return reading if READINGS[reading].trained else READINGS[reading].of


def ablation_sections():
    """What the runs of the ablation depend on, whatever the reading."""
    return sections(
        "signals",
        "network",
        "data",
        "image",
        "training",
        "networks",
        "metric",
        "algorithm1",
        "refinement",
        "numeric",
        "arm",
        "board",
        "experiment",
        "ablation",
    )


def ledger_sources():
    """What the ledger is made from, and what its tables are made from: changed afterwards, its verification fails."""
    stored = config["experiment"]["captures"] if config["experiment"]["source"] == "stored" else None
    return {
        "captures": [f"{stored}/SHA256SUMS"] if stored else [],
        "tables": expand(f"{R}/tables/{{table}}.{{ext}}", table=ALL_TABLES, ext=["csv", "tex", "md"]),
        "training": f"{R}/model/training.csv",
        "scores": [f"{R}/validation/numeric.csv", f"{R}/validation/experiment.csv"],
        "identifications": [*identifications(SUFFIXES), *experiment_identifications()],
    }


def ledger_sections():
    """Settings that are held against published ones."""
    return sections(
        "signals", "metric", "data", "training", "networks", "algorithm1", "numeric", "arm", "board", "experiment"
    )
