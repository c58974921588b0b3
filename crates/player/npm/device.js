/** The kernels that a device has compiled: one of each for all faces. */
const compiled = new WeakMap();

function pipelineOn(device, { name, wgsl, writes, frames }) {
    if (!compiled.has(device)) compiled.set(device, new Map());
    const pipelines = compiled.get(device);
    const key = `${name} ${frames}`;
    if (!pipelines.has(key)) {
        const binding = (type, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } });
        const storage = writes.map((isWritten, i) => binding(isWritten ? "storage" : "read-only-storage", i));
        // The layout is written out, since a kernel need not use each of its buffers.
        const layout = device.createBindGroupLayout({ label: name, entries: [...storage, binding("uniform", writes.length)] });
        const module = device.createShaderModule({ label: name, code: wgsl });
        const constants = frames === null ? {} : { FRAMES: frames };
        pipelines.set(key, {
            layout,
            pipeline: device.createComputePipeline({
                label: name,
                layout: device.createPipelineLayout({ bindGroupLayouts: [layout] }),
                compute: { module, entryPoint: name, constants },
            }),
        });
    }
    return pipelines.get(key);
}

/** A face in the memory of a WebGPU device: the buffers of its plan, and how a frame is computed there. */
export class DeviceSession {
    #device;
    #plan;
    #facts;
    #memory;
    #buffers;
    #params;
    #bindGroups;
    /** The pose that was evaluated last. */
    version = 0;
    /** The first error of making the session; null where there was none. */
    fault;

    constructor(device, face, memory) {
        this.#device = device;
        this.#memory = memory;
        const { maxStorageBufferBindingSize, maxBufferSize, maxComputeWorkgroupsPerDimension, minUniformBufferOffsetAlignment } = device.limits;
        this.#plan = face.plan(Math.min(maxStorageBufferBindingSize, maxBufferSize), maxComputeWorkgroupsPerDimension);
        this.#facts = JSON.parse(this.#plan.facts());
        const scopes = ["out-of-memory", "validation", "internal"];
        for (const scope of scopes) device.pushErrorScope(scope);
        try {
            this.#make(face, minUniformBufferOffsetAlignment);
        } finally {
            this.fault = Promise.all(scopes.map(() => device.popErrorScope())).then((faults) => faults.findLast((fault) => fault) ?? null);
        }
    }

    #make(face, alignment) {
        const { buffers, pipelines, dispatches, results } = this.#facts;
        const device = this.#device;
        const { STORAGE, COPY_DST, COPY_SRC, VERTEX, UNIFORM } = GPUBufferUsage;
        const drawn = [results.positions, results.normals];
        const usage = { constant: STORAGE | COPY_DST, input: STORAGE | COPY_DST, scratch: STORAGE, result: STORAGE | COPY_SRC };
        this.#buffers = buffers.map(({ name, bytes, use }, i) => {
            const drawing = drawn.includes(i) ? VERTEX | COPY_DST : 0;
            const buffer = device.createBuffer({ label: `rhytid ${name}`, size: Math.max(bytes, 16), usage: usage[use] | drawing });
            const contents = use === "constant" ? this.#plan.contents(face, i) : [];
            if (contents.length > 0) device.queue.writeBuffer(buffer, 0, contents);
            return buffer;
        });
        // Uniforms are bound in whole blocks.
        const bytesOf = ({ params }) => Math.ceil(params.length / 4) * 16;
        const stride = Math.ceil(Math.max(...dispatches.map(bytesOf)) / alignment) * alignment;
        const words = new Uint32Array((dispatches.length * stride) / 4);
        dispatches.forEach(({ params }, i) => words.set(params, (i * stride) / 4));
        this.#params = device.createBuffer({ label: "rhytid params", size: words.byteLength, usage: UNIFORM | COPY_DST });
        device.queue.writeBuffer(this.#params, 0, words);
        this.#bindGroups = dispatches.map((dispatch, i) => {
            const storage = dispatch.buffers.map((index, binding) => ({ binding, resource: { buffer: this.#buffers[index] } }));
            const params = { buffer: this.#params, offset: i * stride, size: bytesOf(dispatch) };
            const { layout, pipeline } = pipelineOn(device, pipelines[dispatch.pipeline]);
            const entries = [...storage, { binding: storage.length, resource: params }];
            return { dispatch, pipeline, group: device.createBindGroup({ layout, entries }) };
        });
    }

    /** The buffer of positions, (V + C) × 3 numbers. */
    get positions() {
        return this.#buffers[this.#facts.results.positions];
    }

    /** The buffer of normals, (V + C) × 3 numbers. */
    get normals() {
        return this.#buffers[this.#facts.results.normals];
    }

    /** How many numbers each stage has. */
    get values() {
        return this.#facts.values;
    }

    /** Evaluates a frame. What is submitted to the device afterwards sees its results. */
    evaluate(handles) {
        const inputs = this.#plan.inputs(handles);
        for (let i = 0; i < inputs.length; i += 3) {
            const [buffer, address, length] = inputs.subarray(i, i + 3);
            this.#device.queue.writeBuffer(this.#buffers[buffer], 0, this.#memory.buffer, address, 4 * length);
        }
        this.#run(({ onDemand }) => !onDemand);
    }

    #run(wanted) {
        const encoder = this.#device.createCommandEncoder({ label: "rhytid" });
        const pass = encoder.beginComputePass();
        for (const { dispatch, pipeline, group } of this.#bindGroups) {
            if (!wanted(dispatch)) continue;
            pass.setPipeline(pipeline);
            pass.setBindGroup(0, group);
            pass.dispatchWorkgroups(...dispatch.workgroups);
        }
        pass.end();
        this.#device.queue.submit([encoder.finish()]);
    }

    /** A stage of the last frame. */
    async read(stage) {
        this.#run((dispatch) => dispatch.onDemand && dispatch.stage === stage);
        const size = 4 * this.#facts.values[stage];
        if (size === 0) return new Float32Array();
        const staging = this.#device.createBuffer({ label: "rhytid read", size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ });
        try {
            const encoder = this.#device.createCommandEncoder();
            encoder.copyBufferToBuffer(this.#buffers[this.#facts.results[stage]], 0, staging, 0, size);
            this.#device.queue.submit([encoder.finish()]);
            await staging.mapAsync(GPUMapMode.READ);
            return new Float32Array(staging.getMappedRange().slice(0));
        } finally {
            staging.destroy();
        }
    }

    /** The bytes of all buffers. */
    get bytes() {
        return [...this.#buffers, this.#params].reduce((sum, buffer) => sum + buffer.size, 0);
    }

    dispose() {
        for (const buffer of [...(this.#buffers ?? []), ...(this.#params ? [this.#params] : [])]) buffer.destroy();
        this.#plan.free();
    }
}
