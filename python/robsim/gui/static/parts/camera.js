// The camera's picture with its overlays.
import { make, sayOrHide, text } from "../base/dom.js";
import { isShown, makeOverlays } from "../camera/overlays.js";
import { makePicture } from "../camera/picture.js";
import { areaOf, areaToPixel } from "../camera/projection.js";
import { makeReadout } from "../camera/readout.js";
import { makeRobotGlass } from "../camera/robot_glass.js";
import { makeShowMenu } from "../camera/show_menu.js";
import { makeTools } from "../camera/tools.js";

export function makeCamera(context) {
  const overlays = makeOverlays();
  const readout = makeReadout(context);
  const hands = [];
  const picture = makePicture(context, { label: "camera_label", hands });
  const tools = makeTools(context, picture);
  let hovered = null; // a pixel
  const hover = (pixel) => {
    hovered = pixel;
    picture.later();
  };
  const glass = makeRobotGlass(context);
  const isMagnified = () => isShown(context, overlays.find(({ name }) => name == "glass"));
  const draw = (scene) => {
    const at = areaOf(context, hovered);
    drawCamera(scene, { overlays, tools, at });
    glass.show(isMagnified() && scene, hovered);
    readout.show(tools.cross() ?? at);
  };
  hands.push({ hover, draw, key: tools.key }, tools.hand);

  context.on("cursor ghosts", picture.later);
  const subscribe = () => context.setup && context.want(columnsFor(overlays, context));
  context.on("setup local", subscribe);

  const bar = [picture.whole, ...tools.buttons, makeShowMenu(context, overlays)];
  const element = make("div.robsim-camera", picture.canvas, makeBadges(context), glass.element,
    make("div.robsim-camera-bar", ...bar),
    make("div.robsim-camera-foot", readout.element, tools.hint));
  return { element, width: picture.width };
}

function drawCamera(scene, { overlays, tools, at }) {
  const { context } = scene;
  const colors = context.setup.colors ?? [];
  const toPixel = areaToPixel(scene.frame);
  scene.pixelOf = toPixel;
  scene.place = (point) => scene.pixel(toPixel(point));
  scene.classColors = new Map(colors.map(({ name, css }) => [name, css]));
  for (const overlay of overlays) if (isShown(context, overlay)) overlay.draw(scene);
  tools.draw(scene, at);
}

function columnsFor(overlays, context) {
  const { setup } = context;
  const there = new Set((setup.columns ?? []).map(({ name }) => name));
  const shown = overlays.filter((overlay) => isShown(context, overlay));
  return shown.flatMap(({ columns }) => columns?.(setup) ?? []).filter((name) => there.has(name));
}

/** Remarks on the picture: that it is a past one, that the robot was not seen. */
function makeBadges(context) {
  const words = text("past_step.title");
  const past = make("button.robsim-chip.robsim-active", { type: "button", name: "past_step",
    title: words, ariaLabel: words, hidden: true, onclick: () => context.look(null) });
  const missed = make("div.robsim-chip.robsim-warning", { hidden: true });
  context.on("shown", () =>
    sayOrHide(past, context.marked == null ? "" : text("past_step", { k: context.marked })));
  context.on("frame", (frame) => sayOrHide(missed, pictureRemark(frame)));
  return make("div.robsim-camera-badges", past, missed);
}

function pictureRemark({ picture, missed }) {
  if (!picture) return text("no_frame");
  return missed ? text("not_seen", { why: missed }) : "";
}
