"""A user's recording of an arm: from a file to SI arrays, and what is odd about it."""
