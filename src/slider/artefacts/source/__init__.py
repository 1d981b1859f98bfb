"""What code a stage runs, and the digests of its parts."""
