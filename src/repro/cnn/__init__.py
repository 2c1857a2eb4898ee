"""The signal image, the training data and the convolutional network that reads parameter residuals off it."""
