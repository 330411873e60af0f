// A magnifying glass on the robot, or where the pointer is: what vision makes of the pixels.
import { make, text } from "../base/dom.js";
import { distance, fromRobot } from "../base/geometry.js";
import { imageFrom, makeGlass } from "./glass.js";
import { areaToPixel } from "./projection.js";
import { drawLine } from "./strokes.js";

const ZOOM = 8; // px of the screen for one of the camera, where the pointer is
const GROUND = 0.4; // how bright pixels without a class are
const FIT = { isClosed: true, width: 1 };

export function makeRobotGlass(context) {
  let zoom = ZOOM;
  const words = make("output.robsim-number");
  const imageOf = (box, [colors, classes]) => {
    const inks = context.setup.colors.map(({ css }) => rgbOf(css));
    const counts = new Array(inks.length + 1).fill(0);
    for (const one of classes) counts[one]++;
    words.textContent = context.setup.colors.map(({ name }, i) =>
      text("robot_glass.classes", { name, count: counts[i + 1] })).join("  ");
    return imageFrom(box, (i) => inks[classes[i] - 1]
      ?? colors.subarray(3 * i, 3 * i + 3).map((side) => GROUND * side));
  };
  const over = (view) => {
    const { frame, setup } = context;
    if (!frame.measured) return;
    const toPixel = areaToPixel(frame);
    const shown = (points) => points.map((point) =>
      view.at(toPixel(fromRobot(frame.measured, point))));
    for (const points of setup.robot.markers) drawLine(view, shown(points), "#fff", FIT);
    drawLine(view, shown(setup.robot.outline), context.ink("measured"), FIT);
  };
  const glass = makeGlass(context,
    { glass: 0, zoom: () => zoom, over, imageOf, label: text("robot_glass") });
  glass.canvas.role = "img";
  const element = make("div.robsim-robot-glass", { hidden: true });
  const place = (scene, pointed) => {
    const { frame: { measured, held, estimate }, setup: { robot: { markers } } } = context;
    const pose = measured ?? held ?? estimate?.pose;
    if (pointed || !pose) return [pointed, []];
    const points = markers.length ? markers.flat() : [[0, 0]];
    const around = points.map((point) => scene.pixelOf(fromRobot(pose, point)));
    return [middleOf(around), around];
  };
  /** Show the place of a pixel, or both markers, in a scene; without a scene nothing. */
  const show = (scene, pointed) => {
    const [at, around] = scene ? place(scene, pointed) : [null, []];
    if (element.hidden != !at) {
      element.hidden = !at;
      element.replaceChildren(...(at ? [glass.canvas, words] : []));
    }
    if (at) {
      const isRight = scene.pixel(at)[0] > scene.pen.canvas.width / 2;
      element.classList.toggle("robsim-left", isRight);
      const reach = Math.max(0, ...around.map((point) => distance(at, point)));
      zoom = reach ? glass.canvas.clientWidth / (2.1 * reach) : ZOOM;
    }
    glass.show(at ?? null);
  };
  return { element, show };
}

const middleOf = (points) =>
  [0, 1].map((i) => points.reduce((sum, point) => sum + point[i] / points.length, 0));

const rgbOf = (css) => {
  const pen = new OffscreenCanvas(1, 1).getContext("2d");
  pen.fillStyle = css;
  pen.fillRect(0, 0, 1, 1);
  return pen.getImageData(0, 0, 1, 1).data.subarray(0, 3);
};
