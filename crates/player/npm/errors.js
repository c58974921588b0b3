/** What goes wrong, as one sentence that says what to do; `kind` is for programs. */
export class RhytidError extends Error {
    constructor(sentence, kind, options) {
        super(sentence, options);
        this.name = "RhytidError";
        this.kind = kind;
    }
}

/** Calls `what`; an error of the WebAssembly becomes a RhytidError. */
export function checked(what) {
    try {
        return what();
    } catch (error) {
        // A trap is a fault of ours: the console has its words.
        const kind = error instanceof WebAssembly.RuntimeError ? "Internal" : error.name;
        throw new RhytidError(error.message, kind, { cause: error });
    }
}
