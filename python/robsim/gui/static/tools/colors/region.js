// @ts-check
// A rectangle that is drawn on the picture with the pointer, or moved by keys.
import { ARROWS } from "../../base/arrows.js";
import { painter } from "../../base/dom.js";

const FIRST = 0.05; // of the picture: a region that the keys begin with

/**
 * `lens()` is that of the picture, `changed` asks for paint, `mark(region, isNew)` is told
 * [left, top, right, bottom], all included; `isNew` where another one has begun.
 */
export function makeRegionTool(context, { lens, changed, mark }) {
  let region = null;
  let start = null; // the corner where a drag began
  let isNew = false;
  const size = () => context.frame.size;
  const inside = ([u, v]) => [u, v].map((at, i) =>
    Math.min(Math.max(Math.round(at), 0), size()[i] - 1));
  const tell = painter(() => {
    if (region) mark(region, isNew);
    isNew = false;
  });
  context.onEnd(tell.cancel);
  let trained = null; // the class that the region is of
  context.on("setup", () => (trained = region = null)); // other pictures may follow
  context.on("state", ({ chosen, region: told }) => {
    if (chosen == trained && (region || !told)) return;
    [trained, region] = [chosen, told];
    tell.cancel();
    changed();
  });
  const set = (next) => {
    region = next;
    tell();
    changed();
  };
  const between = ([a, b], [c, d]) =>
    [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)];

  const begin = () => {
    const [u, v] = size().map((side) => side / 2);
    const half = Math.max(1, Math.round((FIRST * Math.min(...size())) / 2));
    isNew = true;
    set(between(inside([u - half, v - half]), inside([u + half, v + half])));
  };
  const move = ([du, dv], { shiftKey, altKey }) => {
    const step = shiftKey ? 10 : 1;
    const [left, top, right, bottom] = region;
    const corner = inside([right + step * du, bottom + step * dv]);
    if (altKey) return set(between([left, top], corner));
    const to = inside([left + step * du, top + step * dv]);
    const room = size().map((side, i) => side - 1 - [right - left, bottom - top][i]);
    const at = to.map((value, i) => Math.min(value, room[i]));
    set([...at, at[0] + right - left, at[1] + bottom - top]);
  };
  return {
    hover: () => {},
    isActive: () => true,
    takesDrags: () => true,
    click: () => {},
    doubleClick: () => false,
    dragStart: (at) => {
      if (!context.frame || !lens().holds(at)) return false;
      start = inside(lens().toPixel(at));
      isNew = true;
      return true;
    },
    drag: (_, to) => set(between(start, inside(lens().toPixel(to)))),
    dragEnd: () => changed(),
    giveUp: () => changed(),
    key: (event) => {
      const isMove = event.key in ARROWS;
      if (event.key == "Enter" || (isMove && !region)) begin();
      else if (isMove) move(ARROWS[event.key], event);
      else return false;
      return true;
    },
    draw: ({ pen, pixel, unit }) => {
      if (!region) return;
      const [left, top] = pixel([region[0] - 0.5, region[1] - 0.5]);
      const [right, bottom] = pixel([region[2] + 0.5, region[3] + 0.5]);
      for (const [width, color] of [[3, "#000a"], [1.5, "#ffd500"]]) {
        pen.lineWidth = width * unit;
        pen.strokeStyle = color;
        pen.strokeRect(left, top, right - left, bottom - top);
      }
    },
  };
}
