"""Detection of new, lost, clipped and frozen samples."""
