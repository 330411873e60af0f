// The host's entry point: render({model, el}). It only uses get, send, on and off of the model.
import { renderColors } from "./tools/colors.js";
import { renderFloor } from "./tools/floor.js";
import { renderPanel } from "./panel.js";
import { renderRobots } from "./tools/robots.js";
import { renderStart } from "./start/start.js";
import { isPage, make } from "./base/dom.js";
import { guardFromDrops } from "./tools/load.js";
import { makeHeart } from "./base/heart.js";

const VIEWS = { panel: renderPanel, start: renderStart, colors: renderColors, floor: renderFloor,
  robots: renderRobots };

function render({ model, el }) {
  const id = crypto.getRandomValues(new Uint32Array(2)).join("");
  const still = model.get("still");
  el.classList.add("robsim");
  // The picture for those without a kernel, which lies below.
  const hides = `.robsim-still-${still} { display: none !important; }`;
  if (still) el.append(make("style", { textContent: hides }));
  const send = (message, buffers) => model.send({ ...message, id }, undefined, buffers);
  guardFromDrops(isPage() ? window : el); // beside the view, too, and while that is lost
  const view = VIEWS[model.get("kind")]({ el, send });
  let queue = Promise.resolve();
  const heart = makeHeart(el, view.begin);
  const receive = (head, buffers) => {
    heart.heard();
    view.arrived(head);
    const take = () => head.type == "closed" ? heart.close() : view.receive(head, buffers ?? []);
    queue = queue.then(take).catch((error) => console.error(error));
    return queue; // for tests
  };
  const bye = () => send({ type: "bye" });
  model.on("msg:custom", receive);
  model.on("comm_live_update", heart.cut); // of Jupyter's widgets: the kernel was restarted
  addEventListener("pagehide", bye);
  view.begin();
  return () => {
    view.end();
    heart.end();
    removeEventListener("pagehide", bye);
    model.off("msg:custom", receive);
    model.off("comm_live_update", heart.cut);
    bye();
  };
}

export default { render };
