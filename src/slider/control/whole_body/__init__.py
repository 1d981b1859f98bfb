"""Parts shared by walking controllers: model, whole-body QP, modes, entry and observer."""
