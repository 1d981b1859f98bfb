"""The stage graph and what the Snakefile needs to run it."""
