"""Elbow, forearm and wrist with the muscles that electrodes reach: paths, evoked torque, people."""
