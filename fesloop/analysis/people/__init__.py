"""People under stimulation: evoked torque by posture, persons, and the population that they come from."""
