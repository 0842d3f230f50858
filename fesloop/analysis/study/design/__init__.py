"""What a study asks: its file, axes, cells, and the metrics that it keeps."""
