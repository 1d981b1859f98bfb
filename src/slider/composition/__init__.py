"""From ``conf/``, overrides and robots' files to a checked configuration: all that knows Hydra."""
