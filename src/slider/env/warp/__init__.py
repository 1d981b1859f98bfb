"""Training on MuJoCo Warp, on a GPU or on Warp's processor device."""
