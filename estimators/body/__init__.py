"""Model of the body for trackers: segments, joints, and their constraints on orientations."""
