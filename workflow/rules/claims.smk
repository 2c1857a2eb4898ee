rule claims:
    input:
        **LEDGER_SOURCES,
    output:
        report(
            f"{R}/claims.csv",
            category="Claims",
            labels={"what": "Ledger of every published number"},
            caption="../report/claims.rst",
        ),
        f"{R}/claims.md",
        f"{R}/claims.sha256",
    params:
        *call("repro.paper.ledger:write_ledger"),
        results=Path(R),
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
        f"{R}/verified.txt",
    params:
        *call("repro.paper.ledger:verified"),
        results=Path(R),
        config={**LEDGER_SECTIONS, **stated(SETTINGS, "claims")},
    message:
        "Verifying the ledger"
    script:
        CALL
