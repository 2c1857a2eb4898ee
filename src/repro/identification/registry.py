"""Names of the methods in the paper's tables, and the solvers of those that are least squares."""

#: In the order of tables and legends; the first is the paper's as listed.
METHODS: tuple[str, ...] = (
    "algorithm1",
    "algorithm1/one-run",
    "algorithm1+desired",
    "algorithm1+tracked-measured",
    "algorithm1+tracked",
    "algorithm1+tracked/one-run",
    "algorithm1+refinement",
    "algorithm1+local-search",
    "differential-evolution",
    "algorithm1+paper-recipe",
    "least-squares",
    "bounded",
    "consistent",
    "true",
    "appendix",
)

#: What Algorithm 1 is compared with, with the name in `repro.identification.methods` of the method that solves it.
OPPONENTS: dict[str, str] = {
    "least-squares": "ordinary",
    "bounded": "bounded",
    "consistent": "consistent",
}
