"""`repro identify`: a user's log, the methods, what they are worth, and the files that say so."""
