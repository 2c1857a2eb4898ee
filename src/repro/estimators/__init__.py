"""Methods that turn a regression into nine parameters: one file each, one interface, found by `methods`."""
