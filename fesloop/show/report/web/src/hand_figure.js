// A hand's shapes and motion, with arrays in place of the arrays' places.

/** What `createHand` draws, from a page's part. */
export function handFigure(part, array) {
  const mesh = ({ vertices, faces }) => ({ vertices: Float32Array.from(array(vertices)), faces: array(faces) });
  const poses = ({ frames, bodies, orientations, positions }) => ({
    frames, bodies, orientations: array(orientations), positions: array(positions),
  });
  const each = (all, change) => Object.fromEntries(Object.entries(all).map(([key, one]) => [key, change(one)]));
  const motion = ({ start_s, step_s, hands, objects }) => ({
    start: start_s, step: step_s, hands: each(hands, poses), objects: poses(objects),
  });
  return {
    view: part.view,
    shapes: each(part.shapes, (meshes) => meshes.map(mesh)),
    objects: part.objects,
    motions: new Map(Object.entries(part.trials).map(([trial, frames]) => [Number(trial), motion(frames)])),
  };
}

/** How many frames a motion has. */
export function framesOf({ hands, objects }) {
  return Math.max(objects.frames, ...Object.values(hands).map(({ frames }) => frames), 0);
}
