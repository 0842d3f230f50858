// Turning and zooming: by mouse, by one and two fingers, by the keyboard.
import { Vector3 } from "three";
import { framedFrom } from "./hand_framed.js";

const TURN = 0.008; // rad a px
const TURN_KEY = 0.12; // rad a press
const ZOOM_KEY = 1.15; // times a press
const STEEPEST = 1.5; // rad, from level: the camera never tips over

/**
 * Lets the camera be moved round the middle of some places, all of which it holds at first.
 *
 * @param stage the element that is pulled at
 * @param places points that are to be seen; where there are none, those about the origin
 * @param view direction from the camera into the scene
 * @param changed called when the camera has moved
 */
export function createTurn(stage, camera, places, view, changed) {
  const start = anglesOf(new Vector3(...view));
  const framed = framedFrom(places, outwards(start));
  const now = { ...start, zoom: 1 };
  const pointers = new Map();

  function show() {
    const far = framed.distance(camera.fov, camera.aspect) / now.zoom;
    camera.position.copy(framed.middle).addScaledVector(outwards(now), far);
    camera.near = Math.max(far - 4 * framed.radius, far / 100);
    camera.far = far + 6 * framed.radius;
    camera.up.set(0, 0, 1);
    camera.lookAt(framed.middle);
    camera.updateProjectionMatrix();
    changed();
  }

  function turn(right, up) {
    now.azimuth -= right;
    now.elevation = Math.min(STEEPEST, Math.max(-STEEPEST, now.elevation + up));
    show();
  }

  function zoom(times) {
    now.zoom = Math.min(8, Math.max(0.4, now.zoom * times));
    show();
  }

  function reset() {
    Object.assign(now, start, { zoom: 1 });
    show();
  }

  const keys = {
    ArrowLeft: () => turn(-TURN_KEY, 0), ArrowRight: () => turn(TURN_KEY, 0),
    ArrowUp: () => turn(0, TURN_KEY), ArrowDown: () => turn(0, -TURN_KEY),
    "+": () => zoom(ZOOM_KEY), "=": () => zoom(ZOOM_KEY), "-": () => zoom(1 / ZOOM_KEY), Home: reset,
  };
  stage.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    keys[event.key]();
    event.preventDefault();
  });

  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  stage.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const apart = spread(pointers);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const share = TURN / pointers.size;
    turn((event.clientX - before[0]) * share, (event.clientY - before[1]) * share);
    if (apart > 0) zoom(spread(pointers) / apart);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    stage.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  stage.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== stage) return; // a page that is scrolled past stays so
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 500));
  }, { passive: false });

  return { show, reset };
}

/** Towards the camera. */
function outwards({ azimuth, elevation }) {
  const flat = Math.cos(elevation);
  return new Vector3(flat * Math.cos(azimuth), flat * Math.sin(azimuth), Math.sin(elevation));
}

function anglesOf(view) {
  const out = view.normalize().negate();
  return { azimuth: Math.atan2(out.y, out.x), elevation: Math.asin(out.z) };
}

/** Distance of the first two pointers, px; 0 where there are not two. */
function spread(pointers) {
  if (pointers.size < 2) return 0;
  const [[ax, ay], [bx, by]] = [...pointers.values()];
  return Math.hypot(ax - bx, ay - by);
}
