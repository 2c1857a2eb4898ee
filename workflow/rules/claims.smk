# The ledger of published numbers next to ours, and its check.
rule claims:
    input:
        **LEDGER_SOURCES,
    output:
        report(
            f"{RESULTS}/claims.csv",
            category="Claims",
            labels={"what": "Ledger of every published number"},
            caption="../report/claims.rst",
        ),
        f"{RESULTS}/claims.md",
        f"{RESULTS}/claims.sha256",
    log:
        f"{LOGS}/claims.log",
    benchmark:
        f"{BENCHMARKS}/claims.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.paper.ledger:write_ledger"),
        results=Path(RESULTS),
        config=LEDGER_SECTIONS,
    message:
        "Ledger of every published number"
    script:
        CALL


# A rule of its own: Snakemake deletes what a failed one has written, and the ledger must stay to be read.
rule verify:
    input:
        **LEDGER_SOURCES,
        ledger=LEDGER,
    output:
        f"{RESULTS}/verified.txt",
    log:
        f"{LOGS}/verify.log",
    benchmark:
        f"{BENCHMARKS}/verify.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.paper.ledger:verified"),
        results=Path(RESULTS),
        config={**LEDGER_SECTIONS, **stated(SETTINGS, "claims")},
    message:
        "Verifying the ledger"
    script:
        CALL
