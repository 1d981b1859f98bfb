"""The stage graph, and the interface of the Snakefile to it."""
