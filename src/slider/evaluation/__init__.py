"""The paper's protocol: trials of many robots per controller and command."""

AUDIT = "audit.json"  # of the model in the second engine
