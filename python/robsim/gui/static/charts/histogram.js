// The histogram of an error, lying on its side: it shares the values of the chart that it stands
// beside.
import { make, text } from "../base/dom.js";
import { cleanCanvas, clipped } from "./chart.js";
import { decimalText, numberText } from "./scale.js";

const HISTOGRAM_WIDTH = 112; // px
const LONGEST_BAR = HISTOGRAM_WIDTH - 14; // px
const TEXT_HEIGHT = 14; // px
const NUMBERS_WIDTH = 82; // px
// px of a low or a wide chart: the numbers stand beside its bars, in others above them
const LOW = 150;
const WIDE = 470;
// they are called as their inks
const SOURCE_LAYERS = { measurement: "measured", estimate: "estimated" };

export class Histogram {
  element = make("canvas.robsim-histogram", { role: "img" });
  errors = []; // {of, n, mean, std, low, high, counts}
  first = null; // the steps that are counted
  last = null;
  width = HISTOGRAM_WIDTH; // px

  shownOf({ shown }) {
    return this.errors.filter(({ of }) => shown.some(({ name }) => name == SOURCE_LAYERS[of]));
  }

  isBeside({ size: [width, height] }) {
    return height < LOW || width + this.width >= WIDE;
  }

  /** How many px of a chart the numbers need above the bars. */
  above(chart) {
    return this.isBeside(chart) ? 0 : TEXT_HEIGHT * this.shownOf(chart).length;
  }

  paint(chart, ink) {
    const { box, plot } = chart;
    const shown = this.shownOf(chart);
    const isBeside = this.isBeside(chart);
    this.width = HISTOGRAM_WIDTH + (isBeside ? NUMBERS_WIDTH : 0);
    const g = cleanCanvas(this.element, [this.width, chart.size[1]]);
    g.lineWidth = 1 / plot.ratio;
    g.strokeStyle = ink("line");
    g.strokeRect(plot.crisp(0), plot.crisp(box.top), HISTOGRAM_WIDTH - 10, box.height);
    clipped(g, { ...box, left: 0, width: HISTOGRAM_WIDTH }, () => {
      for (const error of shown) drawBars(g, plot, error, ink(SOURCE_LAYERS[error.of]));
      for (const error of shown) drawBell(g, plot, error, ink(SOURCE_LAYERS[error.of]));
    });
    if (shown.length) writeNumbers(g, { width: this.width, isBeside, errors: shown, ink });
    this.describe(chart.title, shown);
  }

  /** Announce the written text to a screen reader. */
  describe(title, shown) {
    const words = shown.map(({ of, n, mean, std }) => text("chart.histogram_of", {
      name: text(`chart.error_${SOURCE_LAYERS[of]}`),
      n, mean: momentText(mean, std), std: momentText(std, std),
    }));
    const { first, last, element } = this;
    const steps = shown.length ? text("chart.count.title", { n: shown[0].n, first, last }) : "";
    const label = [text("chart.histogram", { title }), ...words, steps].filter(Boolean).join(", ");
    if (element.ariaLabel != label) Object.assign(element, { ariaLabel: label, title: steps });
  }
}

/** Return a mean, or a deviation, to two digits of the deviation: there is no room for more. */
function momentText(value, std) {
  const isPlain = std >= 1e-4 && std < 100 && Math.abs(value) < 100;
  return isPlain ? decimalText(value, std) : numberText(value, std < 1e-4 ? 2 : 3);
}

/** Return the normal distribution's count in a bin at a value. */
function bellOf({ n, mean, std, low, high, counts }) {
  const peak = (n * (high - low)) / (counts.length * std * Math.sqrt(2 * Math.PI));
  return (value) => peak * Math.exp(-0.5 * ((value - mean) / std) ** 2);
}

/** Return px for a count, of bars as long as the bell is high, or longer. */
function scaleOf(error) {
  const most = Math.max(...error.counts, 1);
  if (!(error.std > 0)) return LONGEST_BAR / most;
  return LONGEST_BAR / Math.max(most, Math.min(bellOf(error)(error.mean), 2 * most));
}

function drawBars(g, plot, error, fill) {
  const { low, high, counts } = error;
  const [width, scale] = [(high - low) / counts.length, scaleOf(error)];
  g.fillStyle = fill;
  g.globalAlpha = 0.4;
  counts.forEach((count, i) => {
    const [top, bottom] = [plot.y(low + (i + 1) * width), plot.y(low + i * width)];
    const gap = bottom - top > 3 ? 1 : 0;
    g.fillRect(1, top, count * scale, Math.max(bottom - top - gap, 1 / plot.ratio));
  });
  g.globalAlpha = 1;
}

function drawBell(g, plot, error, stroke) {
  const { mean, std } = error;
  if (!(std > 0)) return;
  const [bell, scale] = [bellOf(error), scaleOf(error)];
  g.strokeStyle = stroke;
  g.lineWidth = 1.5;
  g.beginPath();
  for (let value = mean - 4 * std; value <= mean + 4 * std; value += std / 8)
    g.lineTo(1 + bell(value) * scale, plot.y(value));
  g.stroke();
}

/** Write the numbers at the right, beside the bars or above them. */
function writeNumbers(g, { width, isBeside, errors, ink }) {
  g.font = ink("chart-font");
  const whole = width - (isBeside ? HISTOGRAM_WIDTH : 0) - 12;
  const put = (word, line, fill, { align = "right", room = whole } = {}) => {
    g.textAlign = align;
    g.fillStyle = ink(fill);
    g.fillText(word, align == "left" ? 2 : width - 12, TEXT_HEIGHT * line, room); // squeezed
  };
  const first = isBeside ? 2 : 1;
  const count = text("chart.count", { n: errors[0].n });
  put(count, 1, "text", { align: isBeside ? "right" : "left" });
  const room = whole - (isBeside ? 0 : g.measureText(count).width + 8);
  put(text("chart.moments_key"), first, "quiet", { room });
  errors.forEach(({ of, mean, std }, i) =>
    put(text("chart.moments", { mean: momentText(mean, std), std: momentText(std, std) }),
      first + 1 + i, SOURCE_LAYERS[of]));
}
