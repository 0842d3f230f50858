"""Virtual patients: from a file to the parameters of blocks; how people and days differ."""
