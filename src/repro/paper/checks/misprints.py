"""Symbols, units and references that the rest of the paper corrects."""

from repro.paper.checks.finding import MISPRINT, Finding, remark

#: id, place, what is printed, why it cannot be meant, note.
_MISPRINTS = (
    (
        "eq01/coulomb",
        "Eq. 1",
        "Coulomb friction K tanh(lambda q)",
        "friction opposes velocity: K tanh(lambda dq); Appendix A has gamma lambda lambda_K^min in the corner of R1 "
        "that multiplies ||dq||^2",
        "The dot may be lost in the extracted text, which keeps the others of the equation.",
    ),
    (
        "table04/unit-b",
        "Table 4, Table 5",
        "unit of b1 and b2: kg m^2 s",
        "b dq in N m = kg m^2/s^2, dq in 1/s, so b in kg m^2/s",
        "g and k are printed in kg m^2/s^2 = N m, as they must be.",
    ),
    (
        "section4a/image-classes",
        "Section IV-A",
        "two sentences that tell the kinds of training image apart name M_n both times",
        "M_p is labelled with zero residuals, so the first, where the parameters match, is M_p",
        "",
    ),
    (
        "section4b/relu",
        "Section IV-B",
        "ReLU and sigmoid both by Eq. 13",
        "Eq. 12 is max(z, 0), Eq. 13 the sigmoid",
        "",
    ),
    (
        "table04/caption",
        "Table 4",
        "N1 and N1 are the numeric tests 1 and 2",
        "its columns are N1 and N2",
        "",
    ),
    (
        "section6/table09",
        "Section VI",
        "Table 9 for what metr2ev shows in frequency",
        "Table 9 holds parameters; the similarities are in Table 10",
        "",
    ),
)


def misprints() -> list[Finding]:
    """Misprints that can be told from the text."""
    return [remark(id_, place, what, why, MISPRINT, note) for id_, place, what, why, note in _MISPRINTS]
