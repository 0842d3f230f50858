"""Results of a study: tables, estimates with their intervals, paired comparisons."""
