// Frames as a running `fesloop view` sends them; towards those who show time and controls it is a clock.

const SEEN_MS = 60; // a slider that is pulled asks for no more than so often
const AGAIN_MS = 1000;

/**
 * @param spans first and last instant of each trial, s; empty where frames are live
 * @param first the trial that is chosen at first
 * @param show called with each frame to be drawn: {trial, time_s, note, hands, objects, readings}
 * @param say called with what is to be read about it, and whether it is urgent
 * @returns what createClock (clock.js) returns, and open()
 */
export function createFeed(spans, first, show, say) {
  const trials = Object.keys(spans).map(Number);
  const live = trials.length === 0;
  const listeners = new Set();
  const begins = live || !matchMedia("(prefers-reduced-motion: reduce)").matches;
  const state = { trial: first, time: 0, playing: begins, speed: 1, span: [0, 0] };
  let events = null;
  let newest = null;
  let asking = 0;

  const tell = (what) => listeners.forEach((listener) => listener(what, state));

  /** Draws the newest of the frames that have come since the last was drawn. */
  function draw() {
    const frame = newest;
    newest = null;
    show(frame);
    say(frame.note, false);
    state.time = frame.time_s;
    if (live) Object.assign(state, { trial: frame.trial });
    tell("time");
    if (!live && state.playing && state.time >= state.span[1]) pause();
  }

  function hear({ data }) {
    if (newest === null) requestAnimationFrame(draw);
    newest = withPoses(JSON.parse(data));
  }

  function open() {
    clearTimeout(asking);
    events?.close();
    const speed = state.playing ? state.speed : 0;
    events = new EventSource(live ? "frames" : `frames?trial=${state.trial}&at=${state.time}&speed=${speed}`);
    events.addEventListener("frame", hear);
    events.addEventListener("fault", ({ data }) => {
      events.close();
      say(data, true);
    });
    events.addEventListener("error", () => {
      events.close();
      say("The viewer does not answer: has it ended?", true);
      asking = setTimeout(open, AGAIN_MS);
    });
  }

  function seek(time) {
    state.time = Math.min(Math.max(time, state.span[0]), state.span[1]);
    tell("time");
    clearTimeout(asking);
    asking = setTimeout(open, SEEN_MS);
  }

  function play() {
    if (state.playing) return;
    state.playing = true;
    tell("playing");
    if (state.time >= state.span[1]) state.time = state.span[0];
    open();
  }

  function pause() {
    if (!state.playing) return;
    state.playing = false;
    tell("playing");
    events?.close();
  }

  function choose(trial) {
    state.trial = trial;
    state.span = spans[trial] ?? [0, 0];
    tell("trial");
    tell("span");
    seek(state.span[0]);
  }

  function setSpeed(speed) {
    state.speed = speed;
    tell("speed");
    if (state.playing) open();
  }

  state.span = spans[state.trial] ?? [0, 0];
  state.time = state.span[0];
  return { state, seek, play, pause, toggle: () => (state.playing ? pause() : play()), choose, setSpeed, open,
    listen: (listener) => listeners.add(listener) };
}

/** A frame whose unknown poses are as everywhere: not a number. */
function withPoses({ hands, objects, ...rest }) {
  const known = (poses) => poses.map((pose) => pose ?? new Array(7).fill(NaN));
  return {
    ...rest, objects: known(objects),
    hands: Object.fromEntries(Object.entries(hands).map(([name, poses]) => [name, known(poses)])),
  };
}
