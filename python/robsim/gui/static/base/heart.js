// The sign of life: Python gives one every two seconds, beside any run or cell.
import { isPage, make, sayOrHide, text } from "./dom.js";

const LOOK = 1000; // ms between two looks
const SLEPT = 3000; // ms without a look: a tab in the background, or a closed lid
const [SILENT, LOST] = [8, 20]; // s without a word, after which that is said; it is in the way
const ASK = 10; // s of silence, after which it is asked again

const SETTING = // has no effect after the end
  ".robsim-tool, .robsim-controls, .robsim-timeline, .robsim-camera-bar, .robsim-open-tools";

/** Make it for a view; `begin` says hello, which brings all that was missed. */
export function makeHeart(el, begin) {
  let heard = performance.now();
  let looked = heard;
  let isCut = false; // for certain
  let isClosed = false;
  const words = make("strong");
  const silent = make("p.robsim-silent.robsim-surface.robsim-afloat", { role: "status", hidden: true });
  const where = isPage() ? "page" : "notebook";
  const card = (state, what, todo) =>
    make(`div.robsim-surface.robsim-afloat.robsim-card.robsim-lost-${state}`,
      what, make("p", text(todo)));
  const title = (name) => make("strong", text(name));
  const lost = make("div.robsim-lost", { role: "alert" },
    card("lost", title("lost"), "lost.again"), card("gone", title("gone"), `gone.${where}`),
    card("silent", words, `silent.${where}`), card("cut", title("gone"), "gone.notebook"));
  el.append(silent, lost);

  const show = () => {
    const seconds = Math.floor((performance.now() - heard) / 1000);
    const isOver = ["closed", "lost", "gone"].includes(el.dataset.state);
    const isSilent = !isOver && seconds >= SILENT;
    const line = isOver ? "" : isCut ? "cut" : seconds >= LOST ? "silent" : "";
    words.textContent = text("silent", { seconds });
    sayOrHide(silent, isClosed ? text(isPage() ? "remark.closed.page" : "remark.closed")
      : isSilent && !line ? words.textContent : "");
    if (line != (el.dataset.line ?? "")) Object.assign(el.dataset, { line });
    for (const part of el.children)
      if (part != lost && !isOver) part.inert = Boolean(line);
    if (isSilent && !isCut && seconds % ASK == 0) begin();
  };
  const timer = setInterval(() => {
    const now = performance.now();
    if (now - looked > SLEPT) heard = now;
    looked = now;
    show();
  }, LOOK);
  return {
    heard() {
      const wasLost = Boolean(el.dataset.line);
      heard = performance.now();
      isCut = false;
      if (!wasLost) return;
      show();
      begin();
    },
    /** Python has said its last word. */
    close() {
      isClosed = true;
      el.dataset.state = "closed";
      for (const part of el.querySelectorAll(SETTING)) part.inert = true;
      show();
    },
    cut() {
      isCut = true;
      show();
    },
    end: () => clearInterval(timer),
  };
}
