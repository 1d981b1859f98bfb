"""What walking controllers share: model, whole-body QP, modes, entry and observer."""
