# Rebuilds every table and figure. The workflow is workflow/Snakefile, where those who find workflows look for it.
include: "workflow/Snakefile"


# An included file has no default target of its own.
workflow.default_target = "all"
