// One chart over the steps: a canvas for what changes with the rows, and one over it for the
// cursor.
import { make, text } from "../base/dom.js";
import { drawFrame, drawReadings } from "./frame.js";
import { paintBand, paintBeyond, paintCrosses, paintDots, paintLine, Plot } from "./plot.js";
import { autoRange } from "./scale.js";

const CHART_MARGIN = { left: 44, right: 9, top: 22, bottom: 8 };
const NARROW = 150; // px of a chart that reads off below its title
const LINE_BELOW = 13; // px
const STEPS_HEIGHT = 22; // px, below a chart that names the steps

/**
 * A layer: `name` (of a text), `series`, `ink` (a custom property without "--robsim-", or "#..."),
 * `kind` "line", "stairs" or "dots", `size` (px) of its dots or line. Its `level` is 0
 * if it is drawn first. `isJoined`: a thin line joins its dots. `isAside`: the title does not read it off.
 * `spread` is a series of its standard deviation, or what becomes that by the factor that `sigma()`
 * returns. Twice it is a band in `bandInk`.
 */
export class Chart {
  /**
   * @param {object} options
   * @param {string} options.title
   * @param {string} [options.unit]
   * @param {object[]} options.layers
   * @param {object[]} [options.reads] further layers, only for reading.
   * @param {number} [options.least] smallest range of values
   * @param {boolean} [options.isAngle] whether the values are degrees.
   * @param {boolean} [options.isRobust] whether a few wild values are cut.
   * @param {boolean} [options.hasZero] whether 0 is marked.
   * @param {boolean} [options.readsNewest] whether the newest step is read off, without a cursor.
   * @param {number} [options.reserved] px on the right of the title.
   * @param {(chart: Chart) => boolean} [options.namesSteps] whether the steps are written below
   * @param {{paint: (chart: Chart, ink: Function) => void, element: Element}} [options.beside]
   */
  constructor(options) {
    this.unit = "";
    this.remark = ""; // a warning beside the title
    this.reads = [];
    this.least = 1e-9;
    this.truth = null; // a value to be marked by crosses
    this.namesSteps = () => true;
    this.beside = null;
    this.range = null; // of values, if the user has chosen one
    this.size = [0, 0]; // px
    this.bare = ""; // the size for which nothing is drawn over it
    this.isSeen = false;
    this.reserved = 0;
    Object.assign(this, options);
    this.base = make("canvas");
    this.over = make("canvas", { tabIndex: 0, role: "slider" });
    this.over.setAttribute("aria-label",
      text("chart.label", { title: this.title, unit: this.unit }));
    this.main = make("div.robsim-chart-main", this.base, this.over);
    this.element = make("div.robsim-chart.robsim-surface", this.main);
    if (this.beside) this.element.append(this.beside.element);
  }

  get isNarrow() {
    return this.size[0] < NARROW;
  }

  get box() {
    const { left, right, bottom } = CHART_MARGIN;
    const [width, height] = this.size;
    const above = Math.max(this.isNarrow ? LINE_BELOW : 0, this.beside?.above(this) ?? 0);
    const top = CHART_MARGIN.top + above;
    const below = this.namesSteps(this) ? STEPS_HEIGHT : bottom;
    return { left, top, width: Math.max(width - left - right, 1),
      height: Math.max(height - top - below, 1) };
  }

  paint({ axis, ink, local }) {
    for (const { series, spread } of [...this.layers, ...this.reads]) {
      series.update();
      spread?.update();
    }
    this.shown = this.layers.filter(({ name }) => !local.unseen.includes(name));
    const range = this.range ?? autoRange(this.shown, axis, this);
    const g = cleanCanvas(this.base, this.size);
    this.plot = new Plot(g, this.box, axis, range ?? [-1, 1], devicePixelRatio);
    drawFrame(this.plot, this, ink, Boolean(range));
    clipped(g, this.box, () => this.paintLayers(ink));
    this.beside?.paint(this, ink);
  }

  paintLayers(ink) {
    const { plot, shown } = this;
    for (const { series, spread, sigma, bandInk } of shown)
      if (spread) paintBand(plot, series, spread, sigma?.() ?? 1, ink(bandInk));
    if (this.truth !== null) paintCrosses(plot, this.truth, ink("true"));
    for (const { series, kind, size, isJoined, ink: name } of [...shown].sort(byLevel)) {
      if (kind == "dots") paintDots(plot, series, ink(name), { size, isJoined });
      else paintLine(plot, series, ink(name), { isStairs: kind == "stairs", width: size });
    }
    if (!this.isRobust && !this.range) return;
    for (const { series, ink: name } of shown) paintBeyond(plot, series, ink(name));
  }

  /** Draw the cursor and the step that is looked at. */
  paintOver({ axis, ink, marked }) {
    if (!this.plot) return;
    const k = axis.cursor ?? marked ?? (this.readsNewest ? axis.count - 1 : null);
    const bare = k === null ? String(this.size) : "";
    if (bare && bare == this.bare) return;
    this.bare = bare;
    if (bare) return emptyCanvas(this.over, this.size);
    const g = cleanCanvas(this.over, this.size);
    if (marked !== null) this.drawLooked(g, marked, ink, axis.follows);
    if (axis.cursor !== null) this.drawCursor(g, axis.cursor, ink);
    if (k !== null) drawReadings(g, this, this.shown, k, ink);
  }

  drawLooked(g, k, ink, isLast) {
    const { top, left, width } = this.box;
    // while a trace is played back, a chart that waits for its turn has an older plot
    const x = isLast ? Math.min(this.plot.x(k), left + width) : this.plot.x(k);
    if (!this.drawUpright(g, x, ink("accent"), 1.5)) return;
    g.beginPath();
    g.moveTo(x - 5, top);
    g.lineTo(x + 5, top);
    g.lineTo(x, top + 7);
    g.fill();
  }

  drawCursor(g, k, ink) {
    const { plot } = this;
    const x = plot.x(k);
    if (!this.drawUpright(g, plot.crisp(x), ink("quiet"), 1)) return;
    g.strokeStyle = ink("raised");
    g.lineWidth = 1.5;
    for (const { series, ink: name } of this.shown)
      this.drawPoint(g, x, plot.y(series.value(k)), ink(name));
  }

  /** Draw a line from the top to the bottom; return whether its place is seen. */
  drawUpright(g, x, color, width) {
    const { left, top, width: wide, height } = this.box;
    if (x < left || x > left + wide) return false;
    g.strokeStyle = g.fillStyle = color;
    g.lineWidth = width;
    g.stroke(new Path2D(`M${x} ${top}v${height}`));
    return true;
  }

  drawPoint(g, x, y, fill) {
    const { box } = this;
    if (!(y >= box.top && y <= box.top + box.height)) return;
    g.fillStyle = fill;
    g.beginPath();
    g.arc(x, y, 4, 0, 2 * Math.PI);
    g.fill();
    g.stroke();
  }
}

const byLevel = ({ level: one = 0 }, { level: other = 0 }) => one - other;

/** Draw within a box alone. */
export function clipped(g, { left, top, width, height }, draw) {
  g.save();
  g.beginPath();
  g.rect(left, top, width, height);
  g.clip();
  draw();
  g.restore();
}

/** Hide a canvas without moving it: it gets no pixels, so that the canvas below stays unmixed. */
function emptyCanvas(canvas, [width, height]) {
  canvas.width = canvas.height = 0;
  Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
}

/** Make a canvas empty, and as fine as the screen; return what draws on it. */
export function cleanCanvas(canvas, size) {
  const ratio = devicePixelRatio;
  // whole ones: else it is blurred
  const [width, height] = size.map((length) => Math.round(length * ratio));
  if (canvas.width != width || canvas.height != height) {
    Object.assign(canvas, { width, height });
    Object.assign(canvas.style, { width: `${width / ratio}px`, height: `${height / ratio}px` });
  }
  const g = canvas.getContext("2d");
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, ...size);
  return g;
}
