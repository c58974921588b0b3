// What the tests call in a page: a face before a camera, and the numbers that three.js draws it from.
import * as THREE from "three";
import * as player from "@rhytid/player";

const SIZE = 480;

/** What went wrong in the page, or may have. */
window.said = [];
for (const level of ["warn", "error"]) {
    const print = console[level];
    console[level] = (...words) => {
        window.said.push(words.join(" "));
        print(...words);
    };
}
addEventListener("error", ({ message }) => window.said.push(message));
addEventListener("unhandledrejection", ({ reason }) => window.said.push(String(reason)));

/** A face on a canvas of its own. `gpu` says whether three.js may use WebGPU. */
async function open(source, { gpu = true, ...options } = {}) {
    const face = await player.Face.load(source, options);
    const renderer = THREE.WebGPURenderer
        ? new THREE.WebGPURenderer({ forceWebGL: !gpu })
        : new THREE.WebGLRenderer();
    await renderer.init?.();
    renderer.setSize(SIZE, SIZE);
    document.body.append(renderer.domElement);
    const mesh = face.mesh3js(THREE);
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0x262a30);
    scene.add(mesh, new THREE.HemisphereLight(0xffffff, 0x404858, 1.5));
    const { center, radius } = mesh.geometry.boundingSphere;
    const camera = new THREE.PerspectiveCamera(30, 1, radius / 100, radius * 100);
    const light = new THREE.DirectionalLight(0xffffff, 2);
    light.position.set(0, 0.5, 1);
    camera.add(light, light.target);
    light.target.position.set(0, 0, -1);
    scene.add(camera);
    const opened = { face, renderer, mesh, scene, camera };
    opened.look = (degrees) => {
        const angle = (degrees * Math.PI) / 180;
        camera.position.set(Math.sin(angle), 0.05, Math.cos(angle)).multiplyScalar(3.4 * radius).add(center);
        camera.lookAt(center);
    };
    opened.draw = () => renderer.render(scene, camera);
    /** An attribute as it is drawn: read back from the buffer of three.js, where the device has it. */
    opened.drawn = async (name) => {
        const attribute = mesh.geometry.attributes[name];
        if (!renderer.backend?.isWebGPUBackend) return Array.from(attribute.array);
        return Array.from(new Float32Array(await renderer.getArrayBufferAsync(attribute)));
    };
    opened.close = () => {
        face.dispose();
        renderer.dispose();
        renderer.domElement.remove();
    };
    opened.look(0);
    return opened;
}

/** The kind and the sentence of the error that `what` gives. */
async function refused(what) {
    try {
        await what();
    } catch (error) {
        return { kind: error.kind, sentence: error.message, isOurs: error instanceof player.RhytidError };
    }
    return null;
}

Object.assign(window, { THREE, player, open, refused, ready: true });
