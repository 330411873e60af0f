// @ts-check
// The camera's picture, and what is drawn over it.
import { makeTextButton } from "../base/buttons.js";
import { make, painter } from "../base/dom.js";
import { text } from "../base/texts.js";
import { color } from "../base/theme.js";
import { makeBadges } from "../camera/badges.js";
import { watchGestures } from "../camera/gestures.js";
import { makeLens } from "../camera/lens.js";
import { isShown, makeOverlays } from "../camera/overlays.js";
import { makeProjection } from "../camera/projection.js";
import { makeReadout } from "../camera/readout.js";
import { makeShowMenu } from "../camera/show_menu.js";
import { makeTools } from "../camera/tools.js";
import { makeWidthTeller } from "../camera/width.js";

const CAMERA_COLORS = [
  "measured", "held", "true", "estimated", "estimated-band", "other-2", "other-5", "sunken",
];
// times as large as they are, the pixels of a picture are to be seen as such
const COARSE_PIXELS = 3;

export function makeCamera(context) {
  const canvas = make("canvas",
    { tabIndex: 0, role: "application", ariaLabel: text("camera_label") });
  const lens = makeLens();
  const projection = makeProjection(context, lens);
  const overlays = makeOverlays();
  const readout = makeReadout(context);
  const painting = { colors: {}, hovered: null }; // hovered: a point of the canvas
  const paint = () =>
    paintCamera(context, { canvas, lens, projection, overlays, tools, readout, painting });
  const later = painter(paint);
  const tools = makeTools(context, canvas, () => (setManners(), later()));
  const widths = makeWidthTeller(context, () => shownWidth(context, canvas, lens));

  const whole = makeTextButton("zoom_reset", "", () => zoomed(lens.reset));
  whole.ariaLabel = whole.title;
  whole.hidden = true;
  const zoomed = (zoom) => {
    zoom();
    whole.hidden = lens.zoom == 1;
    whole.textContent = `${lens.zoom.toFixed(1)}\u00d7`;
    setManners();
    later();
    widths.tell();
  };
  /** A finger scrolls the page unless the picture has something to do with it. */
  function setManners() {
    const isFree = lens.zoom == 1 && tools.active() != "draw_path";
    canvas.style.touchAction = isFree ? "pan-y" : "none";
    const cursor = lens.zoom > 1 ? "grab" : "default";
    canvas.style.cursor = tools.active() == "look" ? cursor : "crosshair";
  }
  const hover = (at) => {
    painting.hovered = at;
    later();
  };
  listenTo(canvas, { context, lens, projection, tools, zoomed, hover });

  const fit = () => {
    if (!fitCanvas(canvas)) return;
    paint();
    widths.tell();
  };
  const resizes = new ResizeObserver(fit);
  resizes.observe(canvas);
  const recolor = () => {
    const named = CAMERA_COLORS.map((name) => [name, color(context.el, `--robsim-${name}`)]);
    painting.colors = Object.fromEntries(named);
    later();
  };
  const subscribe = () => context.setup && context.want(columnsFor(overlays, context));
  for (const event of ["setup", "local"]) context.on(event, subscribe);
  for (const event of ["setup", "local", "theme"]) context.on(event, recolor);
  context.on("state", later);
  context.on("frame", paint); // at once: an animation frame later would be one more
  context.on("frame", widths.tell);
  context.onEnd(() => resizes.disconnect());
  context.onEnd(later.cancel);

  const bar = [whole, ...tools.buttons, makeShowMenu(context, overlays)];
  const element = make("div", { className: "robsim-camera" }, canvas, makeBadges(context),
    make("div", { className: "robsim-camera-bar" }, ...bar),
    make("div", { className: "robsim-camera-foot" }, readout.element, tools.hint));
  return { element, width: () => (fit(), widths.first()) };
}

function paintCamera(context, { canvas, lens, projection, overlays, tools, readout, painting }) {
  const pen = canvas.getContext("2d");
  pen.fillStyle = painting.colors.sunken ?? "gray";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const { frame, setup } = context;
  if (!frame?.picture || !setup) return;
  lens.fit([canvas.width, canvas.height], frame.size);
  const [width, height] = frame.size.map((side) => side * lens.scale);
  pen.imageSmoothingEnabled = width < COARSE_PIXELS * frame.picture.width;
  drawPicture(pen, frame, lens);

  const scene = {
    pen, context, frame, lens,
    colors: painting.colors,
    unit: devicePixelRatio,
    pixel: lens.toCanvas,
    place: projection.toCanvas(),
    classColors: new Map((setup.colors ?? []).map(({ name, css }) => [name, css])),
  };
  const hovered = projection.areaOf(painting.hovered);
  pen.save();
  pen.beginPath();
  pen.rect(lens.left, lens.top, width, height);
  pen.clip();
  for (const overlay of overlays) if (isShown(context, overlay)) overlay.draw(scene);
  tools.draw(scene, hovered);
  pen.restore();
  readout.show(tools.cross() ?? hovered);
}

/** Draw the picture, of which each pixel is some whole number of the camera's, without a rest. */
function drawPicture(pen, { picture, size }, { left, top, scale }) {
  const side = Math.floor(size[0] / picture.width) * scale;
  pen.drawImage(picture, left, top, picture.width * side, picture.height * side);
}

function listenTo(canvas, { context, lens, projection, tools, zoomed, hover }) {
  const { toArea, areaOf, pixelSize } = projection;
  let isTools = false; // the drag is the tool's
  watchGestures(canvas, {
    hover,
    click: (at) => areaOf(at) && tools.click(toArea(at)),
    doubleClick: () => tools.doubleClick() || zoomed(lens.reset),
    dragStart: (at) => (isTools = areaOf(at) != null && tools.dragStart(toArea(at))),
    drag: (from, to) => {
      if (isTools) tools.drag(toArea(to), pixelSize());
      else zoomed(() => lens.move([to[0] - from[0], to[1] - from[1]]));
    },
    dragEnd: () => isTools && tools.dragEnd(pixelSize()),
    giveUp: () => isTools && tools.giveUp(),
    zoom: (at, factor) => zoomed(() => lens.zoomAt(at, factor)),
    isZoomed: () => lens.zoom > 1,
  });
  const zoomBy = (factor) => () =>
    zoomed(() => lens.zoomAt([canvas.width / 2, canvas.height / 2], factor));
  const larger = zoomBy(1.25);
  const keys = { "+": larger, "=": larger, "-": zoomBy(0.8), 0: () => zoomed(lens.reset) };
  canvas.onkeydown = (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (keys[event.key]) keys[event.key]();
    else if (!context.frame || !tools.key(event)) return;
    event.preventDefault();
    if (event.key != "Escape") event.stopPropagation(); // that stops the robot too
  };
}

/** Give the canvas the pixels of its box; return whether it had others. */
function fitCanvas(canvas) {
  const box = canvas.getBoundingClientRect();
  const sides = [box.width, box.height].map((side) =>
    Math.max(1, Math.round(side * devicePixelRatio)));
  if (sides[0] == canvas.width && sides[1] == canvas.height) return false;
  [canvas.width, canvas.height] = sides;
  return true;
}

/** How wide the picture is on the screen, in device pixels; no wider than the camera's. */
function shownWidth({ frame }, canvas, lens) {
  if (!frame?.picture) return canvas.width > 1 ? canvas.width : 0;
  return Math.min(Math.round(frame.size[0] * lens.scale), frame.size[0]);
}

function columnsFor(overlays, context) {
  const { setup } = context;
  const there = new Set((setup.columns ?? []).map(({ name }) => name));
  const shown = overlays.filter((overlay) => isShown(context, overlay));
  return shown.flatMap(({ columns }) => columns?.(setup) ?? []).filter((name) => there.has(name));
}
