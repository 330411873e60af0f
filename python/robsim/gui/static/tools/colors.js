// @ts-check
// The panel that trains colours: a region of the picture, ranges, what they find.
import { make, say } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { text } from "../base/texts.js";
import { makeChannels } from "./colors/channels.js";
import { makeClasses } from "./colors/classes.js";
import { drawFound } from "./colors/found.js";
import { makeRegion } from "./colors/region.js";
import { makeScore } from "./colors/score.js";
import { makeThresholds } from "./colors/thresholds.js";
import { makeFields, makePart, makeRow } from "./pieces.js";
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
  const className = "robsim-camera-hint robsim-row";
  const hint = make("div", { className, textContent: text("region_hint") });
  context.on("state", ({ region }) => (hint.hidden = Boolean(region)));
  const [tests, ...options] = [{ name: "tests", kind: "switch" }, ...OPTIONS].map((option) =>
    makeField(option, (value, goesOn) =>
      context.send({ type: "set", name: option.name, value, goes_on: goesOn })));
  context.on("state", (state) => {
    tests.show(state.tests);
    for (const field of options) field.show(state.options[field.name]);
  });
  context.onEnd(...[more, tests, ...options].map(({ end }) => end));
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

/** Say whether the robot was found, and if not, why. */
function makeFoundVerdict(context) {
  const chip = make("div", { className: "robsim-chip", role: "status" });
  context.on("frame", ({ found, missed }) => {
    chip.hidden = !found && !missed;
    chip.classList.toggle("robsim-good", Boolean(found));
    chip.classList.toggle("robsim-warning", !found);
    const seen = missed ? text("found_robot_why", { why: missed }) : text("found_robot");
    say(chip, found ? seen : text("not_seen", { why: missed ?? "" }));
  });
  return make("div", { className: "robsim-camera-badges" }, chip);
}
