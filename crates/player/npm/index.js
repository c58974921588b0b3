import start, { WasmFace, WasmStream, WasmTrack } from "./rhytid_player.js";
import { DeviceSession } from "./device.js";
import { geometryOf, images, materialsOf } from "./drawing.js";
import { checked, RhytidError } from "./errors.js";
import { bytesOf, nameOf } from "./files.js";
import { Live } from "./live.js";
import { DEFAULTS } from "./names.js";

export * from "./names.js";
export { Live, RhytidError };

let started;

/** Loads the WebAssembly, once. `source` is its URL, Response or bytes, where a bundler puts it elsewhere. */
export function init(source) {
    started ??= start(source && { module_or_path: source }).catch((cause) => {
        started = undefined;
        throw new RhytidError(`rhytid_player_bg.wasm cannot be loaded (${cause.message}); serve it beside index.js`, "Network", { cause });
    });
    return started;
}

/** A clean take for a face. */
export class Take {
    #track;
    #facts;

    /** Reads a take's CSV for the handles of `face`. */
    static async load(source, face, options = {}) {
        const name = nameOf(source, options.name);
        const bytes = await bytesOf(source, name);
        const take = new Take();
        take.#track = checked(() => new WasmTrack(bytes, name, face.wasm, options.missing ?? DEFAULTS.missing));
        take.#facts = JSON.parse(take.#track.facts());
        for (const warning of take.#facts.warnings) console.warn(`rhytid: ${warning}`);
        return take;
    }

    get frames() {
        return this.#facts.frames;
    }

    get rate() {
        return this.#facts.rate;
    }

    get duration() {
        return this.#facts.duration;
    }

    get hasHead() {
        return this.#facts.hasHead;
    }

    get warnings() {
        return this.#facts.warnings;
    }

    /** The address of the handle positions at a time. For the face. */
    at(seconds) {
        return this.#track.at(seconds);
    }

    /** The head's motion at a time: x, y, z, w and a translation. */
    headAt(seconds) {
        return this.#track.headAt(seconds) ?? null;
    }

    dispose() {
        this.#track.free();
    }
}

/** A rig that three.js draws. */
export class Face {
    #memory;
    #facts;
    #places = new Map();
    #handles;
    #bitmaps = [];
    /** Rises with each pose. */
    #version = 1;
    #sessions = new Map();
    #refused = new WeakSet();
    #geometry = null;
    #material = null;
    #meshes = [];
    /** Whether the renderer takes the arrays before it asks for them, as that of WebGL does. */
    #isEager = false;
    #evaluated = 0;
    #take = null;
    #live = null;

    /** Reads a rig, plain or packed, also as gzip. */
    static async load(source, options = {}) {
        const name = nameOf(source, options.name);
        const [{ memory }, bytes] = await Promise.all([init(), bytesOf(source, name)]);
        const face = new Face();
        face.wasm = checked(() => new WasmFace(bytes, name, options.basis ?? DEFAULTS.basis));
        face.#memory = memory;
        face.#facts = JSON.parse(face.wasm.facts());
        face.handles.forEach(({ name }, i) => face.#places.set(name, i));
        face.#handles = new Float32Array(face.handles.flatMap(({ rest }) => rest));
        try {
            face.#bitmaps = await images(face.wasm, face.#facts);
        } catch (cause) {
            throw new RhytidError(`${name}: a texture of the rig cannot be shown (${cause.message}); solve it with other images`, "Malformed", { cause });
        }
        return face;
    }

    get name() {
        return this.#facts.name;
    }

    get vertices() {
        return this.#facts.vertices;
    }

    get metresPerUnit() {
        return this.#facts.metresPerUnit;
    }

    get upAxis() {
        return this.#facts.upAxis;
    }

    get handles() {
        return this.#facts.handles;
    }

    /** Where the handles are now, H × 3. */
    get positions() {
        return this.#handles.slice();
    }

    /** What evaluates the frames that are drawn: "webgpu", "cpu", or null before the first. */
    evaluatedOn = null;

    /** A mesh for a scene of three.js. All meshes of a face have the same geometry and pose. */
    mesh3js(THREE) {
        if (this.#geometry === null) {
            this.#geometry = geometryOf(THREE, this.wasm, this.#facts);
            this.#material = materialsOf(THREE, this.#facts, this.#bitmaps);
            // three.js has then destroyed the buffers that were drawn.
            this.#geometry.addEventListener("dispose", () => this.#disposeSessions());
            // The build for WebGPU lets a mesh change its arrays while it is drawn. That for WebGL does not.
            this.#isEager ||= THREE.WebGPURenderer === undefined;
        }
        const mesh = new THREE.Mesh(this.#geometry, this.#material);
        mesh.name = this.name;
        mesh.onBeforeRender = (renderer) => this.#draw(renderer);
        this.#meshes.push(mesh);
        if (this.#isEager) this.#evaluate();
        return mesh;
    }

    /** Puts the handles somewhere: H × 3 numbers, or an object or Map of positions by name. */
    pose(positions) {
        const handles = isNumbers(positions) ? Float32Array.from(positions) : this.#named(positions);
        checked(() => this.wasm.check(handles));
        this.#handles = handles;
        this.#version += 1;
        if (this.#isEager) this.#evaluate();
    }

    /** The handles, some of them elsewhere. */
    #named(positions) {
        const handles = this.#handles.slice();
        for (const [name, position] of positions instanceof Map ? positions : Object.entries(positions)) {
            const place = this.#places.get(name);
            if (place === undefined) {
                throw new RhytidError(`there is no handle “${name}”, expected one of face.handles`, "UnknownMarkers");
            }
            if (position?.length !== 3) {
                throw new RhytidError(`handle “${name}” has ${position?.length ?? "no"} coordinates, expected 3`, "Mismatch");
            }
            handles.set(position, 3 * place);
        }
        return handles;
    }

    /** Evaluates the pose where the renderer draws it. */
    #draw(renderer) {
        const backend = renderer.backend;
        if (backend?.isWebGPUBackend && !this.#refused.has(backend)) {
            const session = this.#session(backend);
            if (session !== null) {
                attach(backend, this.#geometry.attributes.position, session.positions);
                attach(backend, this.#geometry.attributes.normal, session.normals);
                if (session.version !== this.#version) {
                    session.evaluate(this.#handles);
                    session.version = this.#version;
                }
                this.evaluatedOn = "webgpu";
                return;
            }
        }
        this.#isEager ||= !renderer.isWebGPURenderer;
        this.#evaluate();
        this.evaluatedOn = "cpu";
    }

    /** The face on the renderer's device. Null where the device refuses it. */
    #session(backend) {
        const known = this.#sessions.get(backend);
        if (known !== undefined) return known;
        const refuse = (why) => {
            console.warn(`rhytid: WebGPU refuses the face, so the processor evaluates it: ${why}`);
            this.#refused.add(backend);
            this.#forget(backend);
        };
        try {
            const session = new DeviceSession(backend.device, this.wasm, this.#memory);
            this.#sessions.set(backend, session);
            session.fault.then((fault) => fault && this.#sessions.get(backend) === session && refuse(fault.message));
            return session;
        } catch (error) {
            refuse(error.message);
            return null;
        }
    }

    #forget(backend) {
        const { position, normal } = this.#geometry.attributes;
        for (const attribute of [position, normal].filter((attribute) => backend.has(attribute))) {
            const usage = GPUBufferUsage.VERTEX | GPUBufferUsage.COPY_DST | GPUBufferUsage.COPY_SRC;
            attach(backend, attribute, backend.device.createBuffer({ size: attribute.array.byteLength, usage }));
        }
        this.#sessions.get(backend)?.dispose();
        this.#sessions.delete(backend);
        this.#evaluated = 0;
    }

    #disposeSessions() {
        for (const session of this.#sessions.values()) session.dispose();
        this.#sessions.clear();
    }

    /** Evaluates the pose on the processor, into the arrays that three.js sends to its device. */
    #evaluate() {
        if (this.#evaluated === this.#version || this.#geometry === null) return;
        checked(() => this.wasm.evaluate(this.#handles));
        this.#evaluated = this.#version;
        const { position, normal } = this.#geometry.attributes;
        for (const [attribute, address] of [[position, this.wasm.positions()], [normal, this.wasm.normals()]]) {
            const { buffer } = this.#memory;
            // Memory that has grown is another buffer.
            if (attribute.array.buffer !== buffer || attribute.array.byteOffset !== address) {
                attribute.array = new Float32Array(buffer, address, attribute.array.length);
            }
            attribute.needsUpdate = true;
        }
    }

    /** A stage of the frame, read from where it was evaluated. */
    async read(stage = DEFAULTS.stage) {
        const session = this.#sessions.values().next().value;
        // The processor knows which stages there are.
        if (session === undefined || !(stage in session.values)) {
            return checked(() => {
                this.wasm.evaluate(this.#handles);
                return this.wasm.read(stage);
            });
        }
        if (session.version !== this.#version) {
            session.evaluate(this.#handles);
            session.version = this.#version;
        }
        return session.read(stage);
    }

    /** Plays a take from now on: each `update` shows its frame. */
    play(take, { loop = true, head = true, speed = 1, at = 0 } = {}) {
        this.stop();
        this.#take = { take, loop, head: head && take.hasHead, speed, time: at, last: null };
        this.paused = false;
        this.seek(at);
    }

    /** Whether `update` leaves the take where it is. */
    paused = false;

    /** Seconds since the take's first frame; null where no take plays. */
    get time() {
        return this.#take?.time ?? null;
    }

    /** Shows the take at `seconds` after its first frame. */
    seek(seconds) {
        if (this.#take === null) throw new RhytidError("no take plays, so there is no time to go to; call face.play first", "Empty");
        const { take, head } = this.#take;
        this.#take.time = seconds;
        // Sampling can let the memory grow, which is then another buffer.
        const address = take.at(seconds);
        this.pose(new Float32Array(this.#memory.buffer, address, this.#handles.length));
        if (!head) return;
        const [x, y, z, w, ...translation] = take.headAt(seconds);
        for (const mesh of this.#meshes) {
            mesh.quaternion.set(x, y, z, w);
            mesh.position.set(...translation);
        }
    }

    /** Follows a live stream: each `update` shows its newest frame. */
    follow(url, options) {
        this.stop();
        const stream = new WasmStream(this.wasm);
        this.#live = new Live(stream, this.#memory, this.#handles.length, url, options);
        return this.#live;
    }

    /** Shows the take's or the stream's frame of `now`, in seconds. Call it before each picture. */
    update(now = performance.now() / 1000) {
        const positions = this.#live?.newest();
        if (positions) this.pose(positions);
        const playing = this.#take;
        if (playing === null) return;
        const { take, loop, speed, last } = playing;
        playing.last = now;
        if (this.paused || last === null) return;
        const time = playing.time + (now - last) * speed;
        // The last frame is shown as long as the others.
        const length = take.duration + 1 / take.rate;
        this.seek(loop ? ((time % length) + length) % length : Math.min(Math.max(time, 0), take.duration));
    }

    /** Ends the take or the stream. The face stays as it is. */
    stop() {
        this.#take = null;
        this.#live?.close();
        this.#live = null;
    }

    /** The bytes that the face takes on devices of WebGPU, and the size of WebAssembly's memory, of all faces. */
    get memory() {
        const device = [...this.#sessions.values()].reduce((sum, session) => sum + session.bytes, 0);
        return { device, wasm: this.#memory.buffer.byteLength };
    }

    /** Gives back all memory. The meshes cannot be drawn any more. */
    dispose() {
        this.stop();
        for (const mesh of this.#meshes) {
            mesh.removeFromParent();
            mesh.onBeforeRender = () => {};
        }
        this.#meshes = [];
        this.#geometry?.dispose();
        this.#disposeSessions();
        for (const material of [this.#material ?? []].flat()) {
            material.map?.dispose();
            material.dispose();
        }
        for (const bitmap of this.#bitmaps) bitmap.close();
        this.wasm.free();
    }
}

/** Whether these are positions in the order of the handles. */
function isNumbers(positions) {
    return ArrayBuffer.isView(positions) || Array.isArray(positions);
}

/** Lets a renderer draw an attribute from `buffer`. */
function attach(backend, attribute, buffer) {
    const data = backend.get(attribute);
    if (data.buffer === buffer) return;
    // A renderer that has compiled a scene has made a buffer before it draws.
    data.buffer?.destroy();
    data.buffer = buffer;
}
