// The host without a notebook: a model over a WebSocket, which is opened again when it breaks.
import view from "./view.js";

const PAUSES = [0.3, 1, 2, 4, 8]; // s before each try

const fill = (length) => -length & 3; // bytes to the next multiple of 4, where a part begins

function unpack(data) {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  let at = 4 + length;
  const buffers = head.buffers.map((size) => {
    const buffer = new Uint8Array(data, at, size);
    at += size + fill(size);
    return buffer;
  });
  return [head, buffers];
}

/** Pack a message as Python does, see PROTOCOL.md. */
function pack(message, buffers) {
  const lengths = buffers.map(({ byteLength }) => byteLength);
  const json = new TextEncoder().encode(JSON.stringify({ ...message, buffers: lengths }));
  const head = [json, " ".repeat(fill(json.length))];
  const start = new DataView(new ArrayBuffer(4));
  start.setUint32(0, json.length + fill(json.length), true);
  const filled = (buffer) => [buffer, new Uint8Array(fill(buffer.byteLength))];
  return new Blob([start, ...head, ...buffers.flatMap(filled)]);
}

/** The view's interface to its host; messages wait until the connection is open. */
function modelOf(socket) {
  const listeners = new Set();
  const waiting = [];
  const say = (data) => socket.readyState == WebSocket.OPEN && socket.send(data);
  socket.addEventListener("open", () => waiting.forEach(say));
  socket.onmessage = ({ data }) => {
    const [head, buffers] = unpack(data);
    if (head.type == "moved") location.reload(); // the page shows another view now
    for (const listener of listeners) listener(head, buffers);
  };
  return {
    get: (name) => ({ kind: document.body.dataset.kind })[name],
    send(message, _, buffers) {
      const data = buffers ? pack(message, buffers) : JSON.stringify(message);
      if (socket.readyState == WebSocket.CONNECTING) waiting.push(data);
      else say(data);
    },
    on: (type, listener) => type == "msg:custom" && listeners.add(listener),
    off: (_, listener) => listeners.delete(listener),
  };
}

function open() {
  const place = `socket?kind=${document.body.dataset.kind}`;
  const socket = new WebSocket(new URL(place, location.href.replace("http", "ws")));
  socket.binaryType = "arraybuffer";
  return socket;
}

/** Show a view: the first one, or a new one after a lost connection. */
function show(socket) {
  const el = document.createElement("main");
  document.body.replaceChildren(el);
  const end = view.render({ model: modelOf(socket), el });
  socket.onclose = () => {
    end(); // the displayed content remains
    if (el.dataset.state != "closed") retry(el, PAUSES);
  };
}

function retry(el, [pause, ...later]) {
  const isOver = pause == null;
  el.dataset.state = isOver ? "gone" : "lost";
  el.inert = !isOver;
  if (isOver) return;
  setTimeout(() => {
    const socket = open();
    socket.onopen = () => show(socket);
    socket.onclose = () => retry(el, later);
  }, 1000 * pause);
}

show(open());
// A page out of the browser's cache has a line that is closed.
addEventListener("pageshow", ({ persisted }) => persisted && location.reload());
