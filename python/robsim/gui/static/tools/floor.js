// @ts-check
// The panel that calibrates a floor: points on its picture, under a magnifying glass, or sheets.
import { markChosen, moveByArrows } from "../base/buttons.js";
import { make } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { text } from "../base/texts.js";
import { makePicture } from "../camera/picture.js";
import { makeFilm } from "./film.js";
import { drawBoards, makeLensBoard } from "./floor/board.js";
import { makeChosenGlass, makeHoverGlass } from "./floor/glasses.js";
import { makeGrid, pixelToPlace } from "./floor/grid.js";
import { makeMarks, timesOf } from "./floor/marks.js";
import { makeFloorArea, makeFloorFile, makeFloorResult } from "./floor/result.js";
import { makePointBar, makePointTable, makeSheetTable } from "./floor/table.js";
import { renderTool } from "./tool.js";

const WAYS = ["points", "sheets", "lens"];

export function renderFloor(host) {
  return renderTool(host, "floor", (context) => {
    const view = makeFloorPicture(context);
    const table = makePointTable(context, () => view.picture.canvas.focus());
    typeOnPicture(context, view.picture.canvas, table);
    const glass = makeChosenGlass(context, view.marks);
    const parts = [makeWays(context, glass.element, table), makeFloorResult(context),
      makeFloorArea(context)];
    const below = make("div", { className: "robsim-tool-row" }, view.snaps,
      makeFilm(context).element, makeFloorFile(context));
    return { view: view.element, below, width: view.picture.width, beside: parts };
  });
}

function makeFloorPicture(context) {
  let snaps = true;
  const snap = makeField({ name: "snap", kind: "switch" }, (on) => (snaps = on), () => {});
  snap.show(true);
  context.onEnd(snap.end);
  const grid = makeGrid(context);
  const readout = makeFloorReadout(context);
  const glass = makeHoverGlass(context, () => marks.crosses(), () => picture.canvas);
  const hovered = (pixel, at) => {
    glass.show(context.state.by == "points" ? pixel : null, at);
    readout.show(pixel);
  };
  const marks = makeMarks(context, () => picture, () => snaps, hovered);
  const draw = (scene) => {
    if (context.state.by == "lens") return drawBoards(scene);
    grid.draw(scene);
    marks.draw(scene);
    readout.legend(scene.lens.scale);
  };
  const picture = makePicture(context,
    { label: "floor_picture", inks: [], draw, tool: marks.tool });
  context.on("state", ({ by }) => {
    snap.element.hidden = by != "points";
    picture.changed();
  });
  listenToHistory(context);
  const element = make("div", { className: "robsim-camera" }, picture.canvas,
    make("div", { className: "robsim-camera-bar" }, picture.whole), glass.canvas,
    make("div", { className: "robsim-camera-foot" }, readout.element, readout.times));
  return { element, picture, marks, snaps: snap.element };
}

/** Ctrl-Z and Ctrl-Shift-Z anywhere but in a field. */
function listenToHistory(context) {
  context.el.addEventListener("keydown", (event) => {
    const { ctrlKey, metaKey, shiftKey, key } = event;
    if (event.target.matches("input, textarea")) return;
    if (!(ctrlKey || metaKey) || key.toLowerCase() != "z") return;
    context.send({ type: shiftKey ? "redo" : "undo" });
    event.preventDefault();
    event.stopPropagation();
  });
}

/** Let numbers that are typed on the picture be the place of the chosen point. */
function typeOnPicture(context, canvas, table) {
  const take = (event) => {
    const { chosen } = context.state;
    if (chosen == null || event.ctrlKey || event.metaKey || event.altKey) return;
    if (!/^[\d.,\u2212-]$/.test(event.key)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    table.type(chosen, event.key);
  };
  canvas.addEventListener("keydown", take, { capture: true });
}

/** What the floor is fitted by, and what belongs to that. */
function makeWays(context, glass, table) {
  const choose = (name) => context.send({ type: "by", name });
  const buttons = WAYS.map((value) => make("button", {
    type: "button", role: "radio", value, textContent: text(`by.${value}`),
    title: text(`by.${value}.title`), onclick: () => choose(value),
  }));
  const ways = make("div", { className: "robsim-segments", role: "radiogroup",
    ariaLabel: text("by") }, ...buttons);
  moveByArrows(ways, (button) => choose(button.value));
  const hint = make("p", { className: "robsim-quiet robsim-tool-hint",
    textContent: text("floor_hint") });
  const points = make("div", { className: "robsim-tool-fields" }, hint, glass,
    makePointBar(context), table.element);
  const sheets = makeSheetTable(context);
  const board = makeLensBoard(context);
  context.on("state", ({ by, chosen }) => {
    board.hidden = by != "lens";
    markChosen(ways, "aria-checked", (button) => button.value == by);
    points.hidden = by != "points";
    sheets.hidden = by != "sheets";
    hint.hidden = chosen != null;
  });
  return make("div", { className: "robsim-tool-part" }, ways, points, sheets, board);
}

/** What is under the pointer, and by what the arrows are magnified. */
function makeFloorReadout(context) {
  const element = make("div", { className: "robsim-camera-readout robsim-floor-readout" });
  const times = make("div", { className: "robsim-camera-readout robsim-floor-readout" });
  const show = (pixel) => {
    element.classList.toggle("robsim-away", !pixel);
    if (!pixel) return;
    const { grid } = context.state;
    const [u, v] = pixel.map((value) => value.toFixed(1));
    const place = grid && pixelToPlace(grid)(pixel);
    const known = place?.every(Number.isFinite)
      ? text("floor_at", { x: place[0].toFixed(0), y: place[1].toFixed(0), unit: grid.unit }) : "";
    element.textContent = text("pixel_at", { u, v, known });
  };
  const legend = (scale) => {
    const { state } = context;
    times.classList.toggle("robsim-away", !state.fit || state.by == "lens");
    const words = text("arrows_times", { times: timesOf(state, scale) });
    if (times.textContent != words) times.textContent = words;
  };
  show(null);
  times.classList.add("robsim-away");
  return { element, times, show, legend };
}
