"""Questions beyond the paper's tables: learned methods in many conditions, causes crossed, other interpretations."""
