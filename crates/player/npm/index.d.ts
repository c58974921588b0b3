import type { BasisStorage, Missing, Stage } from "./names.js";

export * from "./names.js";

/** Where a file is, or what it holds. What is packed by gzip is unpacked. */
export type Source = string | URL | Request | Response | Blob | ArrayBuffer | ArrayBufferView;

/** A position in mesh units and head space. */
export type Position = readonly [x: number, y: number, z: number];

/** What goes wrong, as one sentence that says what to do. */
export declare class RhytidError extends Error {
    /** The library's name of the kind of error, such as "CutShort", "RigDamaged" or "MissingMarkers". */
    readonly kind: string;
}

/** Loads the WebAssembly, once. `Face.load` does it by itself. `source` says where it is, if it is not beside `index.js`. */
export declare function init(source?: string | URL | Request | Response | BufferSource | WebAssembly.Module): Promise<unknown>;

/** What of three.js a face needs: `import * as THREE from "three/webgpu"` or from `"three"`. */
export interface ThreeModule {
    readonly Mesh: new (...parameters: never[]) => unknown;
    readonly BufferGeometry: new (...parameters: never[]) => unknown;
    readonly BufferAttribute: new (...parameters: never[]) => unknown;
    readonly MeshStandardMaterial: new (...parameters: never[]) => unknown;
    readonly Texture: new (...parameters: never[]) => unknown;
}

export interface FaceOptions {
    /** What the rig is called in errors; by default the end of its address. */
    name?: string;
    /** How the basis is kept. */
    basis?: BasisStorage;
}

export interface TakeOptions {
    /** What the take is called in errors; by default the end of its address. */
    name?: string;
    /** What to do where a marker is missing from a frame. */
    missing?: Missing;
}

export interface PlayOptions {
    /** Whether the take begins again after its end. By default it does. */
    loop?: boolean;
    /** Whether the meshes move with the head, if the take has its motion. By default they do. */
    head?: boolean;
    /** 1 is the take's own speed. A negative speed plays backwards. */
    speed?: number;
    /** The time at which it begins, in seconds after the first frame. */
    at?: number;
}

export interface FollowOptions {
    /** Whether a connection that ends is tried again. By default it is. */
    reconnect?: boolean;
}

/** A handle: a marker's place on the face. */
export interface Handle {
    readonly name: string;
    /** Where it is at rest. */
    readonly rest: Position;
}

/** A clean take for a face. */
export declare class Take {
    private constructor();
    /** Reads a take's CSV for the handles of `face`. */
    static load(source: Source, face: Face, options?: TakeOptions): Promise<Take>;
    readonly frames: number;
    /** Frames per second. */
    readonly rate: number;
    /** Seconds from the first frame to the last. */
    readonly duration: number;
    /** Whether it has the head's motion. */
    readonly hasHead: boolean;
    /** What is likely wrong, a sentence each. */
    readonly warnings: readonly string[];
    /** Gives back its memory. */
    dispose(): void;
}

/** How many frames of a stream came, and what else did. */
export interface Counts {
    /** Frames that were accepted. */
    readonly frames: number;
    /** Messages of a frame that was shown already, or of an older one. */
    readonly late: number;
    /** Numbers that were skipped. */
    readonly lost: number;
    /** Messages that are damaged. */
    readonly bad: number;
    /** Messages that have nothing for the face. */
    readonly other: number;
}

/** The newest frame of a stream. */
export interface LiveFrame {
    readonly number: number;
    /** Seconds on the sender's clock. */
    readonly time: number;
    /** Seconds behind the fastest frame. */
    readonly latency: number;
    /** For each handle, 1 where its marker is seen, and down to 0 where it is not. */
    readonly confidence: readonly number[];
}

/** A live stream over a WebSocket. */
export declare class Live {
    private constructor();
    readonly state: "connecting" | "open" | "waiting" | "closed";
    readonly counts: Counts;
    /** Null before the first frame. */
    readonly frame: LiveFrame | null;
    /** What is likely wrong with the sender, a sentence each. */
    readonly warnings: readonly string[];
    /** Ends the connection. The face stays as it is. */
    close(): void;
}

/** A rig that three.js draws. */
export declare class Face {
    private constructor();
    /** Reads a rig, plain or packed. */
    static load(source: Source, options?: FaceOptions): Promise<Face>;
    readonly name: string;
    readonly vertices: number;
    /** Metres in one mesh unit. */
    readonly metresPerUnit: number;
    readonly upAxis: "y" | "z";
    readonly handles: readonly Handle[];
    /** Where the handles are now, H × 3. */
    readonly positions: Float32Array;
    /** What evaluates the frames that are drawn; null before the first. */
    readonly evaluatedOn: "webgpu" | "cpu" | null;
    /** A mesh for a scene. All meshes of a face have the same geometry, materials and pose. */
    mesh3js<T extends ThreeModule>(three: T): InstanceType<T["Mesh"]>;
    /** Puts the handles somewhere: H × 3 numbers in the order of `handles`, or positions by name. */
    pose(positions: Float32Array | readonly number[] | ReadonlyMap<string, Position> | Readonly<Record<string, Position>>): void;
    /** A stage of the frame, read from where it was evaluated: positions and normals are vertices × 3 numbers. */
    read(stage?: Stage): Promise<Float32Array>;
    /** Plays a take: each `update` shows its frame. */
    play(take: Take, options?: PlayOptions): void;
    /** Whether `update` leaves the take where it is. */
    paused: boolean;
    /** Seconds after the take's first frame; null where no take plays. */
    readonly time: number | null;
    /** Shows the take at `seconds` after its first frame. */
    seek(seconds: number): void;
    /** Follows a live stream: each `update` shows its newest frame. */
    follow(url: string | URL, options?: FollowOptions): Live;
    /** Shows the take's or the stream's frame of `now`, in seconds. Call it before each picture. */
    update(now?: number): void;
    /** Ends the take or the stream. The face stays as it is. */
    stop(): void;
    /** The bytes that the face takes on devices, and the size of WebAssembly's memory, which all faces share. */
    readonly memory: { readonly device: number; readonly wasm: number };
    /** Gives back all memory. The meshes cannot be drawn any more. */
    dispose(): void;
}
