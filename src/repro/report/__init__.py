"""The report: one HTML file that holds the verdicts, the ledger, every table and every figure, and opens offline."""
