"""The report of a study: from its store to a page."""
