// @ts-check
// The camera's picture, and what is drawn over it.
import { make } from "../base/dom.js";
import { makeBadges } from "../camera/badges.js";
import { isShown, makeOverlays } from "../camera/overlays.js";
import { makePicture } from "../camera/picture.js";
import { makeProjection } from "../camera/projection.js";
import { makeReadout } from "../camera/readout.js";
import { makeShowMenu } from "../camera/show_menu.js";
import { makeTools } from "../camera/tools.js";

const CAMERA_COLORS = [
  "measured", "held", "true", "estimated", "estimated-band", "other-2", "other-5",
];

export function makeCamera(context) {
  const overlays = makeOverlays();
  const readout = makeReadout(context);
  let hovered = null; // a point of the canvas
  const draw = (scene) => {
    const at = projection.areaOf(hovered);
    drawCamera(scene, { overlays, tools, projection, at });
    readout.show(tools.cross() ?? at);
  };
  const tool = pointerOf(() => ({ projection, tools }), (at) => {
    hovered = at;
    picture.later();
  });
  const picture = makePicture(context, { label: "camera_label", inks: CAMERA_COLORS, draw, tool });
  const projection = makeProjection(context, picture.lens);
  const tools = makeTools(context, picture.canvas, picture.changed);

  const subscribe = () => context.setup && context.want(columnsFor(overlays, context));
  for (const event of ["setup", "local"]) context.on(event, subscribe);

  const bar = [picture.whole, ...tools.buttons, makeShowMenu(context, overlays)];
  const element = make("div", { className: "robsim-camera" }, picture.canvas, makeBadges(context),
    make("div", { className: "robsim-camera-bar" }, ...bar),
    make("div", { className: "robsim-camera-foot" }, readout.element, tools.hint));
  return { element, width: picture.width };
}

function drawCamera(scene, { overlays, tools, projection, at }) {
  const { context } = scene;
  const colors = context.setup.colors ?? [];
  scene.place = projection.toCanvas();
  scene.classColors = new Map(colors.map(({ name, css }) => [name, css]));
  for (const overlay of overlays) if (isShown(context, overlay)) overlay.draw(scene);
  tools.draw(scene, at);
}

/** What a pointer does on the picture: the tools have points of the work area. */
function pointerOf(parts, hover) {
  const onArea = (at, act) => parts().projection.areaOf(at) != null &&
    act(parts().projection.toArea(at), parts().tools);
  return {
    hover,
    isActive: () => parts().tools.active() != "look",
    takesDrags: () => parts().tools.active() == "draw_path",
    click: (at) => onArea(at, (place, tools) => tools.click(place)),
    doubleClick: () => parts().tools.doubleClick(),
    dragStart: (at) => onArea(at, (place, tools) => tools.dragStart(place)),
    drag: (_, to) => {
      const { projection, tools } = parts();
      tools.drag(projection.toArea(to), projection.pixelSize());
    },
    dragEnd: () => parts().tools.dragEnd(parts().projection.pixelSize()),
    giveUp: () => parts().tools.giveUp(),
    key: (event) => parts().tools.key(event),
  };
}

function columnsFor(overlays, context) {
  const { setup } = context;
  const there = new Set((setup.columns ?? []).map(({ name }) => name));
  const shown = overlays.filter((overlay) => isShown(context, overlay));
  return shown.flatMap(({ columns }) => columns?.(setup) ?? []).filter((name) => there.has(name));
}
