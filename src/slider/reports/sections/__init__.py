"""Sections of the page, one module each but for those that show a report as it is."""
