// @ts-check
// Room for frames that this view grants to Python.

// As few grants as can be: each message to a kernel makes a notebook redraw its indicators, which
// costs it more than some frames. But no more room than a slow line fills in a moment, too.
const ROOM_TIME = 1.5; // s of frames, as fast as they come
const LEAST_ROOM = 8; // frames
const MOST_ROOM = 90;
const USED = 2 / 3; // of the room, after which more is granted
const LATE = 1000; // ms without a frame while it runs, or without any message at first

/** Make it; `begin` says hello, as at first. */
export function makeFlow(context, begin) {
  let number = 0; // of the newest frame
  let room = LEAST_ROOM;
  let granted = { number, at: 0 }; // what was the newest then, and when (ms)
  let late = setTimeout(() => grant(true), LATE);
  let poll = 0;
  const grant = (isLate) => {
    clearTimeout(late);
    granted = { number, at: performance.now() };
    context.send({ type: "grant", upto: number + room, late: isLate });
    if (!context.setup || context.state.state == "running")
      late = setTimeout(() => grant(true), LATE);
  };
  context.on("frame", ({ n }) => {
    number = n;
    const came = number - granted.number;
    if (came < USED * room) return;
    const rate = (1000 * came) / (performance.now() - granted.at); // 1/s
    room = Math.min(Math.max(Math.ceil(ROOM_TIME * rate), LEAST_ROOM), MOST_ROOM);
    grant(false);
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
