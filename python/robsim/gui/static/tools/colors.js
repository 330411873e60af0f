// The panel that trains colours: a region of the picture, ranges, and found blobs.
import { make, say, text } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { makeCopyButton } from "../parts/source.js";
import { makeChannels } from "./colors/channels.js";
import { makeClasses } from "./colors/classes.js";
import { makeRegion } from "./colors/region.js";
import { makeScore } from "./colors/score.js";
import { makeAct, makeFields, makePart, makeRow, makeTextField, makeVerdict,
  showIn } from "./pieces.js";
import { renderTool } from "./tool.js";

const OPTIONS = [
  { name: "percentile", kind: "range", low: 0, high: 49, step: 1, unit: "%" },
  { name: "margin", kind: "range", low: 0, high: 127, step: 1, unit: "" },
  { name: "limit_y", kind: "switch" },
];

export const renderColors = (host) => renderTool(host, "colors", (tool) => {
  const { context, picture, film } = tool;
  let isMore = false; // regions stay when another one is marked
  const more = makeField({ name: "more_regions", kind: "switch" }, (on) => (isMore = on));
  more.show(false);
  const hint = make("div.robsim-camera-hint.robsim-row.robsim-afloat", text("region_hint"));
  context.on("state", ({ region }) => (hint.hidden = Boolean(region)));
  const [tests, ...options] = [{ name: "tests", kind: "switch" }, ...OPTIONS].map((option) =>
    makeField(option, (value, goesOn) =>
      context.send({ type: "set", name: option.name, value, goes_on: goesOn })));
  context.on("state", (state) => {
    tests.show(state.tests);
    for (const field of options) field.show(state.options[field.name]);
  });
  const fields = makeFields(...options.map(({ element }) => element));
  return {
    hands: [{ draw: drawFound }, makeRegion(context, picture, () => isMore)],
    over: [makeFoundVerdict(context)],
    foot: [hint],
    below: makeRow(tests.element, more.element, film),
    beside: [makeClasses(tool), makePart(makeChannels(context), fields), makeScore(context),
      makeThresholds(context)],
  };
});

/** Report whether the robot was found, or the reason. */
function makeFoundVerdict(context) {
  const { element, show } = makeVerdict();
  context.on("frame", ({ found, missed: why }) => {
    if (found) show("good", text(why ? "found_robot_why" : "found_robot", { why }));
    else show("poor", why ? text("not_seen", { why }) : "");
  });
  return make("div.robsim-camera-badges", element);
}

/** The classes' finds in the picture: the pixels of each class, and the boxes of the blobs. */
function drawFound(scene) {
  const { pen, frame, lens, context } = scene;
  pen.imageSmoothingEnabled = false;
  if (frame.mask) drawMask(pen, frame, lens);
  if (context.state.tests) drawBoxes(scene);
}

/** Draw the mask, which has each pixel of the picture, or each second one, and so on. */
function drawMask(pen, { mask, size }, { left, top, scale }) {
  const side = Math.round(Math.max(...size) / Math.max(mask.width, mask.height)) * scale;
  pen.drawImage(mask, left, top, mask.width * side, mask.height * side);
}

function drawBoxes({ pen, frame, pixel, unit, context }) {
  const css = new Map(context.state.classes.map((one) => [one.name, one.css]));
  pen.lineWidth = unit;
  for (const [name, left, top, right, bottom] of frame.boxes) {
    const [x, y] = pixel([left - 0.5, top - 0.5]);
    const [x2, y2] = pixel([right + 0.5, bottom + 0.5]);
    pen.strokeStyle = css.get(name) ?? "magenta";
    pen.strokeRect(x, y, x2 - x, y2 - y);
  }
}

/** The ranges as text, as they stand in a colour file: edited, copied, saved. */
function makeThresholds(context) {
  let isMine = false; // edited here, and not taken yet
  let last = ""; // Python's last text; a refused text stays for correction
  const take = () => {
    if (isMine) context.send({ type: "thresholds", text: area.value });
    isMine = false;
  };
  const area = make("textarea.robsim-code.robsim-thresholds", { name: "thresholds",
    spellcheck: false, ariaLabel: text("thresholds"),
    onchange: take, oninput: () => (isMine = true),
    onkeydown: ({ key, ctrlKey, metaKey }) => key == "Enter" && (ctrlKey || metaKey) && take() });
  const copy = makeCopyButton(() => area.value);
  const where = make("span.robsim-quiet.robsim-place");
  const file = makeTextField("file", () => {}, { maxLength: 200, ariaLabel: text("color_file") });
  const save = makeAct(context, "save_colors", "robsim-primary", () =>
    ({ type: "save", file: file.value.trim() }));
  context.on("state", ({ text: told, file: name, place, classes }) => {
    if (!isMine && told != last) area.value = last = told;
    showIn(file, name);
    say(where, text("color_place", { place }));
    save.disabled = !classes.length;
  });
  const heading = make("div.robsim-card-title", text("thresholds"));
  return makePart(heading, area, makeRow(copy, file, save), where);
}
