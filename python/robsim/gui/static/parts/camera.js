// @ts-check
// The camera's picture, and what is drawn over it.
import { make } from "../base/dom.js";
import { makeBadges } from "../camera/badges.js";
import { isShown, makeOverlays } from "../camera/overlays.js";
import { makePicture } from "../camera/picture.js";
import { areaOf, areaToPixel } from "../camera/projection.js";
import { makeReadout } from "../camera/readout.js";
import { makeShowMenu } from "../camera/show_menu.js";
import { makeTools } from "../camera/tools.js";

const CAMERA_COLORS = [
  "measured", "held", "true", "estimated", "estimated-band", "other-2", "other-5",
];

export function makeCamera(context) {
  const overlays = makeOverlays();
  const readout = makeReadout(context);
  const hands = [];
  const picture = makePicture(context, { label: "camera_label", inks: CAMERA_COLORS, hands });
  const tools = makeTools(context, picture);
  let hovered = null; // a pixel
  const hover = (pixel) => {
    hovered = pixel;
    picture.later();
  };
  const draw = (scene) => {
    const at = areaOf(context, hovered);
    drawCamera(scene, { overlays, tools, at });
    readout.show(tools.cross() ?? at);
  };
  hands.push({ hover, draw, key: tools.key }, tools.hand);

  const subscribe = () => context.setup && context.want(columnsFor(overlays, context));
  context.on("setup local", subscribe);

  const bar = [picture.whole, ...tools.buttons, makeShowMenu(context, overlays)];
  const element = make("div", { className: "robsim-camera" }, picture.canvas, makeBadges(context),
    make("div", { className: "robsim-camera-bar" }, ...bar),
    make("div", { className: "robsim-camera-foot" }, readout.element, tools.hint));
  return { element, width: picture.width };
}

function drawCamera(scene, { overlays, tools, at }) {
  const { context } = scene;
  const colors = context.setup.colors ?? [];
  const toPixel = areaToPixel(scene.frame);
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
