"""The MuJoCo model of a segment tree, an engine that shares no code with ours."""

import mujoco

from fesloop.hand.segments import FREEDOMS


def mujoco_model(tree, sensors=None):
    """A free-floating model: a site named after each segment at its frame, and IMUs at `sensors` if given."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, -9.80665]
    bodies = {}
    for segment, geometry in zip(tree.segments, tree.geometry, strict=True):
        if segment.parent is None:
            body = spec.worldbody.add_body(name=segment.name)
            body.add_freejoint()
        else:
            above = tree.segments[tree.index(segment.parent)]
            body = bodies[segment.parent].add_body(
                name=segment.name, pos=[a + b for a, b in zip(above.offset, segment.base, strict=True)])
            for axis in geometry[:FREEDOMS[segment.joint]]:
                body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        body.mass, body.inertia, body.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
        body.add_site(name=segment.name, pos=segment.offset)
        bodies[segment.name] = body
    for i, (k, place) in enumerate(zip(*(sensors or ((), ())), strict=True)):
        segment = tree.segments[k]
        bodies[segment.name].add_site(name=f"imu{i}", pos=place + segment.offset)
        for kind in (mujoco.mjtSensor.mjSENS_GYRO, mujoco.mjtSensor.mjSENS_ACCELEROMETER):
            spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=f"imu{i}")
    return spec.compile()
