// What both pages need: whether there is WebGPU, when its device is lost, and files from beside them.

// One sentence where WebGPU is missing; null where it is there.
export async function whyNot() {
    if (!window.isSecureContext) return "Browsers allow WebGPU only on pages that come by https or from this machine, and this page does not.";
    if (!navigator.gpu) {
        return "This browser has no WebGPU: Chrome and Edge have it from version 113 on, Safari from 26, and Firefox from 141 on Windows and 145 on Macs with Apple silicon.";
    }
    if (!(await navigator.gpu.requestAdapter())) {
        return "This browser has WebGPU but no GPU for it: its drivers may be too old, or its settings may have switched hardware acceleration off.";
    }
    return null;
}

// The name that the browser has for a GPU: its maker and architecture, or what the driver says. Empty where the browser keeps it.
export function nameOf({ description, vendor, architecture, device }) {
    return description || [vendor, architecture, device].filter((word) => word).join(" ");
}

// Tells when a device that the page makes from now on is lost. A canvas cannot say so any more. `made` gets each device and its adapter.
export function whenLost(tell, made) {
    const request = GPUAdapter.prototype.requestDevice;
    GPUAdapter.prototype.requestDevice = async function (...options) {
        const device = await request.apply(this, options);
        made?.(device, this);
        device.lost.then(tell);
        return device;
    };
}

// The bytes of a file that is kept as gzip.
export async function unpacked(address) {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`${address}: ${answer.status} ${answer.statusText}`);
    const stream = answer.body.pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}
