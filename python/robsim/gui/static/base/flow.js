// @ts-check
// Room for frames that this view grants to Python.

// Not oftener than that: each message to a kernel makes a notebook redraw its indicators, which
// costs it more than a frame.
const FRAMES_AHEAD = 24;
const GRANT_GAP = 500; // ms
const LATE = 1000; // ms without a frame while it runs, or without any message at first

/** Make it; `begin` says hello, as at first. */
export function makeFlow(context, begin) {
  let number = 0;
  let granted = 0;
  let late = setTimeout(() => grant(true), LATE);
  let poll = 0;
  const grant = (isLate) => {
    clearTimeout(late);
    granted = performance.now();
    context.send({ type: "grant", upto: number + FRAMES_AHEAD, late: isLate });
    if (!context.setup || context.state.state == "running")
      late = setTimeout(() => grant(true), LATE);
  };
  context.on("frame", (head) => {
    number = head.n;
    if (performance.now() - granted > GRANT_GAP) grant(false);
  });
  context.on("state", () => grant(false));
  const ask = (gap) => (poll ||= setInterval(() => grant(false), gap));
  const askNoMore = () => {
    if (!poll) return;
    clearInterval(poll);
    poll = 0;
    begin();
  };
  context.on("polled", ({ gap }) => (gap ? ask(gap) : askNoMore()));
  context.onEnd(() => {
    clearTimeout(late);
    clearInterval(poll);
  });
}
