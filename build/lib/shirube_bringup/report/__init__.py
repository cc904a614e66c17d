"""The mission's report: a page with pictures."""
