"""Methods that turn a regression into nine parameters: one file each, one interface, listed in `methods`."""
