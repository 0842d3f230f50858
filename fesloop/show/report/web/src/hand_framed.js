// From how far a camera sees all of some places.
import { Box3, MathUtils, Vector3 } from "three";

const ROOM = 1.06; // times the distance from which all of it is just seen
const NOTHING = [new Vector3(-0.1, -0.1, -0.1), new Vector3(0.1, 0.1, 0.1)];

/**
 * What a camera has to look at, and from how far, to see all of some places from a direction.
 *
 * @param out from the places towards the camera, of length 1
 * @returns middle, that it looks at; radius about it of all places; distance(fov, aspect) of the camera, which stands
 *   upright; `fov` is its field of view from top to bottom, deg
 */
export function framedFrom(places, out) {
  const points = places.length > 0 ? places : NOTHING;
  const right = new Vector3(0, 0, 1).cross(out).normalize();
  const axes = [right, out.clone().cross(right), out];
  const seen = points.map((point) => new Vector3(...axes.map((axis) => axis.dot(point))));
  const centre = new Box3().setFromPoints(seen).getCenter(new Vector3());
  const apart = seen.map((point) => point.sub(centre));
  const [across, upwards, nearer] = centre.toArray();
  const middle = out.clone().multiplyScalar(nearer).addScaledVector(axes[0], across).addScaledVector(axes[1], upwards);
  return {
    middle,
    radius: greatest(apart, (point) => point.length()),
    distance(fov, aspect) {
      const slope = Math.tan(MathUtils.degToRad(fov / 2));
      const needed = ({ x, y, z }) => z + Math.max(Math.abs(x) / (slope * aspect), Math.abs(y) / slope);
      return ROOM * greatest(apart, needed);
    },
  };
}

/** Of what is found of each point; of more of them than a function takes. */
function greatest(points, found) {
  return points.reduce((most, point) => Math.max(most, found(point)), 0);
}
