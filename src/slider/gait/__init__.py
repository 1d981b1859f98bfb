"""Extended hybrid zero dynamics: one periodic walk per commanded velocity."""

REPORT = "report.json"  # of a solve: convergence, and the worst residual of each constraint
