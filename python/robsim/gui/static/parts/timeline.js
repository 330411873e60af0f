// The time line: which step is shown, any past one or the newest, and where the robot was not seen.
import { makeButton } from "../base/buttons.js";
import { make, painter, text } from "../base/dom.js";
import { makeSlider, showSlider } from "../base/fields.js";

const TICK_HEIGHT = 6; // px, as in timeline.css
const NARROWEST_TICK = 2; // px

export function makeTimeline(context) {
  const unseen = makeUnseen();
  const ticks = makeTicks();
  const slider = makeSlider("timeline", { min: 0, max: 0, step: 1 });
  Object.assign(slider, { ariaLabel: text("timeline"), title: text("timeline.title") });
  const place = make("output.robsim-number.robsim-quiet.robsim-timeline-place");
  const newest = makeButton("newest", "robsim-plain robsim-timeline-newest", () =>
    context.look(null));
  const element = make("div.robsim-timeline",
    make("div.robsim-timeline-track", slider, ticks.canvas), place, newest);

  let moved = null; // the slider's new position; Infinity = at its end, even during a run

  const last = () => Math.max(context.last, 0);
  const shown = () => Math.min(moved ?? Math.max(context.shown, 0), last());
  const look = painter(() => {
    const k = moved;
    moved = null;
    context.look(k >= last() ? null : k);
  });
  slider.addEventListener("input", () => {
    moved = slider.value == slider.max ? Infinity : Number(slider.value);
    look();
  });

  const show = painter(() => {
    const [to, k] = [last(), shown()];
    slider.max = String(to);
    slider.disabled = context.newest < 1;
    showSlider(slider, k, text("step.of", { k, last: to }));
    place.style.minWidth = `${2 * Math.max(String(to).length, 4) + 3}ch`; // so that nothing jumps
    place.textContent = text("step.of.short", { k, last: to });
    newest.disabled = context.looking == null;
    newest.setAttribute("aria-pressed", String(context.looking != null));
    const poses = ["pose_measured", "pose_held"].map((name) => context.store.get(name));
    ticks.paint(unseen(...poses), to, context.ink("held"));
  });
  context.on("shown theme", show);
  context.on("setup", () => context.want(["pose_measured", "pose_held"]));
  new ResizeObserver(([{ contentRect }]) => {
    ticks.resize(contentRect.width);
    show();
  }).observe(ticks.canvas);

  /** Move by a number of steps from the displayed step. */
  const move = (by) => {
    const k = Math.max(0, shown() + by);
    if (context.newest >= 0) context.look(k >= last() ? null : k);
  };
  return { element, move };
}

/**
 * Return a function of the measured and the held poses that returns ranges [[first, last], ...]
 * without a pose. After a first pose, a pose is held unless nothing measures; such steps count
 * as seen.
 */
function makeUnseen() {
  let [known, epoch, done, runs, isFound] = [null, 0, 0, [], false];
  return (rows, held) => {
    if (rows != known || rows?.epoch != epoch) [done, runs, isFound] = [0, [], false]; // a reset
    [known, epoch] = [rows, rows?.epoch];
    for (; done < Math.min(rows?.count ?? 0, held?.count ?? Infinity); done++) {
      const isMeasured = !Number.isNaN(rows.get(done, 0));
      isFound ||= isMeasured;
      if (isMeasured || (isFound && held && Number.isNaN(held.get(done, 0)))) continue;
      const run = runs.at(-1);
      if (run?.[1] == done - 1) run[1] = done;
      else runs.push([done, done]);
    }
    return runs;
  };
}

/** Make a canvas that shows runs of steps by ticks. */
function makeTicks() {
  const canvas = make("canvas.robsim-timeline-ticks", { ariaHidden: "true" });
  const pen = canvas.getContext("2d");
  let isBare = false;
  /** Draw a tick for each of the runs, from step 0 to the last one. */
  const paint = (runs, last, css) => {
    if (isBare && !runs.length) return; // a canvas that is touched is copied to the screen again
    isBare = !runs.length;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.fillStyle = css;
    const scale = canvas.width / Math.max(last, 1);
    let painted = -Infinity; // up to there
    for (const [first, end] of runs) {
      const tick = Math.max((end - first) * scale, NARROWEST_TICK * devicePixelRatio);
      const left = Math.min(first * scale - devicePixelRatio, canvas.width - tick);
      if (left + tick < painted + 1) continue; // of a long run many fall on a pixel
      painted = left + tick;
      pen.fillRect(left, 0, tick, canvas.height);
    }
  };
  /** Take a width on the screen (px); this clears the drawing. */
  const resize = (width) => {
    canvas.width = Math.round(width * devicePixelRatio);
    canvas.height = TICK_HEIGHT * devicePixelRatio;
  };
  return { canvas, paint, resize };
}
