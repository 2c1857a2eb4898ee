# The arm behind the board: captures, identification by networks and by least squares, scores. Tables 8 to 10.

# A port can be opened once.
SERIAL = SETTINGS.experiment.source == "serial"
if SERIAL:
    workflow.register_resource("serial_port", 1)


rule acquire:
    input:
        lambda wildcards: BOARD_DESIGN if SETTINGS.experiment.source == "rtl" else present_files(wildcards.motion),
    output:
        out=f"{RESULTS}/experiment/{{motion}}.bin",
        program=f"{RESULTS}/experiment/{{motion}}.program",
        sidecar=f"{RESULTS}/experiment/{{motion}}.json",
    log:
        f"{LOGS}/acquire-{{motion}}.log",
    benchmark:
        f"{BENCHMARKS}/acquire-{{motion}}.tsv"
    priority: AWAITED
    # A port hangs on the computer where the run is started.
    localrule: True
    conda:
        ENVIRONMENT
    resources:
        serial_port=int(SERIAL),
    params:
        *call("repro.experiments.arm:acquire"),
        config=sections(*ARM_SECTIONS),
    message:
        "Capture of {wildcards.motion}"
    script:
        CALL


rule identify_experiment:
    input:
        captures=captures(["ID"]),
        weights=lambda wildcards: weights(wildcards.suffix),
        mean_torque=MEAN_TORQUE,
    output:
        expand(
            f"{RESULTS}/identification/experiment{{suffix}}-seed{{seed}}.json",
            seed=SETTINGS.experiment.search_seeds,
            allow_missing=True,
        ),
    log:
        f"{LOGS}/identify_experiment{{suffix}}.log",
    benchmark:
        f"{BENCHMARKS}/identify_experiment{{suffix}}.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    resources:
        runtime=30,
    params:
        *call("repro.experiments.networks:identify_experiment"),
        seeds=SETTINGS.experiment.search_seeds,
        trained_as=trained_as,
        config=network_sections(*ARM_SECTIONS),
    message:
        "Identifying the arm, network{wildcards.suffix}"
    script:
        CALL


rule identify_least_squares:
    input:
        captures=captures(["ID"]),
    output:
        f"{RESULTS}/identification/experiment-least-squares.json",
    log:
        f"{LOGS}/identify_least_squares.log",
    benchmark:
        f"{BENCHMARKS}/identify_least_squares.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.identifications:identify_least_squares"),
        config=sections(*ARM_SECTIONS),
    message:
        "Identifying the arm by least squares"
    script:
        CALL


# Without a suffix the networks of the tables and least squares together.
rule score_experiment:
    input:
        captures=captures(PROGRAMS),
        identifications=lambda wildcards: experiment_identifications(wildcards.suffix),
    output:
        f"{RESULTS}/validation/experiment{{suffix}}.csv",
    log:
        f"{LOGS}/score_experiment{{suffix}}.log",
    benchmark:
        f"{BENCHMARKS}/score_experiment{{suffix}}.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.identifications:score_experiment"),
        config=sections(*ARM_SECTIONS, "metric"),
    message:
        f"Scoring the arm's estimates on ID and {SPAN}, network{{wildcards.suffix}}"
    script:
        CALL
