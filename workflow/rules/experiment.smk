# A port can be opened once.
SERIAL = SETTINGS.experiment.source == "serial"
if SERIAL:
    workflow.register_resource("serial_port", 1)

# The board in logic, with what simulates it.
LOGIC = sorted(map(str, (HERE.parent / "rtl").glob("*.*")))


rule acquire:
    input:
        lambda wildcards: LOGIC if SETTINGS.experiment.source == "rtl" else present_files(wildcards.motion),
    output:
        out=f"{R}/experiment/{{motion}}.bin",
        program=f"{R}/experiment/{{motion}}.program",
        sidecar=f"{R}/experiment/{{motion}}.json",
    priority: AWAITED
    # A port hangs on the computer where the run is started.
    localrule: True
    resources:
        serial_port=int(SERIAL),
    params:
        *call("repro.experiments.arm:acquire"),
        config=sections(*ARM),
    message:
        "Capture of {wildcards.motion}"
    script:
        CALL


# Needs the extra rtl. What all is made from is the kept data/board/size.csv.
rule synthesise_board:
    input:
        sorted(map(str, (HERE.parent / "rtl").glob("*.py"))),
    output:
        f"{R}/board/size.csv",
    params:
        *call("repro.board.logic:board_size"),
    message:
        "Synthesising the board in logic"
    script:
        CALL


rule identify_experiment:
    input:
        captures=captures(["ID"]),
        weights=lambda wildcards: weights(wildcards.suffix),
        mean_torque=MEAN_TORQUE,
    output:
        expand(
            f"{R}/identification/experiment{{suffix}}-seed{{seed}}.json",
            seed=SETTINGS.experiment.search_seeds,
            allow_missing=True,
        ),
    priority: LONG
    resources:
        runtime=30,
    params:
        *call("repro.experiments.networks:identify_experiment"),
        seeds=SETTINGS.experiment.search_seeds,
        trained_as=trained_as,
        config=network_sections(*ARM),
    message:
        "Identifying the arm, network{wildcards.suffix}"
    script:
        CALL


rule identify_least_squares:
    input:
        captures=captures(["ID"]),
    output:
        f"{R}/identification/experiment-least-squares.json",
    params:
        *call("repro.experiments.identifications:identify_least_squares"),
        config=sections(*ARM),
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
        f"{R}/validation/experiment{{suffix}}.csv",
    params:
        *call("repro.experiments.identifications:score_experiment"),
        config=sections(*ARM, "metric"),
    message:
        f"Scoring the arm's estimates on ID and {SPAN}, network{{wildcards.suffix}}"
    script:
        CALL
