"""The subcommands of ``repro``: each a module with `add_arguments` and `run`, its first line being its help."""
