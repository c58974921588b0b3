// Plays every clip of files in three.js: `node clips.mjs NODE_FOLDER FILE…`.
// Prints one line per file: {"file", "clips"}, and for each clip its name, the morph weights of each frame, the
// vertices in the space of the head, and where the head is.
import { readFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, ...files] = process.argv.slice(2);
globalThis.self = globalThis;
// What browsers have.
globalThis.ProgressEvent ??= class extends Event {};
const load = (path) => import(pathToFileURL(join(folder, "node_modules/three", path)));
const THREE = await load("build/three.module.js");
const { GLTFLoader } = await load("examples/jsm/loaders/GLTFLoader.js");
const { MeshoptDecoder } = await load("examples/jsm/libs/meshopt_decoder.module.js");
await MeshoptDecoder.ready;

for (const file of files) {
  const bytes = await readFile(file);
  const isBinary = bytes.toString("latin1", 0, 4) === "glTF";
  const json = isBinary ? null : JSON.parse(bytes);
  if (json) {
    // Node has no files to fetch.
    const bin = await readFile(join(dirname(file), decodeURIComponent(json.buffers[0].uri)));
    json.buffers[0].uri = `data:application/octet-stream;base64,${bin.toString("base64")}`;
  }
  const content = json
    ? JSON.stringify(json)
    : bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  const gltf = await new Promise((resolve, reject) => loader.parse(content, "", resolve, reject));
  let mesh;
  gltf.scene.traverse((node) => (mesh ??= node.isMesh ? node : undefined));
  const { copies = [], vertices } = gltf.scene.userData;
  const [top] = gltf.scene.children;
  const head = top.name.endsWith("head") ? top : null;
  const clips = gltf.animations.map((animation) => {
    const mixer = new THREE.AnimationMixer(gltf.scene);
    mixer.clipAction(animation).play();
    const times = animation.tracks[0].times;
    const clip = { name: animation.name, weights: [], frames: [], heads: [] };
    for (const [k, time] of times.entries()) {
      // The end of a clip is its beginning.
      mixer.setTime(k + 1 === times.length ? time - 1e-7 * Math.max(time, 1) : time);
      gltf.scene.updateMatrixWorld(true);
      const local = new THREE.Matrix4().copy(head ? head.matrixWorld : gltf.scene.matrixWorld).invert();
      local.multiply(mesh.matrixWorld);
      const frame = [];
      for (let v = 0; v < vertices; v++)
        frame.push(mesh.getVertexPosition(v, new THREE.Vector3()).applyMatrix4(local).toArray());
      clip.frames.push(frame);
      clip.weights.push([...mesh.morphTargetInfluences]);
      clip.heads.push(head ? head.position.toArray() : [0, 0, 0]);
    }
    mixer.stopAllAction();
    return clip;
  });
  console.log(JSON.stringify({ file, copies: copies.length, clips }));
}
