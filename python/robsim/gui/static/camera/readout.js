// The readout under the pointer: the position on the work area, and on the robot its poses.
import { make, text } from "../base/dom.js";
import { distance, isInside, toRobot } from "../base/geometry.js";
import { makeSwatch } from "../base/icons.js";

const toDegrees = (radians) => (radians * 180) / Math.PI;
const digits = (value) => value.toFixed(1).replace("-", "\u2212");

const placeCells = ([x, y]) => [`x ${digits(x)}`, `y ${digits(y)} px`, ""];
const poseCells = ([x, y, heading]) =>
  [digits(x), digits(y), `${digits(toDegrees(heading))}\u00b0`];

function estimateCells({ pose, covariance }) {
  if (!covariance) return poseCells(pose);
  const errors = [0, 4, 8].map((i) => Math.sqrt(Math.max(covariance[i], 0)));
  const spread = poseCells(errors);
  return poseCells(pose).map((value, i) => `${value.replace("\u00b0", "")} \u00b1 ${spread[i]}`);
}

function poseRows(frame) {
  return [
    ["measured", frame.measured && poseCells(frame.measured)],
    ["held", !frame.measured && frame.held && poseCells(frame.held)],
    ["estimated", frame.estimate && estimateCells(frame.estimate)],
    ["true", frame.truth && poseCells(frame.truth)],
  ].filter(([, cells]) => cells);
}

export function makeReadout(context) {
  const element = make("div.robsim-camera-readout", { role: "status" });
  const row = (first, cells) =>
    [first, ...cells.map((textContent) => make("span", { textContent }))];
  const poseRow = ([name, cells]) => {
    const mark = makeSwatch("box", `var(--robsim-${name})`);
    return row(make("span.robsim-quiet", mark, text(`readout.${name}`)), cells);
  };
  const isOnRobot = (at) => {
    const { frame, setup } = context;
    const center = frame.measured ?? frame.held ?? frame.estimate?.pose ?? frame.truth;
    if (!center) return false;
    return isInside(setup.robot.outline, toRobot(center, at)) || distance(center, at) < 10;
  };
  /** Show the data at a point of the work area; null = no data. */
  const show = (at) => {
    const isThere = at && context.frame && Number.isFinite(at[0]);
    element.classList.toggle("robsim-away", !isThere);
    if (!isThere) return;
    const rows = isOnRobot(at) ? poseRows(context.frame).flatMap(poseRow) : [];
    element.replaceChildren(...row(make("span"), placeCells(at)), ...rows);
  };
  show(null);
  return { element, show };
}
