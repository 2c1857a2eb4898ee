"""What a simulator or a bibliography takes: a set of links that has the parameters, URDF, MJCF and BibTeX."""
