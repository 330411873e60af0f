// @ts-check
// How wide the picture is on the screen, which is as fine as Python needs to send it.

const USUAL_CAMERA_WIDTH = 600; // px, where nothing is laid out yet
const SIZE_REST = 200; // ms without a change before Python is told

/** `width` gives it in device pixels. */
export function makeWidthTeller(context, width) {
  let told = 0;
  let timer = 0;
  const known = () => width() || Math.round(USUAL_CAMERA_WIDTH * devicePixelRatio);
  const send = () => {
    if (!context.setup || known() == told) return;
    context.send({ type: "size", width: (told = known()) });
    // comes again too
    if (context.looking != null) context.send({ type: "look", k: context.looking });
  };
  context.onEnd(() => clearTimeout(timer));
  return {
    /** What is said with hello. */
    first: () => (told = known()),
    tell: () => {
      clearTimeout(timer);
      timer = setTimeout(send, SIZE_REST);
    },
  };
}
