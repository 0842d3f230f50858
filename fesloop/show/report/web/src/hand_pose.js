// Poses between the frames of a motion.
import { Quaternion } from "three";

const from = new Quaternion();
const to = new Quaternion();

/**
 * Poses of bodies at an instant, between two frames turned and moved evenly.
 *
 * @param poses {frames, bodies, orientations (w, x, y, z), positions}
 * @param at the instant, in frames from the first
 * @returns [w, x, y, z, east, north, up] of each body; NaN where it is not known
 */
export function posesAt({ frames, bodies, orientations, positions }, at) {
  if (frames === 0) return [];
  const first = Math.min(Math.max(Math.floor(at), 0), frames - 1);
  const second = Math.min(first + 1, frames - 1);
  const share = Math.min(Math.max(at - first, 0), 1);
  return Array.from({ length: bodies }, (_, body) => {
    const [a, b] = [first * bodies + body, second * bodies + body];
    from.set(orientations[4 * a + 1], orientations[4 * a + 2], orientations[4 * a + 3], orientations[4 * a]);
    to.set(orientations[4 * b + 1], orientations[4 * b + 2], orientations[4 * b + 3], orientations[4 * b]);
    if (share > 0) from.normalize().slerp(to.normalize(), share);
    const along = (axis) => positions[3 * a + axis] + share * (positions[3 * b + axis] - positions[3 * a + axis]);
    return [from.w, from.x, from.y, from.z, along(0), along(1), along(2)];
  });
}
