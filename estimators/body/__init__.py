"""What trackers know of the body: segments, joints, and what joints say about orientations."""
