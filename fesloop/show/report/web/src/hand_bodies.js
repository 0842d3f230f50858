// The bodies of the scene: a mesh a segment of each hand, and what else stands there.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, DoubleSide, Group, Mesh, MeshLambertMaterial,
  PlaneGeometry, SphereGeometry,
} from "three";

const GEOMETRY = {
  cylinder: () => new CylinderGeometry(1, 1, 2, 48).rotateX(Math.PI / 2), // its axis is z
  sphere: () => new SphereGeometry(1, 40, 24),
  box: () => new BoxGeometry(2, 2, 2),
  plane: () => new PlaneGeometry(2, 2),
};

// Where a translucent hand lies on the solid one, the solid one is seen: what is translucent is a difference.
const BEHIND = { polygonOffsetFactor: 2, polygonOffsetUnits: 2 };

/** A hand's segments; `seen` of 1 is solid, less is translucent. */
export function handBodies(meshes, seen) {
  const behind = seen < 1 ? { transparent: true, opacity: seen, polygonOffset: true, ...BEHIND } : {};
  const material = new MeshLambertMaterial(behind);
  const group = new Group();
  for (const { vertices, faces } of meshes) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(vertices, 3));
    geometry.setIndex(new BufferAttribute(faces, 1));
    geometry.computeVertexNormals();
    group.add(new Mesh(geometry, material));
  }
  group.renderOrder = seen < 1 ? 2 : 1;
  return { group, material };
}

/** Something else that is seen; one that does not move is put where it stands. */
export function solidBody({ kind, half_sizes, moves, pose }) {
  const geometry = GEOMETRY[kind]().scale(...half_sizes.map((size) => size || 1));
  const material = new MeshLambertMaterial(kind === "plane" ? { side: DoubleSide } : {});
  const body = new Mesh(geometry, material);
  if (!moves) place(body, pose);
  return { body, material };
}

/** Puts a body where a pose [w, x, y, z, east, north, up] says; one that is not known is not seen. */
export function place(body, [w, x, y, z, east, north, up]) {
  body.visible = [w, x, y, z, east, north, up].every(Number.isFinite);
  if (!body.visible) return;
  body.quaternion.set(x, y, z, w);
  body.position.set(east, north, up);
}
