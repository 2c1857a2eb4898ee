# A port can be opened once.
SERIAL = config["experiment"]["source"] == "serial"
if SERIAL:
    workflow.register_resource("serial_port", 1)


rule acquire:
    input:
        stored_capture,
    output:
        f"{R}/experiment/{{motion}}.bin",
        f"{R}/experiment/{{motion}}.program",
        f"{R}/experiment/{{motion}}.json",
    priority: AWAITED
    # A port hangs on the computer where the run is started.
    localrule: True
    resources:
        serial_port=int(SERIAL),
    params:
        *code("acquire.py"),
        config=sections(*ARM),
    message:
        "Capture of {wildcards.motion}"
    script:
        "../scripts/acquire.py"


rule identify_experiment:
    input:
        captures=captures(["ID"]),
        weights=lambda wildcards: weights(wildcards.suffix),
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        expand(
            f"{R}/identification/experiment{{suffix}}-seed{{seed}}.json",
            seed=config["experiment"]["search_seeds"],
            allow_missing=True,
        ),
    priority: LONG
    params:
        *code("identify_experiment.py"),
        seeds=config["experiment"]["search_seeds"],
        trained_as=trained_as,
        config=network_sections(*ARM),
    message:
        "Identifying the arm, network{wildcards.suffix}"
    script:
        "../scripts/identify_experiment.py"


rule identify_least_squares:
    input:
        captures=captures(["ID"]),
    output:
        f"{R}/identification/experiment-least-squares.json",
    params:
        *code("identify_least_squares.py"),
        config=sections(*ARM),
    message:
        "Identifying the arm by least squares"
    script:
        "../scripts/identify_least_squares.py"


# Without a suffix the networks of the tables and least squares together.
rule score_experiment:
    input:
        captures=captures(PROGRAMS),
        identifications=lambda wildcards: experiment_identifications(wildcards.suffix),
    output:
        f"{R}/validation/experiment{{suffix}}.csv",
    params:
        *code("score_experiment.py"),
        config=sections(*ARM, "metric"),
    message:
        f"Scoring the arm's estimates on ID and {SPAN}, network{{wildcards.suffix}}"
    script:
        "../scripts/score_experiment.py"


rule simulate_spread:
    output:
        f"{R}/spread/recordings.safetensors",
    priority: LONG
    params:
        *code("simulate_spread.py"),
        config=sections(*ARM, "data", "spread"),
    message:
        "Simulating many specimens of the arm"
    script:
        "../scripts/simulate_spread.py"


rule score_spread:
    input:
        recordings=f"{R}/spread/recordings.safetensors",
        weights=expand(f"{R}/model/cnn{{suffix}}.safetensors", suffix=["", "-tracked"]),
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        f"{R}/spread/scores-{{index}}.csv",
    priority: LONG
    resources:
        runtime=30,
    params:
        *code("score_spread.py"),
        trained_as={name: configuration_digest(of_network(config, name)) for name in ("published", "tracked")},
        config=sections(*USED, *ARM, "networks", "spread"),
    message:
        "Identifying and scoring many specimens, identification duration {wildcards.index}"
    script:
        "../scripts/score_spread.py"
