// The gauge of the NEES: whether a state estimator is as sure as it is right.
import { make, say, set, text } from "../base/dom.js";
import { numberText } from "./scale.js";

const EXPECTED = 3; // of a pose
const DECADES = 1; // of the scale, to each side
const LEVELS = { consistent: "good", conservative: "warning", optimistic: "bad" };

/** Return where a value stands on the scale, which is logarithmic (%). */
const placeOf = (value) =>
  Math.min(Math.max(50 + (50 / DECADES) * Math.log10(Math.max(value, 1e-9) / EXPECTED), 0), 100);

export function makeNees(context) {
  const scale = make("div.robsim-nees-scale", make("i"), make("b"));
  const words = make("span");
  const element = make("div.robsim-nees", { role: "meter", hidden: true,
    ariaLabel: text("nees"), ariaValueMin: "0" }, make("span.robsim-quiet", text("nees")),
  scale, words);
  context.on("statistics", ({ nees }) => {
    element.hidden = !nees;
    if (!nees) return;
    const { why, mean, n, band = [], verdict } = nees;
    const [low, high] = band.map((end) => numberText(end, 2));
    say(words, why ? text(`nees.${why}`) : `${numberText(mean, 2)} ${text(`nees.${verdict}`)}`);
    words.className = `robsim-${LEVELS[verdict] ?? "quiet"}`;
    scale.hidden = Boolean(why);
    const title = why ? text("nees.title") : [text("nees.band", { n, low, high }),
      text("nees.title")].join(" ");
    set(element, { title, ariaValueText: words.textContent, ariaValueNow: String(mean ?? 0) });
    if (why) return;
    const [zone, mark] = scale.children;
    const [from, to] = band.map(placeOf);
    Object.assign(zone.style, { left: `${from}%`, width: `${to - from}%` });
    mark.style.left = `${placeOf(mean)}%`;
  });
  return element;
}
