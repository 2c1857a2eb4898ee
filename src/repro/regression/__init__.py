"""From a log to a linear regression: filters, cut-off, delay, regressor and torque through one filter."""
