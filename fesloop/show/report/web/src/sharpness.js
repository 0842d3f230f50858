// How finely a scene is drawn: as the screen is, and coarser while motion would be slow (no graphics card).
const FINEST = 2; // pixels a CSS pixel
const COARSEST = 0.5;
const SLOW_MS = 50; // between two frames, below 20 a second
const STILL_MS = 300; // without a frame, after which what stands still is drawn finely again
const SMOOTHED = 0.8; // share of what was in the mean of the time between frames
const COARSER = 0.9; // times, at least, each time that frames are slow

/**
 * Follows how fast frames come; `redraw` draws once.
 *
 * @returns prepare(): before each frame, for a canvas is empty once it has another number of pixels; drawn(): after it
 */
export function createSharpness(renderer, redraw) {
  const fine = Math.min(devicePixelRatio, FINEST);
  let moving = fine;
  let wanted = fine;
  let mean = 0;
  let last = -Infinity;
  let still = 0;

  function prepare() {
    if (renderer.getPixelRatio() !== wanted) renderer.setPixelRatio(wanted);
  }

  function refine() {
    wanted = fine;
    mean = 0;
    last = -Infinity;
    redraw();
  }

  function follow(between) {
    mean = mean === 0 ? between : SMOOTHED * mean + (1 - SMOOTHED) * between;
    if (mean > SLOW_MS && moving > COARSEST) {
      const fewer = Math.min(COARSER, Math.sqrt(SLOW_MS / mean)); // pixels go as the square
      moving = Math.max(COARSEST, moving * fewer);
      mean = 0;
    }
    wanted = moving;
  }

  function drawn() {
    const now = performance.now();
    const between = now - last;
    last = now;
    if (between < STILL_MS) follow(between);
    clearTimeout(still);
    if (wanted < fine) still = setTimeout(refine, STILL_MS);
  }

  return { prepare, drawn };
}
