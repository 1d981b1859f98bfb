"""Results that travel: through a folder, ssh, S3 or HTTP."""
