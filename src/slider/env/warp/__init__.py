"""Physics on MuJoCo Warp: torch tensors on a device, for training; needs the extra ``gpu``."""
