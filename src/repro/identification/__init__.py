"""From a regression to parameters: preparations, methods, scores and how far an estimate may be off."""
