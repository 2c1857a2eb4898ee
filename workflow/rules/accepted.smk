# Which experiments the printed numbers do not rule out. Needs the extra matching; what all is made from is the kept
# data/experiments.
rule match_start:
    output:
        f"{R}/matching/{{hypothesis}}-{{start}}.json",
    resources:
        runtime=30,
    params:
        *call("repro.matching.search:fit_start"),
        config=sections("signals", "board", "experiment", "matching"),
    message:
        "Matching experiments, hypothesis {wildcards.hypothesis}, start {wildcards.start}"
    script:
        CALL


rule match:
    input:
        starts=[
            f"{R}/matching/{hypothesis}-{start}.json"
            for hypothesis, count in enumerate(config["matching"]["starts"])
            for start in range(count)
        ],
    output:
        starts=f"{R}/matching/starts.csv",
        experiments=f"{R}/matching/accepted.csv",
        misfits=f"{R}/matching/misfits.csv",
    params:
        *call("repro.matching.search:collect"),
        config=sections("signals", "board", "experiment"),
    message:
        "Experiments that the printed numbers do not rule out"
    script:
        CALL


ACCEPTED = config["accepted"]["experiments"]
# The network of an experiment is trained with its unit of omega.
UNITS = experiment_units(Path(ACCEPTED))


rule simulate_accepted:
    input:
        experiments=ACCEPTED,
    output:
        out=f"{R}/accepted/recordings.safetensors",
    params:
        *call("repro.pipeline.accepted:simulate_accepted"),
        config=sections("signals", "board", "experiment"),
    message:
        "Simulating the accepted experiments"
    script:
        CALL


rule search_accepted:
    input:
        experiments=ACCEPTED,
        counts=f"{R}/accepted/recordings.safetensors",
        weights=lambda wildcards: f"{R}/{network_of_unit(UNITS[int(wildcards.number)], config['signals']['frequency_reading'])}",
    output:
        f"{R}/accepted/experiment-{{number}}.csv",
    priority: LONG
    resources:
        runtime=120,
    params:
        *call("repro.pipeline.guesses:search_accepted"),
        config=sections(*USED, "board", "experiment", "accepted"),
    message:
        "Identifying accepted experiment {wildcards.number}"
    script:
        CALL
