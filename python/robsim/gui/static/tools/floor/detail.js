// @ts-check
// The pixels around a point as the camera has them, for a magnifying glass: asked of Python, always
// for the newest point, and one answer after the other.
import { asBytes } from "../../base/buffers.js";

const ANSWER_PATIENCE = 400; // ms, after which it is asked again

/**
 * `glass` is its number, which comes back with the answer; `half()` how many pixels it wants to
 * each side; `changed` is told of each answer.
 */
export function makeDetail(context, { glass, half, changed }) {
  let wanted = null; // [u, v]
  let isAsked = false; // and there was no answer yet
  let isOld = true; // another point, or another picture, than was asked for
  let timer = 0;
  const detail = { box: null, image: null };
  const ask = () => {
    if (!wanted || isAsked || !isOld) return;
    [isAsked, isOld] = [true, false];
    timer = setTimeout(() => {
      [isAsked, isOld] = [false, true];
      ask();
    }, ANSWER_PATIENCE);
    context.send({ type: "magnify", at: wanted, half: half(), glass });
  };
  context.on("detail", (head, [buffer]) => {
    if (head.glass != glass) return;
    clearTimeout(timer);
    isAsked = false;
    Object.assign(detail, { box: head.box, image: imageOf(head.box, asBytes(buffer)) });
    changed();
    ask();
  });
  context.on("frame", () => {
    isOld = true;
    ask();
  });
  context.onEnd(() => clearTimeout(timer));
  return Object.assign(detail, {
    want: (at) => {
      if (at && wanted && at[0] == wanted[0] && at[1] == wanted[1]) return;
      wanted = at;
      isOld = true;
      ask();
    },
    /** Ask for the same point again, such as for more around it. */
    again: () => {
      isOld = true;
      ask();
    },
  });
}

/** Return a canvas with pixels that come as red, green, blue; null where there are none. */
function imageOf([, , width, height], bytes) {
  if (!width || !height) return null;
  const pixels = new ImageData(width, height);
  for (let i = 0, at = 0; i < bytes.length; i += 3, at += 4) {
    pixels.data.set(bytes.subarray(i, i + 3), at);
    pixels.data[at + 3] = 255;
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}
