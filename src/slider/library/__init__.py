"""The gait library: assembled from gaits, looked up by velocity, interpolated."""
