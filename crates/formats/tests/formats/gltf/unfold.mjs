// Undoes EXT_meshopt_compression with the decoder that three.js has: `node unfold.mjs NODE_FOLDER FILE…`.
// Writes FILE.plain.glb for each, and prints one line per file: {"file", "unfolded"}.
import { readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, ...files] = process.argv.slice(2);
const decoder = join(folder, "node_modules/three/examples/jsm/libs/meshopt_decoder.module.js");
const { MeshoptDecoder } = await import(pathToFileURL(decoder));
await MeshoptDecoder.ready;
const NAME = "EXT_meshopt_compression";

for (const file of files) {
  const [json, bin] = await read(file);
  const unfolded = `${file}.plain.glb`;
  if (json.extensionsRequired?.includes(NAME)) {
    const [stored, fallback] = json.buffers;
    if (!fallback.extensions[NAME].fallback || fallback.uri) throw new Error(`${file}: has no fallback buffer`);
    // Images are not compressed; they come behind the numbers.
    const images = json.bufferViews.filter((view) => !view.extensions);
    const lengths = images.map((view) => Math.ceil(view.byteLength / 4) * 4);
    const plain = new Uint8Array(lengths.reduce((sum, length) => sum + length, fallback.byteLength));
    images.reduce((end, view, i) => {
      plain.set(bin.subarray(view.byteOffset, view.byteOffset + view.byteLength), end);
      view.byteOffset = end;
      return end + lengths[i];
    }, fallback.byteLength);
    for (const view of json.bufferViews.filter((view) => view.extensions)) {
      const { buffer, byteOffset, byteLength, byteStride, count, mode, filter } = view.extensions[NAME];
      if (buffer !== 0 || view.buffer !== 1 || count * byteStride !== view.byteLength)
        throw new Error(`${file}: ${JSON.stringify(view)}`);
      const target = plain.subarray(view.byteOffset, view.byteOffset + view.byteLength);
      const source = bin.subarray(byteOffset, byteOffset + byteLength);
      MeshoptDecoder.decodeGltfBuffer(target, count, byteStride, source, mode, filter);
      delete view.extensions;
      view.buffer = 0;
    }
    json.buffers = [{ byteLength: plain.length }];
    for (const list of ["extensionsUsed", "extensionsRequired"]) {
      json[list] = json[list].filter((name) => name !== NAME);
      if (json[list].length === 0) delete json[list];
    }
    await writeFile(unfolded, glb(json, plain));
  } else {
    delete json.buffers[0].uri;
    await writeFile(unfolded, glb(json, bin));
  }
  console.log(JSON.stringify({ file, unfolded }));
}

// The JSON and the binary part of a .glb or .gltf file.
async function read(file) {
  const bytes = await readFile(file);
  if (bytes.toString("latin1", 0, 4) !== "glTF") {
    const json = JSON.parse(bytes);
    return [json, await readFile(join(dirname(file), decodeURIComponent(json.buffers[0].uri)))];
  }
  const length = bytes.readUInt32LE(12);
  return [JSON.parse(bytes.subarray(20, 20 + length)), bytes.subarray(28 + length)];
}

function glb(json, bin) {
  const chunk = (type, data, pad) => {
    const padded = Buffer.concat([data, Buffer.alloc(-data.length & 3, pad)]);
    const head = Buffer.alloc(8);
    head.writeUInt32LE(padded.length);
    head.write(type, 4, "latin1");
    return Buffer.concat([head, padded]);
  };
  const chunks = [chunk("JSON", Buffer.from(JSON.stringify(json)), " "), chunk("BIN\0", Buffer.from(bin), "\0")];
  const head = Buffer.alloc(12);
  head.write("glTF", "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([head, ...chunks]);
}
