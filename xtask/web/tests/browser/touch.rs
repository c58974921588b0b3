//! The viewer under fingers, as on a telephone.

use super::viewer::{PICTURE, STATUS, distance, evaluate, handle, handles, key, opened, place, shown, until};
use super::*;

/// An event of fingers. Each is at a place that is counted from `window.at`.
fn fingers(kind: &str, places: &[[f64; 2]]) -> Value {
    let point = |(id, [x, y]): (usize, &[f64; 2])| {
        format!("{{ x: window.at[0] + {x}, y: window.at[1] + {y}, id: {id} }}")
    };
    let points: Vec<String> = places.iter().enumerate().map(point).collect();
    json!({ "method": "Input.dispatchTouchEvent", "params": { "type": kind },
        "computed": { "touchPoints": format!("[{}]", points.join(", ")) } })
}

/// Remembers where a handle is on the page, which [`fingers`] count from.
fn remember(handle: usize) -> Value {
    evaluate("at", &format!("window.at = [{}, {}]", place(handle, 0.0, 0), place(handle, 0.0, 1)))
}

/// Lets some time pass.
fn rest(milliseconds: u32) -> Value {
    evaluate("_", &format!("new Promise((done) => setTimeout(() => done(0), {milliseconds}))"))
}

/// Records the browser's own menus, and whether they were kept from opening.
const MENUS: &str = "(window.menus = [], addEventListener('contextmenu', (event) => setTimeout(() => menus.push(event.defaultPrevented)), true), 0)";

/// What the browser itself did to the page: scrolled it, zoomed it, or selected something of it.
const OF_BROWSER: &str = "[scrollX, scrollY, visualViewport.scale, String(getSelection()), document.scrollingElement.scrollHeight > innerHeight]";

/// The same where it did nothing.
fn nothing() -> Value {
    json!([0, 0, 1, "", false])
}

#[test]
fn a_telephone_and_its_finger_are_enough() {
    let handle = handle();
    // A slow telephone, on which a finger rests for a second between two pictures.
    let slow = json!({ "method": "Emulation.setCPUThrottlingRate", "params": { "rate": 20 } });
    let moved = format!(
        "((a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > 0.05)({STATUS}.handles[{handle}], window.rest)"
    );
    let steps = [
        slow,
        evaluate("before", STATUS),
        evaluate("width", "document.documentElement.scrollWidth"),
        evaluate("rest", &format!("window.rest = {STATUS}.handles[{handle}]")),
        remember(handle),
        fingers("touchStart", &[[0.0, 0.0]]),
        shown(),
        fingers("touchMove", &[[8.0, 0.0]]),
        until(&format!("{STATUS}.selected.includes({handle})")),
        fingers("touchMove", &[[15.0, 0.0]]),
        until(&moved),
        fingers("touchEnd", &[]),
        shown(),
        evaluate("after", STATUS),
    ];
    let found = opened("", &steps, json!({ "width": 390, "touch": true }));
    assert!(found["width"].as_u64().unwrap() <= 390, "{}", found["width"]);
    let [before, after] = ["before", "after"].map(|name| handles(&found[name]));
    assert!(distance(before[handle], after[handle]) > 0.05, "the marker did not follow the finger");
}

#[test]
fn a_finger_that_rests_on_a_marker_drags_it_and_the_browser_leaves_it_alone() {
    let handle = handle();
    let style = "((style) => [style.touchAction, style.userSelect])(getComputedStyle(document.getElementById('canvas')))";
    // What a browser fires at the end of a long press.
    let menu = "document.getElementById('canvas').dispatchEvent(new MouseEvent('contextmenu', { bubbles: true, cancelable: true }))";
    let mut steps = vec![
        evaluate("before", STATUS),
        evaluate("style", style),
        evaluate("menus", MENUS),
        remember(handle),
        fingers("touchStart", &[[0.0, 0.0]]),
        rest(1_500),
        evaluate("opens", menu),
    ];
    // Downwards, which would scroll the page or load it again.
    for step in 1..=6 {
        steps.extend([fingers("touchMove", &[[0.0, 5.0 * f64::from(step)]]), shown()]);
    }
    steps.extend([
        evaluate("there", &format!("[{}, {}]", place(handle, 0.0, 0), place(handle, 0.0, 1))),
        fingers("touchEnd", &[]),
        shown(),
        evaluate("after", STATUS),
        evaluate("of browser", OF_BROWSER),
        evaluate("menus", "window.menus"),
    ]);
    let found = opened("", &steps, json!({ "width": 390, "touch": true }));
    let [at, there] = ["at", "there"].map(|name| [0, 1].map(|c| found[name][c].as_f64().unwrap()));
    assert!((there[0] - at[0]).abs() < 1.0 && (there[1] - at[1] - 30.0).abs() < 1.0, "{at:?} {there:?}");
    assert_eq!(found["after"]["selected"], json!([handle]));
    assert_eq!(found["of browser"], nothing());
    assert_eq!(found["style"], json!(["none", "none"]));
    assert_eq!(found["opens"], false, "the browser's menu opens");
    assert!(found["menus"].as_array().unwrap().iter().all(|kept| kept == true), "{}", found["menus"]);
}

#[test]
fn two_fingers_zoom_and_move_no_marker() {
    let handle = handle();
    let apart = format!(
        "((a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]))(rhytid.viewer.handle({handle}), rhytid.viewer.handle(0))"
    );
    let at = |out: f64| [[-out, 0.0], [40.0 + out, 0.0]];
    let mut steps = vec![
        evaluate("before", STATUS),
        evaluate("apart", &apart),
        remember(handle),
        // The first finger lies on the marker.
        fingers("touchStart", &at(0.0)[..1]),
        shown(),
        fingers("touchStart", &at(0.0)),
        shown(),
    ];
    for step in 1..=4 {
        steps.extend([fingers("touchMove", &at(5.0 * f64::from(step))), shown()]);
    }
    steps.extend([
        fingers("touchEnd", &[]),
        shown(),
        evaluate("then", &apart),
        evaluate("after", STATUS),
        evaluate("of browser", OF_BROWSER),
    ]);
    let found = opened("", &steps, json!({ "width": 390, "touch": true }));
    let [before, after] = ["before", "after"].map(|name| handles(&found[name]));
    assert_eq!(before, after, "a marker was dragged");
    let zoomed = found["then"].as_f64().unwrap() / found["apart"].as_f64().unwrap();
    assert!((1.6..2.4).contains(&zoomed), "the fingers went from 40 to 80 pixels apart: {zoomed}");
    assert_eq!(found["of browser"], nothing());
}

#[test]
fn on_a_telephone_the_panel_leaves_the_face_a_place() {
    for [width, height] in [[400, 800], [800, 400]] {
        let size =
            format!("{PICTURE}.then((png) => Array.from(atob(png).slice(16, 24), (c) => c.charCodeAt(0)))");
        let mut steps = vec![shown(), evaluate("alone", &size)];
        steps.extend(key("t", "KeyT", 0));
        steps.extend([shown(), shown(), evaluate("other", &size)]);
        let found = opened("", &steps, json!({ "width": width, "height": height, "touch": true }));
        // Width and height in the PNG's header.
        let size = |name: &str| {
            let bytes: Vec<u32> =
                found[name].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as u32).collect();
            [0, 4].map(|from| bytes[from..from + 4].iter().fold(0, |number, byte| 256 * number + byte))
        };
        let [alone, other] = ["alone", "other"].map(size);
        // A wide window begins with the panel.
        let (with, without) = if width > height { (alone, other) } else { (other, alone) };
        if width > height {
            assert!(
                with[1] == without[1] && with[0] < without[0] && with[0] > width / 2,
                "{with:?} {without:?}"
            );
        } else {
            assert!(with[0] == without[0] && with[1] < without[1], "{with:?} {without:?}");
            assert!(without[1] - with[1] < height * 45 / 100 && with[1] > height / 3, "{with:?} {without:?}");
        }
    }
}
