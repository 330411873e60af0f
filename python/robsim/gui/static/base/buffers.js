// Binary buffers, which come as DataView, ArrayBuffer or Uint8Array.

export const asBytes = (buffer) =>
  new Uint8Array(buffer.buffer ?? buffer, buffer.byteOffset ?? 0, buffer.byteLength);

export function asFloats(buffer) {
  const bytes = asBytes(buffer);
  const aligned = bytes.byteOffset % 4 ? bytes.slice() : bytes;
  return new Float32Array(aligned.buffer, aligned.byteOffset, aligned.byteLength / 4);
}

export const asPicture = (buffer, type) =>
  createImageBitmap(new Blob([asBytes(buffer)], { type }));
