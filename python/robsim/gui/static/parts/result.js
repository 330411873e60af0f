// The result of Finish: the parameters estimated from the whole record, as a table and a figure.
import { asBytes } from "../base/buffers.js";
import { makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";
import { aboutVerdict } from "../charts/parameters.js";

const MOST_ERRORS = 4; // standard errors to each side in the bars
const ROUNDING = 1e-9; // of the largest parameter: smaller differences are ignored
const SHORTEST_PLAIN = 1e-3; // smaller numbers get an exponent
const NO_NUMBER = "\u2013";

const minus = (words) => words.replaceAll("-", "\u2212");
/** Return a number with five digits, so short that a narrow table has room for it. */
function shortNumber(value) {
  if (value == null) return NO_NUMBER;
  const rounded = Number(value.toPrecision(5));
  const isTiny = rounded && Math.abs(rounded) < SHORTEST_PLAIN;
  return minus(isTiny ? rounded.toExponential() : String(rounded));
}

export function makeResult(context) {
  let url = ""; // of the figure
  const begin = () => {
    finish.disabled = true;
    finish.textContent = text("result.busy");
    context.send({ type: "press", button: "finish" });
  };
  const finish = makeTextButton("finish_result", "robsim-primary", begin, "result.begin");
  const rest = () => {
    const isFirst = finish.classList.contains("robsim-primary");
    finish.disabled = false;
    finish.textContent = text(isFirst ? "result.begin" : "result.again");
  };
  const element = make("div.robsim-result");
  const forget = () => url && URL.revokeObjectURL(url);
  const clear = () => {
    finish.classList.add("robsim-primary");
    rest();
    const why = make("p", text("result.none"));
    element.replaceChildren(make("div.robsim-empty", why, finish));
  };

  const show = ({ rows, text: remarks, verdict, good }, [picture]) => {
    finish.classList.remove("robsim-primary");
    rest();
    forget();
    const blob = picture?.byteLength && new Blob([asBytes(picture)], { type: "image/png" });
    url = blob ? URL.createObjectURL(blob) : "";
    const chip = make("span", { ...aboutVerdict({ text: verdict, good }), hidden: !verdict });
    const head = make("div.robsim-result-head.robsim-row", chip, finish);
    element.replaceChildren(head, ...(rows.length ? [makeResultTable(rows)] : []));
    if (remarks)
      element.append(make("p.robsim-result-remarks", { textContent: remarks }));
    if (url) element.append(make("img.robsim-surface", { src: url, alt: text("result.figure") }));
  };
  clear();
  context.on("reset", clear); // the result was of the old run
  context.on("result", show);
  context.on("note", ({ level }) => level == "error" && rest());
  context.on("state", ({ state }) => state == "failed" && rest());
  context.onEnd(forget);
  return { element };
}

function makeResultTable(rows) {
  const isTrueKnown = rows.some(([, truth]) => truth != null);
  const columns = ["name", "true", "batch", "error", "online", "deviation"];
  const shown = columns.filter((name) => isTrueKnown || !["true", "deviation"].includes(name));
  const heading = (name) => {
    const words = { textContent: text(`result.${name}`), title: text(`result.${name}.title`) };
    return make("th", { scope: "col", ...words });
  };
  const head = make("thead", make("tr", ...shown.map(heading)));
  const largest = Math.max(...rows.map(([, truth]) => Math.abs(truth ?? 0)));
  const body = make("tbody", ...rows.map((row) => makeResultRow(row, isTrueKnown, largest)));
  const table = make("table.robsim-table", head, body);
  table.classList.toggle("robsim-compared", isTrueKnown);
  return make("div.robsim-result-table.robsim-surface.robsim-cut", table);
}

function makeResultRow([name, truth, batch, error, online], isTrueKnown, largest) {
  const cell = (value) =>
    make("td.robsim-number", { textContent: shortNumber(value) });
  const row = make("tr", make("th.robsim-code", { scope: "row", textContent: name }));
  if (isTrueKnown) row.append(cell(truth));
  row.append(...[batch, error, online].map(cell));
  const isExact = Math.max(error ?? 0, Math.abs(batch - truth)) < ROUNDING * largest;
  const words = { textContent: text("result.exact"), title: text("result.exact.title") };
  const exact = make("span.robsim-quiet", { ...words });
  const deviation = isExact ? exact : makeDeviation(truth, batch, error, online);
  if (isTrueKnown) row.append(make("td", deviation));
  return row;
}

/**
 * How many standard errors from the truth: a bar for the batch estimate, a mark for the online one.
 */
function makeDeviation(truth, batch, error, online) {
  const scale = make("div.robsim-deviation", { role: "img" });
  if (truth == null || batch == null || !(error > 0)) return scale;
  const errorsOff = (value) => (value == null ? null : (value - truth) / error);
  const at = (off) => 50 + (50 * Math.max(-MOST_ERRORS, Math.min(MOST_ERRORS, off))) / MOST_ERRORS;
  const [far, mark] = [batch, online].map(errorsOff);
  const level = Math.abs(far) <= 2 ? "good" : Math.abs(far) <= 3 ? "warning" : "bad";
  const bar = make(`span.robsim-deviation-bar.robsim-${level}`);
  bar.style.left = `${Math.min(50, at(far))}%`;
  bar.style.width = `${Math.abs(at(far) - 50)}%`;
  scale.append(bar);
  if (mark != null) {
    scale.append(make("span.robsim-deviation-mark"));
    scale.lastChild.style.left = `${at(mark)}%`;
  }
  const [batchOff, onlineOff] = [far, mark].map((off) =>
    (off == null ? NO_NUMBER : minus(off.toFixed(1))));
  scale.title = scale.ariaLabel = text("result.far", { batch: batchOff, online: onlineOff });
  return scale;
}
