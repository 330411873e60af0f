// @ts-check
// The panel that calibrates a floor: points on its picture, under a magnifying glass, or sheets.
import { makeRadios } from "../base/buttons.js";
import { make, say } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { text } from "../base/texts.js";
import { makeArea } from "./floor/area.js";
import { drawBoards, makeLensBoard } from "./floor/board.js";
import { makeChosenGlass, makeHoverGlass } from "./floor/glasses.js";
import { makeGrid, pixelToPlace } from "./floor/grid.js";
import { makeMarks, timesOf } from "./floor/marks.js";
import { makePointBar, makePointTable } from "./floor/points.js";
import { makeFloorFile, makeFloorResult } from "./floor/result.js";
import { makeSheets } from "./floor/sheets.js";
import { makeFields, makeHint, makePart, makeRow } from "./pieces.js";
import { renderTool } from "./tool.js";

const WAYS = ["points", "sheets", "lens"];

export const renderFloor = (host) => renderTool(host, "floor", (tool) => {
  const { context, picture, film } = tool;
  let snaps = true;
  const snap = makeField({ name: "snap", kind: "switch" }, (on) => (snaps = on));
  snap.show(true);
  context.onEnd(snap.end);
  context.on("state", ({ by }) => (snap.element.hidden = by != "points"));

  const [grid, readout] = [makeGrid(context), makeFloorReadout(context)];
  const glass = makeHoverGlass(context, () => marks.crosses(), picture.canvas);
  const hover = (pixel, where) => {
    glass.show(context.state.by == "points" ? pixel : null, where);
    readout.show(pixel);
  };
  const marks = makeMarks(context, picture, () => snaps, hover);
  const draw = (scene) => {
    if (context.state.by == "lens") return drawBoards(scene);
    grid.draw(scene);
    readout.legend(scene.lens.scale);
  };
  return {
    hands: [{ draw, hover }, marks],
    over: [glass.canvas],
    foot: [readout.element, readout.times],
    below: makeRow(snap.element, film, makeFloorFile(context)),
    beside: [makeWays(tool, marks), makeFloorResult(context), makeArea(context)],
  };
});

/** What the floor is fitted by, and what belongs to that. */
function makeWays({ context, picture, history }, marks) {
  const ways = makeRadios("robsim-segments", text("by"), (name) =>
    context.send({ type: "by", name }));
  const options = WAYS.map((value) =>
    ({ value, textContent: text(`by.${value}`), title: text(`by.${value}.title`) }));
  const table = makePointTable(context, picture.canvas);
  const hint = makeHint("floor_hint");
  const sides = {
    points: makeFields(hint, makeChosenGlass(context, picture, marks),
      makePointBar(context, history), table),
    sheets: makeSheets(context),
    lens: makeLensBoard(context),
  };
  context.on("state", ({ by, chosen }) => {
    ways.show(options, by);
    for (const [way, side] of Object.entries(sides)) side.hidden = way != by;
    hint.hidden = chosen != null;
  });
  return makePart(ways.element, ...Object.values(sides));
}

/** What is under the pointer, and by what the arrows are magnified. */
function makeFloorReadout(context) {
  const className = "robsim-camera-readout robsim-floor-readout robsim-away";
  const [element, times] = [make("div", { className }), make("div", { className })];
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
  context.on("state", ({ fit, by }) =>
    times.classList.toggle("robsim-away", !fit || by == "lens"));
  const legend = (scale) =>
    say(times, text("arrows_times", { times: timesOf(context.state, scale) }));
  return { element, times, show, legend };
}
