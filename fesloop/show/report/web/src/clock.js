// The play head: which trial, what time in it, whether it runs. Whoever shows it listens.

/**
 * @param trial the one that is chosen at first
 * @returns trial, time (s), playing, speed, span ([first, last] instant of what is played, s), and verbs; a
 *   listener is called with what changed: "trial", "time", "playing", "speed" or "span".
 */
export function createClock(trial) {
  const listeners = new Set();
  let opened = false; // at a time to look at: from there nothing plays
  const state = { trial, time: 0, playing: false, speed: 1, span: [0, 0] };
  let last = 0;

  const tell = (what) => listeners.forEach((listener) => listener(what, state));

  function seek(time) {
    opened = false;
    state.time = Math.min(Math.max(time, state.span[0]), state.span[1]);
    tell("time");
  }

  function tick(now) {
    if (!state.playing) return;
    const next = state.time + ((now - last) / 1000) * state.speed;
    last = now;
    if (next >= state.span[1]) {
      seek(state.span[1]);
      pause();
      return;
    }
    seek(next);
    requestAnimationFrame(tick);
  }

  function play() {
    if (state.playing || state.span[1] <= state.span[0]) return;
    if (opened || state.time >= state.span[1]) seek(state.span[0]);
    state.playing = true;
    last = performance.now();
    tell("playing");
    requestAnimationFrame(tick);
  }

  function pause() {
    if (!state.playing) return;
    state.playing = false;
    tell("playing");
  }

  return {
    state,
    seek,
    play,
    pause,
    /** Shows a time until something plays, from the beginning, or another time is sought. */
    open(time) {
      seek(time);
      opened = true;
    },
    toggle: () => (state.playing ? pause() : play()),
    choose(chosen) {
      state.trial = chosen;
      tell("trial");
    },
    setSpeed(speed) {
      state.speed = speed;
      tell("speed");
    },
    setSpan(first, last) {
      state.span = [first, last];
      tell("span");
      seek(state.time);
    },
    listen: (listener) => listeners.add(listener),
  };
}
