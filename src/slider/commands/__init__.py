"""The subcommands of ``slider``."""
