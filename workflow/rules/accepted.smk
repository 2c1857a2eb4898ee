# Which experiments the printed numbers do not rule out. The first two rules need the extra matching; `all` reads the
# kept data/experiments.
rule match_start:
    output:
        f"{R}/matching/{{hypothesis}}-{{start}}.json",
    resources:
        runtime=30,
    params:
        *call("repro.matching.search:fit_start"),
        config=sections(*ARM, "matching"),
    message:
        "Matching experiments, hypothesis {wildcards.hypothesis}, start {wildcards.start}"
    script:
        CALL


rule match:
    input:
        starts=[
            f"{R}/matching/{hypothesis}-{start}.json"
            for hypothesis, count in enumerate(SETTINGS.matching.starts)
            for start in range(count)
        ],
    output:
        starts=f"{R}/matching/starts.csv",
        experiments=f"{R}/matching/accepted.csv",
        misfits=f"{R}/matching/misfits.csv",
    params:
        *call("repro.matching.search:collect"),
        config=sections(*ARM),
    message:
        "Experiments that the printed numbers do not rule out"
    script:
        CALL


EXPERIMENTS = SETTINGS.accepted.experiments
ACCEPTED = {"experiments": EXPERIMENTS, "recordings": f"{R}/accepted/recordings.safetensors"}
UNITS = experiment_units(Path(EXPERIMENTS))


rule simulate_accepted:
    input:
        experiments=EXPERIMENTS,
    output:
        out=f"{R}/accepted/recordings.safetensors",
    priority: LONG
    params:
        *call("repro.experiments.accepted:simulate_accepted"),
        config=sections(*ARM),
    message:
        "Simulating the accepted experiments"
    script:
        CALL


rule score_spread:
    input:
        **ACCEPTED,
        weights=expand(f"{R}/model/cnn{{suffix}}.safetensors", suffix=["", "-tracked"]),
        mean_torque=MEAN_TORQUE,
    output:
        f"{R}/accepted/methods.csv",
    priority: LONG
    resources:
        runtime=30,
    params:
        *call("repro.experiments.networks:score_spread"),
        trained_as={name: configuration_digest(of_network(SETTINGS, name)) for name in ("published", "tracked")},
        config=sections(*USED, *ARM, "networks", "spread"),
    message:
        "Every method on the accepted experiments"
    script:
        CALL


rule search_accepted:
    input:
        **ACCEPTED,
        weights=accepted_weights,
    output:
        f"{R}/accepted/experiment-{{number}}.csv",
    priority: LONG
    resources:
        runtime=120,
    params:
        *call("repro.experiments.guesses:search_accepted"),
        config=sections(*USED, *ARM, "networks", "accepted"),
    message:
        "Algorithm 1 on accepted experiment {wildcards.number}"
    script:
        CALL
