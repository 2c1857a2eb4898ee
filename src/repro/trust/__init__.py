"""What an estimate is worth: excitation, standard errors, residuals, and plain words for them."""
