"""What a study found: tables, estimates with their intervals, comparisons by pairs."""
