"""How the relaxed hand lies, the wrist neutral."""

from __future__ import annotations

FINGER_RESTS_DEG = {"F2": (25.0, 35.0, 15.0), "F3": (30.0, 38.0, 15.0), "F4": (33.0, 40.0, 15.0),
                    "F5": (35.0, 40.0, 15.0)}
"""MCP, PIP, DIP. Chosen: the usual cascade, more flexed towards the little finger."""
RESTING_DEG: dict[str, float] = {
    "wrist_flexion": 0.0, "wrist_abduction": 0.0,
    "F1_cmc_flexion": 40.0, "F1_cmc_abduction": -25.0, "F1_cmc_pronation": 70.0,
    "F1_mcp_flexion": 15.0, "F1_ip_flexion": 20.0,
    **{f"{finger}_{joint}": angle for finger, (mcp, pip, dip) in FINGER_RESTS_DEG.items()
       for joint, angle in (("mcp_flexion", mcp), ("mcp_abduction", 0.0), ("pip_flexion", pip),
                            ("dip_flexion", dip))},
}
"""By freedom, in the order of the hand's. Thumb: chosen, beside the index finger, its nail half turned."""
