"""From a study to its results: plan, workers, coordinator."""
