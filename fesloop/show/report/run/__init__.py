"""The report of one run: from its recording to a page, a module a section."""
