# The board as a design in logic.
# Needs the extra rtl. `all` reads the kept data/board/size.csv.
rule synthesise_board:
    input:
        sorted(map(str, (HERE.parent / "rtl").glob("*.py"))),
    output:
        f"{RESULTS}/board/size.csv",
    log:
        f"{LOGS}/synthesise_board.log",
    benchmark:
        f"{BENCHMARKS}/synthesise_board.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.board.logic:board_size"),
    message:
        "Synthesising the board in logic"
    script:
        CALL
