// @ts-check
// The host without a notebook: a model over a WebSocket, which is opened anew when it breaks.
import view from "./view.js";

const PAUSES = [0.3, 1, 2, 4, 8]; // s before each try

const decoder = new TextDecoder();

function unpack(data) {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(decoder.decode(new Uint8Array(data, 4, length)));
  let at = 4 + length;
  const buffers = head.buffers.map((size) => {
    const buffer = new Uint8Array(data, at, size);
    at += size + ((4 - (size % 4)) % 4);
    return buffer;
  });
  return [head, buffers];
}

/** Pack a message as Python does, see PROTOCOL.md. */
function pack(message, buffers) {
  const lengths = buffers.map(({ byteLength }) => byteLength);
  const head = new TextEncoder().encode(JSON.stringify({ ...message, buffers: lengths }));
  const room = (length) => length + ((4 - (length % 4)) % 4);
  const start = 4 + room(head.length);
  const packed = new Uint8Array(lengths.reduce((sum, length) => sum + room(length), start));
  packed.fill(0x20, 4, start);
  new DataView(packed.buffer).setUint32(0, start - 4, true);
  packed.set(head, 4);
  let at = start;
  for (const buffer of buffers) {
    packed.set(new Uint8Array(buffer), at);
    at += room(buffer.byteLength);
  }
  return packed;
}

/** What the view needs of its host; what it says is kept until the line is open. */
function modelOf(socket) {
  const listeners = new Set();
  const waiting = [];
  const say = (data) => socket.readyState == WebSocket.OPEN && socket.send(data);
  socket.addEventListener("open", () => waiting.forEach(say));
  socket.onmessage = ({ data }) => {
    const [head, buffers] = unpack(data);
    for (const listener of listeners) listener(head, buffers);
  };
  return {
    get: (name) => ({ kind: document.body.dataset.kind })[name],
    send(message, _, buffers) {
      const data = buffers ? pack(message, buffers) : JSON.stringify(message);
      if (socket.readyState == WebSocket.CONNECTING) waiting.push(data);
      else say(data);
    },
    on: (_, listener) => listeners.add(listener),
    off: (_, listener) => listeners.delete(listener),
  };
}

function open() {
  const socket = new WebSocket(new URL("socket", location.href.replace("http", "ws")));
  socket.binaryType = "arraybuffer";
  return socket;
}

/** Show a view: the first one, or one in place of that whose line was lost. */
function show(socket) {
  const el = document.createElement("main");
  document.body.replaceChildren(el);
  const end = view.render({ model: modelOf(socket), el });
  socket.onclose = () => {
    end(); // what it shows remains
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

// A file that is dropped beside the view, or while that is lost, must not be opened in its place.
for (const type of ["dragover", "drop"])
  addEventListener(type, (event) => event.dataTransfer?.types.includes("Files") &&
    event.preventDefault());

show(open());
// A page out of the browser's cache has a line that is closed.
addEventListener("pageshow", ({ persisted }) => persisted && location.reload());
