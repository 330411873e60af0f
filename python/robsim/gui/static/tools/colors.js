// @ts-check
// The panel that trains colours: a region of the picture, ranges, what they find.
import { make } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { text } from "../base/texts.js";
import { makePicture } from "../camera/picture.js";
import { makeChannels } from "./colors/channels.js";
import { makeClasses } from "./colors/classes.js";
import { makeFilm } from "./film.js";
import { makeRegionTool } from "./colors/region.js";
import { makeScore } from "./colors/score.js";
import { makeThresholds } from "./colors/thresholds.js";
import { renderTool } from "./tool.js";

const OPTIONS = [
  { name: "percentile", kind: "range", low: 0, high: 49, step: 1, unit: "%" },
  { name: "margin", kind: "range", low: 0, high: 127, step: 1, unit: "" },
  { name: "limit_y", kind: "switch" },
];

export function renderColors(host) {
  return renderTool(host, "colors", (context) => {
    const view = makeColorsPicture(context);
    const channels = makeChannels(context, (ranges) => context.send({ type: "ranges", ranges }));
    context.on("state", ({ classes, chosen }) =>
      channels.show(classes.find(({ name }) => name == chosen)?.ranges));
    const training = make("div", { className: "robsim-tool-part" }, channels.element,
      makeOptions(context));
    const parts = [makeClasses(context), { element: training }, makeScore(context),
      makeThresholds(context)];
    return { ...view, beside: parts.map(({ element }) => element) };
  });
}

function makeColorsPicture(context) {
  let addsTo = 0; // regions that stay when another one is marked
  let isMore = false;
  const more = makeField({ name: "more_regions", kind: "switch" }, (on) => (isMore = on), () => {});
  more.show(false);
  const samples = () =>
    context.state.classes.find(({ name }) => name == context.state.chosen)?.drift.length ?? 0;
  const mark = (region, isNew) => {
    if (isNew) addsTo = isMore ? samples() : 0;
    context.send({ type: "region", region, keep: addsTo });
  };
  const tool = makeRegionTool(context,
    { lens: () => picture.lens, changed: () => picture.later(), mark });
  const draw = (scene) => {
    const { pen, frame, lens } = scene;
    pen.imageSmoothingEnabled = false;
    if (frame.mask) drawMask(pen, frame, lens);
    if (context.state.tests) drawFound(scene);
    tool.draw(scene);
  };
  const picture = makePicture(context, { label: "region_label", inks: [], draw, tool });
  const tests = makeField({ name: "tests", kind: "switch" },
    (value) => context.send({ type: "set", name: "tests", value }), () => {});
  const verdict = make("div", { className: "robsim-chip", role: "status" });
  context.on("state", (state) => tests.show(state.tests));
  context.on("frame", (head) => showVerdict(verdict, head));
  const hint = make("div", { className: "robsim-camera-hint", textContent: text("region_hint") });
  context.on("state", ({ region }) => (hint.hidden = Boolean(region)));
  const film = makeFilm(context);
  const element = make("div", { className: "robsim-camera" }, picture.canvas,
    make("div", { className: "robsim-camera-badges" }, verdict),
    make("div", { className: "robsim-camera-bar" }, picture.whole),
    make("div", { className: "robsim-camera-foot" }, hint));
  const below = make("div", { className: "robsim-tool-row" }, tests.element, more.element,
    film.element);
  return { view: element, below, width: picture.width };
}

/** Draw the mask, which has each pixel of the picture, or each second one, and so on. */
function drawMask(pen, { mask, size }, { left, top, scale }) {
  const side = Math.round(Math.max(...size) / Math.max(mask.width, mask.height)) * scale;
  pen.drawImage(mask, left, top, mask.width * side, mask.height * side);
}

/** Draw the boxes of what was found. */
function drawFound({ pen, frame, pixel, unit, context }) {
  const css = new Map(context.state.classes.map((one) => [one.name, one.css]));
  pen.lineWidth = unit;
  for (const [name, left, top, right, bottom] of frame.boxes) {
    const [x, y] = pixel([left - 0.5, top - 0.5]);
    const [x2, y2] = pixel([right + 0.5, bottom + 0.5]);
    pen.strokeStyle = css.get(name) ?? "magenta";
    pen.strokeRect(x, y, x2 - x, y2 - y);
  }
}

/** Say whether the robot was found, and if not, why. */
function showVerdict(element, { found, missed }) {
  element.hidden = !found && !missed;
  element.classList.toggle("robsim-good", Boolean(found));
  element.classList.toggle("robsim-warning", !found);
  const seen = missed ? text("found_robot_why", { why: missed }) : text("found_robot");
  const words = found ? seen : text("not_seen", { why: missed ?? "" });
  if (element.textContent != words) element.textContent = words;
}

function makeOptions(context) {
  const fields = OPTIONS.map((option) => makeField(option, (value) =>
    context.send({ type: "set", name: option.name, value }), () => {}));
  context.on("state", ({ options }) =>
    fields.forEach((field) => field.show(options[field.name])));
  fields.forEach((field) => context.onEnd(field.end));
  return make("div", { className: "robsim-tool-fields" }, ...fields.map((field) => field.element));
}
