"""Reports of the protocols beside that of Table 1: a table, its explanation and a figure each."""
