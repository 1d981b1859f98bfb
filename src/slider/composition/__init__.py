"""From ``conf/``, overrides and robot files to a validated configuration: all code using Hydra."""
