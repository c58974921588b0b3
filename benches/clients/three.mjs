// three.js in Node.js: its loaders of glTF and USD, without drawing.
import { readFileSync } from "node:fs";
import path from "node:path";
import { job, load, run, sizeOfPng, version } from "./client.mjs";
import { materials, shown } from "./scene_of_three.mjs";

// What a browser has and Node.js lacks. Images are not drawn here, so that their size is enough.
globalThis.self = globalThis;
globalThis.createImageBitmap = async (blob) => {
    const size = sizeOfPng(new Uint8Array(await blob.arrayBuffer()));
    if (size === null) throw new Error("the image is no PNG");
    return { width: size[0], height: size[1], close() {} };
};
// The images that USD's loader waits for, with the little that it asks of them.
const loading = [];
class Image {
    #heard = {};
    addEventListener(event, listener) {
        this.#heard[event] = listener;
    }
    removeEventListener() {}
    set src(url) {
        const found = fetch(url).then((response) => response.arrayBuffer()).then((bytes) => {
            [this.width, this.height] = sizeOfPng(new Uint8Array(bytes));
            this.#heard.load.call(this);
        });
        loading.push(found.catch((error) => this.#heard.error(error)));
    }
}
globalThis.document = { createElementNS: () => new Image() };
const fetched = globalThis.fetch;
globalThis.fetch = async (request, options) => {
    const url = typeof request === "string" ? request : request.url;
    if (/^(blob|data|http):/.test(url)) return fetched(request, options);
    return new Response(readFileSync(decodeURIComponent(url.replace("file://", ""))));
};
globalThis.ProgressEvent ??= class extends Event {};
// Requests need absolute addresses.
globalThis.Request = class { constructor(url) { this.url = url; } };
const said = [];
console.warn = (...words) => said.push(words.join(" "));
console.error = console.warn;

const THREE = await load("three/build/three.module.js");
const { GLTFLoader } = await load("three/examples/jsm/loaders/GLTFLoader.js");
const { USDLoader } = await load("three/examples/jsm/loaders/USDLoader.js");
const { MeshoptDecoder } = await load("three/examples/jsm/libs/meshopt_decoder.module.js");

async function read(file) {
    said.length = 0;
    const bytes = readFileSync(file);
    const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
    let root, clips;
    if (/\.(glb|gltf)$/.test(file)) {
        const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
        const gltf = await loader.parseAsync(buffer, path.dirname(file) + "/");
        [root, clips] = [gltf.scene, gltf.animations];
    } else {
        root = new USDLoader().parse(buffer, path.dirname(file) + "/");
        await Promise.all(loading.splice(0));
        clips = root.animations ?? [];
    }
    new THREE.Scene().add(root);
    const mixer = new THREE.AnimationMixer(root);
    for (const clip of clips) {
        const action = mixer.clipAction(clip);
        // The last frame is shown at the clip's end, where a loop would begin again.
        action.setLoop(THREE.LoopOnce).clampWhenFinished = true;
        action.play();
    }
    const [positions, normals] = [[], []];
    for (let frame = 0; frame < (clips.length ? job.frames : 1); frame++) {
        mixer.setTime(frame / job.rate);
        const now = shown(root);
        positions.push(now.positions);
        normals.push(now.normals);
    }
    return { positions, normals: normals.every(Boolean) ? normals : null, materials: materials(root), said: said.join("; ") };
}

await run(version("three"), read);
