// The scene that the hands stand in, drawn by three.js when something in it has changed.
import {
  AmbientLight, Color, DirectionalLight, PerspectiveCamera, Scene, WebGLRenderer,
} from "three";
import { onRepaint, shownColour } from "./colours.js";
import { handBodies, place, solidBody } from "./hand_bodies.js";
import { createTurn } from "./hand_turn.js";
import { createSharpness } from "./sharpness.js";

const SEEN = { truth: 1, estimate: 0.55 };
const SOFTENED = 0.25; // share of paper in the colour of what is not a hand

/** Whether this browser draws in three dimensions. */
export function drawsInDepth() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

/**
 * A scene on a canvas that fills `stage`.
 *
 * @param figure {shapes, objects, view}
 * @param places that the camera has to hold at first
 * @returns showFrame(hands, objects): poses by hand's name and of the objects that move; showHand(name,
 *   whether); reset(): the first view again
 */
export function createScene(stage, { shapes, objects, view }, places) {
  const renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  stage.append(renderer.domElement);
  const scene = new Scene();
  const camera = new PerspectiveCamera(26, 1);
  scene.add(camera, new AmbientLight(0xffffff, 1.5));
  const lamp = new DirectionalLight(0xffffff, 2.2);
  lamp.position.set(-0.6, 0.9, 0.7);
  camera.add(lamp);

  const hands = Object.entries(shapes).map(([name, meshes]) => ({ name, ...handBodies(meshes, SEEN[name] ?? 1) }));
  const solids = objects.map((object) => ({ ...object, ...solidBody(object) }));
  hands.forEach(({ group }) => scene.add(group));
  solids.forEach(({ body }) => scene.add(body));
  const moving = solids.filter(({ moves }) => moves);

  let frames = 0;
  let asked = false;
  const sharpness = createSharpness(renderer, draw);
  function draw() {
    asked = false;
    sharpness.prepare();
    renderer.render(scene, camera);
    frames += 1;
    stage.dataset.frames = frames;
    sharpness.drawn();
  }
  function ask() {
    if (!asked) requestAnimationFrame(draw);
    asked = true;
  }

  function paint() {
    for (const { name, material } of hands) material.color = new Color(shownColour(`hand-${name}`));
    const paper = new Color(shownColour("paper"));
    for (const { role, material } of solids) {
      material.color = new Color(shownColour(role === "plain" ? "surface" : role)).lerp(paper, SOFTENED);
    }
    draw(); // at once: a page that is about to be printed does not wait
  }
  onRepaint(paint);

  const turn = createTurn(stage, camera, places, view, ask);
  paint();
  new ResizeObserver(() => {
    const { clientWidth: width, clientHeight: height } = stage;
    if (width === 0 || height === 0) return;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    turn.show();
    draw();
  }).observe(stage);

  return {
    showFrame(shown, objectsShown) {
      for (const { name, group } of hands) {
        (shown[name] ?? []).forEach((pose, i) => group.children[i] && place(group.children[i], pose));
        if (!shown[name]) group.children.forEach((child) => { child.visible = false; });
      }
      objectsShown.forEach((pose, i) => moving[i] && place(moving[i].body, pose));
      ask();
    },
    showHand(name, whether) {
      hands.filter((hand) => hand.name === name).forEach(({ group }) => { group.visible = whether; });
      ask();
    },
    reset: turn.reset,
  };
}
