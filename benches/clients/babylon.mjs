// Babylon.js with its engine that draws nothing.
import { readFileSync } from "node:fs";
import path from "node:path";
import { job, load, run, sizeOfPng, version } from "./client.mjs";

const core = await load("@babylonjs/core/index.js");
await load("@babylonjs/loaders/glTF/index.js");
core.Logger.LogLevels = core.Logger.NoneLogLevel;

// A page brings the decoder, as docs/clients.md says, or Babylon.js fetches it from its own server.
globalThis.MeshoptDecoder = (await load("three/examples/jsm/libs/meshopt_decoder.module.js")).MeshoptDecoder;
// The decoder's workers are a browser's.
MeshoptDecoder.useWorkers = () => {};
core.Tools.LoadBabylonScriptAsync = async () => {};

// Textures keep their images' bytes. Nothing decodes them without a browser.
const engine = new core.NullEngine();
const sizes = new Map();
const createTexture = engine.createTexture.bind(engine);
engine.createTexture = (url, noMipmap, invertY, scene, sampling, onLoad, onError, buffer, ...rest) => {
    const texture = createTexture(url, noMipmap, invertY, scene, sampling, onLoad, onError, buffer, ...rest);
    if (buffer) sizes.set(texture, sizeOfPng(ArrayBuffer.isView(buffer) ? buffer : new Uint8Array(buffer)));
    return texture;
};

// A .gltf with its files inside, since Node.js has no XMLHttpRequest.
function inOne(file) {
    const json = JSON.parse(readFileSync(file, "utf8"));
    for (const part of [...json.buffers, ...(json.images ?? [])].filter((part) => part.uri)) {
        const bytes = readFileSync(path.join(path.dirname(file), decodeURIComponent(part.uri)));
        part.uri = `data:application/octet-stream;base64,${bytes.toString("base64")}`;
    }
    return JSON.stringify(json);
}

async function read(file) {
    const scene = new core.Scene(engine);
    scene.useRightHandedSystem = true;
    const ending = path.extname(file);
    const source = ending === ".glb" ? new Uint8Array(readFileSync(file)) : `data:${inOne(file)}`;
    await core.AppendSceneAsync(source, scene, { pluginExtension: ending });
    const meshes = scene.meshes.filter((mesh) => mesh.getTotalVertices() > 0);
    const [positions, normals] = [[], []];
    const point = new core.Vector3();
    for (let frame = 0; frame < (scene.animationGroups.length ? job.frames : 1); frame++) {
        for (const group of scene.animationGroups) {
            group.start(false);
            group.goToFrame((frame / job.rate) * group.targetedAnimations[0].animation.framePerSecond);
            group.pause();
        }
        const now = { positions: [], normals: [] };
        for (const mesh of meshes) {
            const toWorld = mesh.computeWorldMatrix(true);
            const forNormals = core.Matrix.Transpose(core.Matrix.Invert(toWorld));
            const points = mesh.getPositionData(true, true);
            const directions = mesh.getNormalsData(true, true);
            for (let v = 0; v < points.length; v += 3) {
                core.Vector3.TransformCoordinatesFromFloatsToRef(points[v], points[v + 1], points[v + 2], toWorld, point);
                now.positions.push(point.x, point.y, point.z);
                if (!directions) continue;
                const [x, y, z] = directions.slice(v, v + 3);
                core.Vector3.TransformNormalFromFloatsToRef(x, y, z, forNormals, point);
                now.normals.push(point.x, point.y, point.z);
            }
        }
        positions.push(now.positions);
        normals.push(now.normals);
    }
    const materials = meshes.map((mesh) => mesh.material).filter(Boolean).map((material) => {
        const texture = material.albedoTexture;
        const size = sizes.get(texture?.getInternalTexture()) ?? null;
        return { name: material.name, colour: texture ? null : material.albedoColor.asArray(), texture: size };
    });
    scene.dispose();
    return { positions, normals: normals.every((one) => one.length) ? normals : null, materials };
}

await run(version("@babylonjs/core"), read);
