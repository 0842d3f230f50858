// Where hands and objects are in all of their motion: what the camera has to hold.
import { Box3, BufferAttribute, Quaternion, Vector3 } from "three";
import { posesAt } from "./hand_pose.js";

const SAMPLED = 240; // frames of all motions together, and two of each at the least
// An object is followed so far from the hands' middle (chosen: an arm's length), and so far below the lowest place of a
// hand (chosen: what stands on a table below it): not to the ground that a dropped one falls to.
const FARTHEST_M = 0.6;
const LOWEST_M = 0.1;

/** Corners of boxes about each segment and each object, in frames of all trials. */
export function placesOf({ shapes, objects, motions }) {
  const corners = Object.fromEntries(Object.entries(shapes).map(([name, meshes]) => [name, meshes.map(meshCorners)]));
  const count = Math.max(2, Math.ceil(SAMPLED / motions.size));
  const hands = [...motions.values()].flatMap((motion) => Object.entries(motion.hands)
    .flatMap(([name, poses]) => sampled(poses, count).flatMap((frame) => placed(corners[name] ?? [], frame))));
  const about = new Box3().setFromPoints(hands);
  const middle = about.getCenter(new Vector3());
  const held = objectPlaces(objects, motions, count)
    .filter((place) => place.distanceTo(middle) < FARTHEST_M && place.z > about.min.z - LOWEST_M);
  return [...hands, ...held];
}

/** Of what hands hold; not of what they lie on, which reaches far beyond them. */
function objectPlaces(objects, motions, count) {
  const held = (object) => (object.role === "surface" ? [] : solidCorners(object));
  const moving = objects.filter(({ moves }) => moves).map(held);
  const still = objects.filter(({ moves }) => !moves);
  return [
    ...placed(still.map(held), still.map(({ pose }) => pose)),
    ...[...motions.values()].flatMap((motion) => sampled(motion.objects, count))
      .flatMap((frame) => placed(moving, frame)),
  ];
}

/** Poses in so many frames, evenly spaced, the first and the last among them. */
function sampled(poses, most) {
  const count = Math.min(most, poses.frames);
  return Array.from({ length: count }, (_, i) => posesAt(poses, (i * (poses.frames - 1)) / Math.max(count - 1, 1)));
}

/** Corners of bodies at their poses; none of a body whose pose is not known. */
function placed(corners, poses) {
  return poses.flatMap(([w, x, y, z, ...position], body) => {
    if (![w, x, y, z, ...position].every(Number.isFinite)) return [];
    const turn = new Quaternion(x, y, z, w);
    const at = new Vector3(...position);
    return (corners[body] ?? []).map((corner) => corner.clone().applyQuaternion(turn).add(at));
  });
}

function meshCorners({ vertices }) {
  if (vertices.length === 0) return [];
  return boxCorners(new Box3().setFromBufferAttribute(new BufferAttribute(vertices, 3)));
}

function solidCorners({ half_sizes }) {
  const half = new Vector3(...half_sizes);
  return boxCorners(new Box3(half.clone().negate(), half));
}

function boxCorners({ min, max }) {
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new Vector3(x, y, z))));
}
