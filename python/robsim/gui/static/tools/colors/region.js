// The region of a colour: a rectangle that is drawn on the picture, or moved by keys.
import { heldValue } from "../../base/fields.js";
import { arrowStep } from "../../base/gestures.js";
import { drawBox } from "../../camera/strokes.js";

const FIRST = 0.05; // of the picture: a region that the keys begin with
const REGION_INK = "#ffd500";

/** Regions are [left, top, right, bottom], all included; `isMore()`: those before stay. */
export function makeRegion(context, picture, isMore) {
  let region = null;
  let kept = 0; // regions of the class that stay beside this one
  const size = () => context.frame.size;
  const inside = (pixel) => pixel.map((at, i) =>
    Math.min(Math.max(Math.round(at), 0), size()[i] - 1));
  const between = ([a, b], [c, d]) =>
    [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)];
  const show = (shown) => {
    region = shown;
    picture.later();
  };
  const { set, tell, hold } = heldValue(show, (next, goesOn) =>
    context.send({ type: "region", region: next, keep: kept, goes_on: goesOn }));
  context.on("state", ({ region: told }) => tell(told));
  const beginOther = () => {
    const { classes, chosen } = context.state;
    kept = (isMore() && classes.find(({ name }) => name == chosen)?.drift.length) || 0;
  };
  const begin = () => {
    const half = Math.max(1, Math.round((FIRST * Math.min(...size())) / 2));
    beginOther();
    set([-half, half].flatMap((by) => inside(size().map((side) => side / 2 + by))));
  };
  const move = (step) => {
    const sides = [region[2] - region[0], region[3] - region[1]];
    const at = inside([region[0] + step[0], region[1] + step[1]]).map((value, i) =>
      Math.min(value, size()[i] - 1 - sides[i]));
    set([...at, at[0] + sides[0], at[1] + sides[1]]);
  };
  return {
    isOn: () => true,
    grab: (at) => {
      if (!picture.has(at)) return null;
      beginOther();
      hold();
      return { at, move: (to) => set(between(inside(at), inside(to))) };
    },
    key: (event) => {
      const step = arrowStep(event);
      if (event.key == "Enter" || (step && !region)) begin();
      else if (step) move(step);
      else return false;
      return true;
    },
    draw: (scene) => {
      if (!region) return;
      const [left, top, right, bottom] = region;
      drawBox(scene, scene.pixel([left - 0.5, top - 0.5]), scene.pixel([right + 0.5, bottom + 0.5]),
        REGION_INK);
    },
  };
}
