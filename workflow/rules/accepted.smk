# Methods on the experiments that the search of matching.smk accepted.
rule simulate_accepted:
    input:
        experiments=EXPERIMENTS,
    output:
        out=f"{RESULTS}/accepted/recordings.safetensors",
    log:
        f"{LOGS}/simulate_accepted.log",
    benchmark:
        f"{BENCHMARKS}/simulate_accepted.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.accepted:simulate_accepted"),
        config=sections(*ARM_SECTIONS),
    message:
        "Simulating the accepted experiments"
    script:
        CALL


rule score_spread:
    input:
        **ACCEPTED,
        weights=expand(f"{RESULTS}/model/cnn{{suffix}}.safetensors", suffix=["", "-tracked"]),
        mean_torque=MEAN_TORQUE,
    output:
        f"{RESULTS}/accepted/methods.csv",
    log:
        f"{LOGS}/score_spread.log",
    benchmark:
        f"{BENCHMARKS}/score_spread.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    resources:
        runtime=30,
    params:
        *call("repro.experiments.networks:score_spread"),
        trained_as={name: configuration_digest(of_network(SETTINGS, name)) for name in ("published", "tracked")},
        config=sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS, "networks", "spread"),
    message:
        "Every method on the accepted experiments"
    script:
        CALL


rule search_accepted:
    input:
        **ACCEPTED,
        weights=accepted_weights,
    output:
        f"{RESULTS}/accepted/experiment-{{number}}.csv",
    log:
        f"{LOGS}/search_accepted-{{number}}.log",
    benchmark:
        f"{BENCHMARKS}/search_accepted-{{number}}.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    resources:
        runtime=120,
    params:
        *call("repro.experiments.guesses:search_accepted"),
        config=sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS, "networks", "accepted"),
    message:
        "Algorithm 1 on accepted experiment {wildcards.number}"
    script:
        CALL
