//! What must not happen: memory that grows, and a page that dies of a bad file.
use super::*;

/// Counts the buffers that devices of the page have.
const COUNTED: &str = "
    window.buffers = { count: 0, bytes: 0 };
    if (window.GPUDevice) {
        const { createBuffer } = GPUDevice.prototype;
        const { destroy } = GPUBuffer.prototype;
        const alive = new WeakSet();
        GPUDevice.prototype.createBuffer = function (descriptor) {
            const buffer = createBuffer.call(this, descriptor);
            alive.add(buffer);
            window.buffers.count += 1;
            window.buffers.bytes += buffer.size;
            return buffer;
        };
        GPUBuffer.prototype.destroy = function () {
            if (alive.delete(this)) {
                window.buffers.count -= 1;
                window.buffers.bytes -= this.size;
            }
            destroy.call(this);
        };
    }";

/// Plays a take for a number of poses, of which every `drawn`th is drawn. Memory is measured after `warm`
/// poses and at the end.
fn played(page: &str, poses: usize, warm: usize, drawn: usize) -> Value {
    let body = format!(
        "const {{ face, renderer, draw, close }} = await open('small.safetensors');
        renderer.setSize(64, 64);
        face.play(await player.Take.load('small.csv', face));
        const measured = () => ({{ ...window.buffers, wasm: face.memory.wasm, heap: performance.memory.usedJSHeapSize }});
        const found = {{ }};
        const start = performance.now();
        for (let i = 0; i < {poses}; i += 1) {{
            face.update(i / 25);
            if (i % {drawn} === 0) draw();
            if (i === {warm}) found.early = measured();
            // The device finishes what it was given, and garbage can go.
            if (i % 50 === 0) await new Promise((done) => setTimeout(done, 0));
        }}
        found.milliseconds = (performance.now() - start) / {poses};
        found.late = measured();
        found.on = face.evaluatedOn;
        found.device = face.memory.device;
        close();
        found.closed = measured();
        return found;"
    );
    ran(page, &body, json!({ "before": COUNTED }))
}

fn does_not_grow(found: &Value, what: &str) {
    println!("{what}: {found}");
    for name in ["count", "bytes", "wasm"] {
        assert_eq!(found["early"][name], found["late"][name], "{what}: {name}");
    }
    let heap = |when: &str| found[when]["heap"].as_f64().unwrap() / 1e6;
    let [early, late] = [heap("early"), heap("late")];
    assert!(late < early + 30.0, "{what}: the heap grows from {early} to {late} MB");
}

/// 90,000 poses are an hour at 25 frames a second. WebGPU on a processor is slow, so fewer frames are drawn
/// there: each of them does the same.
#[test]
fn memory_does_not_grow_over_an_hour_of_frames() {
    let found = played("gl.html", 90_000, 1_000, 1_000);
    assert_eq!(found["on"], "cpu");
    does_not_grow(&found, "processor");
    let found = played("gpu.html", 3_000, 500, 1);
    assert_eq!(found["on"], "webgpu");
    does_not_grow(&found, "WebGPU");
    let device = found["device"].as_u64().unwrap();
    let [late, closed] = ["late", "closed"].map(|when| found[when]["bytes"].as_u64().unwrap());
    assert!(closed + device <= late, "{device} bytes of the face are given back: {late}, then {closed}");
}

#[test]
fn a_bad_file_is_a_sentence_and_the_page_lives_on() {
    let (found, said) = heard(
        "gpu.html",
        "const face = await player.Face.load('learned.safetensors');
        const found = {};
        for (const name of ['cut.safetensors', 'spoiled.safetensors', 'cut.gz', 'take.csv']) {
            found[name] = await refused(() => player.Face.load(name));
        }
        for (const name of ['cut.csv', 'no-time.csv', 'learned.safetensors']) {
            found['take ' + name] = await refused(() => player.Take.load(name, face));
        }
        const missing = () => new Response('', { status: 404, statusText: 'Not Found' });
        found.missing = await refused(() => player.Face.load(missing(), { name: 'nowhere' }));
        found.deaf = await refused(() => player.Take.load('http://127.0.0.1:9/deaf.csv?x', face));
        found.empty = await refused(() => player.Face.load(new ArrayBuffer(0)));
        found.named = await refused(() => player.Face.load(new Blob(['x']), { name: 'my rig' }));
        found.basis = await refused(() => player.Face.load('learned.safetensors', { basis: 'f64' }));
        const bytes = new Uint8Array(await (await fetch('learned.safetensors')).arrayBuffer());
        // Each change of a byte is refused, or is another sound rig.
        found.changed = 0;
        for (let i = 0; i < 300; i += 1) {
            const spoiled = bytes.slice();
            spoiled[(i * 7919) % (i % 3 === 0 ? 4096 : spoiled.length)] ^= 1 << i % 8;
            const error = await refused(async () => (await player.Face.load(spoiled)).dispose());
            if (error === null || (error.isOurs && error.kind !== 'Internal')) found.changed += 1;
        }
        face.pose(face.positions);
        found.read = (await face.read()).length;
        return found;",
        json!({}),
    );
    for (what, kind, words) in [
        ("cut.safetensors", "CutShort", "cut.safetensors: "),
        ("spoiled.safetensors", "RigDamaged", "the file is damaged: solve the rig again"),
        ("cut.gz", "CutShort", "cut.gz: the gzip is damaged or cut short"),
        ("take.csv", "Malformed", "take.csv: "),
        ("missing", "Network", "nowhere: the server answers “404 Not Found”, expected the file"),
        ("deaf", "Network", "deaf.csv: it cannot be fetched from http://127.0.0.1:9/deaf.csv?x ("),
        ("take cut.csv", "Malformed", "the file may be cut short"),
        ("take no-time.csv", "Malformed", "the header has no column \"time\""),
        ("take learned.safetensors", "Malformed", "learned.safetensors"),
        ("empty", "CutShort", "the file: "),
        ("named", "CutShort", "my rig: "),
        (
            "basis",
            "UnknownName",
            "there is no storage of the basis “f64”, expected one of f32, f16, clustered",
        ),
    ] {
        let refused = &found[what];
        println!("{what}: {refused}");
        assert_eq!(refused["isOurs"], true, "{what}: {refused}");
        assert!(refused["sentence"].as_str().unwrap().contains(words), "{what}: {refused}");
        assert_eq!(refused["kind"], kind, "{what}: {refused}");
    }
    assert_eq!(found["changed"], 300);
    assert_eq!(found["read"], 3 * package().faces.learned.vertices());
    let panics = said.to_string();
    assert!(!panics.contains("panicked"), "{panics}");
}
