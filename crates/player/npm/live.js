import { RhytidError } from "./errors.js";

/** Seconds before a connection that has ended is tried again: the first time, and at most. */
const FIRST_PAUSE = 0.5;
const LONGEST_PAUSE = 8;

/** A live stream over a WebSocket: each binary message is a datagram as docs/live.md describes it. */
export class Live {
    #stream;
    #memory;
    #values;
    #url;
    #reconnect;
    #socket = null;
    #timer = null;
    #pause = FIRST_PAUSE;
    #isNew = false;
    #warnings = [];
    /** "connecting", "open", "waiting" for the next try, or "closed". */
    state = "connecting";

    constructor(stream, memory, values, url, { reconnect = true } = {}) {
        this.#stream = stream;
        this.#memory = memory;
        this.#values = values;
        this.#url = url;
        this.#reconnect = reconnect;
        this.#connect();
    }

    #connect() {
        this.state = "connecting";
        let socket;
        try {
            socket = new WebSocket(this.#url);
        } catch (cause) {
            this.close();
            throw new RhytidError(`${this.#url}: ${cause.message}; give an address such as ws://127.0.0.1:9001`, "Network", { cause });
        }
        socket.binaryType = "arraybuffer";
        socket.onopen = () => {
            this.state = "open";
            this.#pause = FIRST_PAUSE;
        };
        socket.onmessage = ({ data }) => {
            if (typeof data === "string") {
                this.#warn(`${this.#url} sends text, expected binary messages, each an OSC bundle or message`);
            } else if (this.#stream.accept(new Uint8Array(data), performance.now() / 1000)) {
                this.#isNew = true;
            }
        };
        socket.onclose = ({ code }) => {
            if (this.#socket !== socket) return;
            this.#socket = null;
            const ended = `${this.#url}: the connection ended (code ${code})`;
            if (!this.#reconnect) {
                this.#warn(`${ended}; follow it again, or look at the sender`);
                this.state = "closed";
                return;
            }
            this.#warn(`${ended}; it is tried again until it comes back`);
            this.state = "waiting";
            this.#timer = setTimeout(() => this.#connect(), 1000 * this.#pause);
            this.#pause = Math.min(2 * this.#pause, LONGEST_PAUSE);
        };
        this.#socket = socket;
    }

    /** Keeps a sentence, and prints it the first time. */
    #warn(sentence) {
        if (this.#warnings.includes(sentence)) return;
        this.#warnings.push(sentence);
        console.warn(`rhytid: ${sentence}`);
    }

    /** The handle positions of the newest frame, if it came after the last call; else null. */
    newest() {
        if (this.#stream === null) return null;
        if (this.#stream.close(performance.now() / 1000)) this.#isNew = true;
        if (!this.#isNew) return null;
        this.#isNew = false;
        return new Float32Array(this.#memory.buffer, this.#stream.positions(), this.#values);
    }

    #last = { counts: { frames: 0, late: 0, lost: 0, bad: 0, other: 0 }, frame: null, warnings: [] };

    #facts() {
        if (this.#stream !== null) this.#last = JSON.parse(this.#stream.facts());
        return this.#last;
    }

    /** How many frames came, and what else did. */
    get counts() {
        return this.#facts().counts;
    }

    /** The newest frame: its number, time, latency, and the confidence of each handle. */
    get frame() {
        return this.#facts().frame;
    }

    /** What is likely wrong with the sender, a sentence each. */
    get warnings() {
        return [...this.#warnings, ...this.#facts().warnings];
    }

    /** Ends the connection. The face stays as it is. */
    close() {
        this.#facts();
        clearTimeout(this.#timer);
        const socket = this.#socket;
        this.#socket = null;
        socket?.close();
        this.#stream?.free();
        this.#stream = null;
        this.state = "closed";
    }
}
