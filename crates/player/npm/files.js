import { RhytidError } from "./errors.js";

/** What a source is called in errors. */
export function nameOf(source, name) {
    if (name) return name;
    if (typeof source === "string" || source instanceof URL) return String(source).split(/[?#]/)[0].split("/").pop();
    return source?.name ?? "the file";
}

/** The bytes of a URL, a Response, a Blob or a buffer. What is packed by gzip is unpacked. */
export async function bytesOf(source, name) {
    const bytes = new Uint8Array(await buffer(source, name));
    if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
    try {
        const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
        return new Uint8Array(await new Response(unpacked).arrayBuffer());
    } catch (cause) {
        throw new RhytidError(`${name}: the gzip is damaged or cut short; copy the file again`, "CutShort", { cause });
    }
}

async function buffer(source, name) {
    if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) {
        // The caller keeps its buffer.
        return ArrayBuffer.isView(source) ? source.slice().buffer : source;
    }
    if (source instanceof Blob) return source.arrayBuffer();
    let response;
    try {
        response = source instanceof Response ? source : await fetch(source);
    } catch (cause) {
        throw new RhytidError(`${name}: it cannot be fetched from ${source} (${cause.message}); check the address`, "Network", { cause });
    }
    if (!response.ok) {
        const status = `${response.status} ${response.statusText}`.trim();
        throw new RhytidError(`${name}: the server answers “${status}”, expected the file; check the address`, "Network");
    }
    return response.arrayBuffer();
}
