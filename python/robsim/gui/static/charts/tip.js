// @ts-check
// What a chart says of the step under the cursor, beside it.
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";
import { layerName, layerText } from "./frame.js";
import { inksOf } from "./inks.js";
import { makeSwatch } from "./swatch.js";

const TIP_GAP = 12; // px from the cursor

/** Return a step and its time as a text. */
export function stepText(context, k) {
  const t = context.store.get("t")?.get(k, 0) ?? k * context.setup.dt;
  return text("chart.step_and_time", { k, t: t.toFixed(2) });
}

export function makeTip(context) {
  const element = make("div", { className: "robsim-tip robsim-surface", hidden: true });
  const ink = inksOf(context);
  const row = (layer, unit, k) => {
    const swatch = makeSwatch(layer.kind ?? "none", layer.ink ? ink(layer.ink) : "transparent");
    const value = make("b", { textContent: `${layerText(layer, k)} ${unit}` });
    return make("div", {}, swatch, make("span", { textContent: layerName(layer) }), value);
  };
  const fill = (chart, k) => {
    const known = [...chart.shown, ...chart.reads].filter(({ series }) =>
      Number.isFinite(series.value(k)));
    const isMissed = known.some(({ name }) => name == "held");
    element.replaceChildren(
      make("strong", { textContent: stepText(context, k) }),
      ...known.map((layer) => row(layer, layer.unit ?? chart.unit, k)),
      ...(isMissed ? [make("em", { textContent: text("chart.missed") })] : []),
    );
  };
  const place = (chart, k) => {
    const { box, plot } = chart;
    const [x, width, room] = [plot.x(k), element.offsetWidth, chart.size[0]];
    const isRight = x + width + TIP_GAP <= room || x < width + TIP_GAP;
    const left = isRight ? x + TIP_GAP : x - width - TIP_GAP;
    element.style.left = `${Math.max(0, Math.min(left, room - width))}px`;
    element.style.top = `${box.top + 6}px`;
  };
  return {
    /** Show what a chart says of a step; null = nothing. */
    show(chart, k) {
      element.hidden = !chart || k === null;
      if (element.hidden) return;
      if (element.parentNode != chart.main) chart.main.append(element);
      fill(chart, k);
      place(chart, k);
    },
  };
}
