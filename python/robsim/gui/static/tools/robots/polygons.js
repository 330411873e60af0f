// @ts-check
// The polygons of a robot on its picture: corners that are dragged, put on edges, removed.
import { ARROWS } from "../../base/arrows.js";
import { distance } from "../../base/geometry.js";

const REACH = { mouse: 10, touch: 22 }; // px on the screen that a corner takes
const CORNER = 4.5; // px on the screen
const ARROW = 46; // px on the screen, the heading's

/** `picture()` has the lens and asks for paint. What is done is told to Python at once. */
export function makePolygons(context, picture) {
  let held = null; // what is dragged: a corner, or "heading"
  let isNew = false; // its drag has just begun
  let chosen = -1; // the corner that the keys move
  let local = null; // where the corner, or the heading, is while it is dragged

  const state = () => context.state;
  const corners = () => state().parts?.[state().part] ?? [];
  const reach = () => REACH[picture().canvas.dataset.pointer] ?? REACH.mouse;
  const onScreen = (point) => picture().lens.toCanvas(point);
  const pixelAt = (at) => picture().lens.toPixel(at);
  const near = (at, points) => {
    const away = points.map((point) => distance(onScreen(point), at) / devicePixelRatio);
    const nearest = away.indexOf(Math.min(...away));
    return away[nearest] < reach() ? nearest : -1;
  };
  const headingEnd = () => headingOf(state(), picture().lens.scale);
  const move = (at) => {
    local = at;
    const goesOn = !isNew;
    isNew = false;
    if (held == "heading") context.send({ type: "face", at, goes_on: goesOn });
    else context.send({ type: "move", corner: held, at, goes_on: goesOn });
    picture().later();
  };
  const add = (at) => {
    const corner = edgeNear(corners(), at);
    chosen = corner;
    context.send({ type: "insert", corner, at });
  };
  const cut = () => {
    if (chosen < 0) return false;
    context.send({ type: "cut", corner: chosen });
    chosen = -1;
    return true;
  };
  context.on("state", () => {
    if (held == null) local = null;
    if (chosen > corners().length) chosen = -1; // the last one may be on its way to Python
    picture().later();
  });
  return {
    isActive: () => state().mode == "draw",
    takesDrags: () => state().mode == "draw",
    click: (at) => {
      if (state().mode != "draw" || !picture().lens.holds(at)) return;
      const corner = near(at, corners());
      if (corner >= 0) chosen = corner;
      else add(pixelAt(at));
      picture().later();
    },
    doubleClick: (at) => {
      chosen = near(at, corners());
      return cut();
    },
    dragStart: (at) => {
      if (state().mode != "draw") return false;
      const corner = near(at, corners());
      if (corner >= 0) held = chosen = corner;
      else if (state().parts && near(at, [headingEnd()]) == 0) held = "heading";
      else return false;
      isNew = true;
      return true;
    },
    drag: (to) => move(pixelAt(to)),
    dragEnd: () => (held = null),
    giveUp: () => (held = local = null),
    key: (event) => {
      if (event.key == "Delete" || event.key == "Backspace") return cut();
      if (!(event.key in ARROWS) || chosen < 0) return false;
      const step = event.shiftKey ? 10 : 1;
      const [u, v] = corners()[chosen];
      const at = [u + step * ARROWS[event.key][0], v + step * ARROWS[event.key][1]];
      context.send({ type: "move", corner: chosen, at, goes_on: false });
      return true;
    },
    draw: (scene) => {
      if (state().mode != "draw" || !state().parts) return;
      for (const [part, points] of Object.entries(state().parts)) {
        const isIt = part == state().part;
        const shown = isIt && local && held != "heading"
          ? points.map((point, i) => (i == held ? local : point)) : points;
        drawPolygon(scene, shown, state().inks[part], { isIt, chosen });
      }
      drawArrow(scene, state(), held == "heading" && local ? local : headingEnd());
    },
  };
}

/** Where the arrow of the heading ends, in pixels of the picture. */
function headingOf({ centre, alignment }, scale) {
  // The robot faces right after a clockwise rotation by the alignment.
  const angle = (-alignment * Math.PI) / 180;
  const long = (ARROW * devicePixelRatio) / scale;
  return [centre[0] + long * Math.cos(angle), centre[1] + long * Math.sin(angle)];
}

/** Return before which corner a new one lies on the nearest edge; behind the last of a line. */
function edgeNear(points, at) {
  if (points.length < 3) return points.length;
  const away = points.map((point, i) => {
    const next = points[(i + 1) % points.length];
    return distance(point, at) + distance(next, at) - distance(point, next);
  });
  return away.indexOf(Math.min(...away)) + 1;
}

function drawPolygon({ pen, pixel, unit }, points, ink, { isIt, chosen }) {
  if (!points.length) return;
  pen.beginPath();
  points.map(pixel).forEach(([x, y]) => pen.lineTo(x, y));
  pen.closePath();
  for (const [width, color] of [[3, "#0009"], [1.5, ink]]) {
    pen.lineWidth = width * unit;
    pen.strokeStyle = color;
    pen.stroke();
  }
  if (!isIt) return;
  points.map(pixel).forEach(([x, y], i) => {
    pen.beginPath();
    pen.arc(x, y, (i == chosen ? 1.5 : 1) * CORNER * unit, 0, 2 * Math.PI);
    pen.fillStyle = i == chosen ? "#2fd16b" : ink;
    pen.fill();
    pen.lineWidth = unit;
    pen.strokeStyle = "#000";
    pen.stroke();
  });
}

function drawArrow({ pen, pixel, unit }, { centre }, end) {
  const [[x, y], [tx, ty]] = [pixel(centre), pixel(end)];
  const angle = Math.atan2(ty - y, tx - x);
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(tx, ty);
  for (const side of [-1, 1]) {
    pen.moveTo(tx, ty);
    pen.lineTo(tx - 10 * unit * Math.cos(angle + 0.5 * side),
      ty - 10 * unit * Math.sin(angle + 0.5 * side));
  }
  for (const [width, color] of [[4, "#0009"], [2, "#fff"]]) {
    pen.lineWidth = width * unit;
    pen.strokeStyle = color;
    pen.stroke();
  }
}
