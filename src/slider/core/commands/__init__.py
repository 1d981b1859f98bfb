"""Subcommands of ``slider`` that belong to the pipeline."""
