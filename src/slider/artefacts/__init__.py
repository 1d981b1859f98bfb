"""The content-addressed store of artefacts, recipes, plans and their execution."""
