// Where the robot is to go: a point that is clicked, a path that is drawn, both also by keys.
import { makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";
import { distance, simplified } from "../base/geometry.js";
import { ARROWS } from "../base/gestures.js";
import { areaOf, pixelToArea } from "./projection.js";
import { drawDot, drawLine } from "./strokes.js";

const CROSS_STEP = 10; // px of the work area; with Shift ten times as many
const TOOLS = ["go_to", "draw_path"];
const MOST_PATH_POINTS = 200;
const DRAW_TOLERANCE = 2; // px on the screen that a drawn line may be simplified by

/** Make the tools of the pointer on a picture: "look", "go_to" and "draw_path". */
export function makeTools(context, picture) {
  const draft = makeDraft();
  const cross = makeCross(context);
  let chosen = null; // by a button; null = as the robot is driven
  let control;

  const active = () => {
    if (!canSteer(context)) return "look";
    return chosen ?? (context.state.values?.control == "go-to-point" ? "go_to" : "look");
  };
  const hint = makeHint(() => finish(), () => leave());
  const buttons = TOOLS.map((name) => makeTextButton(name, "", () => choose(name), `tool.${name}`));
  const show = () => {
    for (const button of buttons) {
      button.setAttribute("aria-pressed", String(active() == button.name));
      button.hidden = !canSteer(context);
    }
    hint.show(chosen == null ? "look" : active(), draft.points.length > 1);
    picture.changed();
  };
  const leave = () => {
    chosen = null;
    draft.clear();
    show();
  };
  const choose = (name) => {
    const wasActive = active() == name;
    leave();
    if (!wasActive) chosen = name;
    else if (active() == name) chosen = "look"; // the robot is driven so, but not by the mouse
    show();
    picture.canvas.focus({ preventScroll: true });
  };
  const finish = () => {
    if (draft.points.length < 2) return;
    context.send({ type: "path", points: draft.points });
    leave();
  };
  const set = (at) => {
    const [x, y] = inArea(context, at);
    if (active() == "go_to") context.send({ type: "go_to", x, y });
    if (active() == "draw_path") draft.add([x, y]);
    show();
  };
  const press = ({ key, shiftKey }) => {
    const isPath = active() == "draw_path";
    if (key == "Escape" && chosen) leave();
    else if (active() == "look") return false;
    else if (key in ARROWS) cross.move(ARROWS[key], shiftKey);
    else if (key == "Enter" && isPath) finish();
    else if ((key == "Enter" || key == " ") && cross.at) set(cross.at);
    else if (key == "Backspace" && isPath) draft.points.pop();
    else return false;
    show();
    return true;
  };

  const grabLine = (begin, at) => {
    const toArea = (pixel) => pixelToArea(context.frame)(pixel);
    const [u, v] = at;
    /** Return the approximate size of a screen pixel on the work area. */
    const size = () => distance(toArea([u, v]), toArea([u + picture.pixels(1), v])) || 1;
    draft.begin(inArea(context, begin));
    return {
      at,
      move: (to) => {
        draft.extend(inArea(context, toArea(to)), size());
        show();
      },
      drop: () => (draft.end(size()) ? finish() : show()),
      giveUp: () => {
        draft.giveUp();
        show();
      },
    };
  };

  context.on("state", ({ values }) => {
    if (values?.control != control && chosen == "look") chosen = null;
    control = values?.control;
    show();
  });
  context.on("setup", show);
  return {
    buttons,
    hint: hint.element,
    key: press,
    cross: () => (active() == "look" ? null : cross.at),
    hand: {
      isOn: () => active() != "look",
      drags: () => active() == "draw_path",
      click: (pixel) => {
        const at = areaOf(context, pixel);
        if (!at) return;
        cross.at = null;
        set(at);
      },
      grab: (pixel) => {
        const at = active() == "draw_path" && picture.has(pixel) && areaOf(context, pixel);
        return at && grabLine(at, pixel);
      },
      doubleClick: () => {
        if (active() != "draw_path") return false;
        draft.settle();
        finish();
        return true;
      },
    },
    /** Draw the unfinished path. */
    draw: (scene, hovered) => {
      draft.draw(scene, cross.at ?? hovered);
      if (active() != "look") cross.draw(scene);
    },
  };
}

const canSteer = (context) => Boolean(context.setup) && context.setup.source != "trace";

function inArea(context, [x, y]) {
  const [width, height] = context.setup.area;
  return [Math.min(Math.max(x, 0), width - 1), Math.min(Math.max(y, 0), height - 1)];
}

/** A cross that the arrow keys move; it appears in the middle. */
function makeCross(context) {
  const cross = { at: null };
  cross.move = ([dx, dy], isFar) => {
    const step = isFar ? 10 * CROSS_STEP : CROSS_STEP;
    if (cross.at) cross.at = inArea(context, [cross.at[0] + step * dx, cross.at[1] + step * dy]);
    else cross.at = context.setup.area.map((side) => Math.round(side / 2));
  };
  cross.draw = (scene) => {
    if (!cross.at) return;
    const [x, y] = scene.place(cross.at);
    const long = 12 * scene.unit;
    const color = scene.ink("other-2");
    drawLine(scene, [[x - long, y], [x + long, y]], color);
    drawLine(scene, [[x, y - long], [x, y + long]], color);
  };
  return cross;
}

/** The hint of a tool, at the edge of the picture. */
function makeHint(finish, leave) {
  const words = make("span");
  const done = makeTextButton("path_done", "robsim-primary", finish);
  const cancel = makeTextButton("path_cancel", "", leave);
  const element = make("div.robsim-camera-hint.robsim-row.robsim-afloat", { hidden: true }, words,
    done, cancel);
  const show = (tool, isPath) => {
    element.hidden = tool == "look";
    words.textContent = element.hidden ? "" : text(`tool.${tool}.hint`);
    done.hidden = !isPath;
  };
  return { element, show };
}

/**
 * A path that is being drawn: corners that are clicked, lines that are drawn with the button down.
 * Points are on the work area; `size` = the size of a screen pixel there.
 */
function makeDraft() {
  const draft = { points: [] };
  let stroke = null; // the point with which the line under way begins

  draft.clear = () => [draft.points, stroke] = [[], null];
  draft.add = (point) => {
    if (draft.points.length < MOST_PATH_POINTS) draft.points.push(point);
  };
  draft.begin = (point) => {
    stroke = draft.points.length;
    draft.points.push(point);
  };
  draft.extend = (point, size) => {
    if (distance(draft.points.at(-1), point) > size) draft.points.push(point);
  };
  /** End the line under way; return whether it is all that there is. */
  draft.end = (size) => {
    const [before, drawn] = [draft.points.slice(0, stroke), draft.points.slice(stroke)];
    const room = MOST_PATH_POINTS - before.length;
    const simple = simplified(drawn, DRAW_TOLERANCE * size, Math.max(room, 2));
    draft.points = [...before, ...simple.slice(0, room)];
    stroke = null;
    return !before.length;
  };
  draft.giveUp = () => {
    if (stroke != null) draft.points.length = stroke;
    stroke = null;
  };
  /** Drop corners that were set twice, as by a double click. */
  draft.settle = () => {
    draft.points = draft.points.filter((point, i, all) => !i || distance(point, all[i - 1]) > 1);
  };
  draft.draw = (scene, end) => {
    if (!draft.points.length) return;
    const isOpen = stroke == null;
    const color = scene.ink("other-2");
    const line = isOpen && end ? [...draft.points, end] : draft.points;
    drawLine(scene, line.map(scene.place), color, { width: 2 });
    if (isOpen) for (const point of draft.points) drawDot(scene, scene.place(point), color, 3);
  };
  return draft;
}
