// Room for frames that this view grants to Python.

// Few grants: each message to a kernel makes a notebook redraw its indicators, which costs it more
// than a frame. But on a line that does not keep up, what there is room for comes that much late.
const ROOM_TIME = { steady: 4, filling: 1 }; // s of frames, as fast as they come
const STEADY = 250; // ms that a frame may take longer than the quickest one
const LEAST_ROOM = 8; // frames
const MOST_ROOM = 250;
const USED = 2 / 3; // of the room, after which more is granted
const LATE = 1000; // ms without a frame while it runs, or without any message at first

/** Make it; `begin` says hello, as at first. */
export function makeFlow(context, begin) {
  let number = 0; // of the newest frame
  let room = LEAST_ROOM;
  let granted = { number, at: 0 }; // the newest frame of the last grant, and its time (ms)
  let quickest = Infinity; // ms on the way, and what Python's clock is behind
  let late = 0;
  let poll = 0;
  const wait = () => {
    clearTimeout(late);
    if (!context.setup || context.state.state == "running")
      late = setTimeout(() => grant(true), LATE);
  };
  const grant = (isLate) => {
    granted = { number, at: performance.now() };
    context.send({ type: "grant", upto: number + room, late: isLate });
    wait();
  };
  context.on("frame", ({ n, sent }) => {
    number = n;
    const way = Date.now() - sent;
    quickest = Math.min(quickest, way);
    const came = number - granted.number;
    if (came < USED * room) return wait();
    const rate = (1000 * came) / (performance.now() - granted.at); // 1/s
    const time = way - quickest < STEADY ? ROOM_TIME.steady : ROOM_TIME.filling;
    room = Math.min(Math.max(Math.ceil(time * rate), LEAST_ROOM), MOST_ROOM);
    grant(false);
  });
  context.on("state", () => grant(false));
  wait();
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
