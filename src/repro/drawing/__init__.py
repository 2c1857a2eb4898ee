"""How figures, tables and pages look: shared by the paper's exhibits and the reports of a user's arm."""
