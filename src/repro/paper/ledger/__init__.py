"""Our side of every published number: from result files, the configuration and arithmetic."""
