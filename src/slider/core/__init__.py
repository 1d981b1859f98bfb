"""Configuration, artefact store, recipes, seeding and tracking."""
