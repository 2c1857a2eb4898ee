rule claims:
    input:
        **ledger_sources(),
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
        *code("claims.py"),
        config=ledger_sections(),
    message:
        "Ledger of every published number"
    script:
        "../scripts/claims.py"


# A rule of its own: Snakemake deletes what a failed one has written, and the ledger must stay to be read.
rule verify:
    input:
        **ledger_sources(),
        ledger=[f"{R}/claims.csv", f"{R}/claims.md", f"{R}/claims.sha256"],
    output:
        f"{R}/verified.txt",
    params:
        *code("verify.py"),
        config={**ledger_sections(), "claims": config["claims"]},
    message:
        "Verifying the ledger"
    script:
        "../scripts/verify.py"
