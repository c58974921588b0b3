//! Rules for all pages.

use super::viewer::shows_face;
use super::*;
use std::net::TcpListener;

#[test]
fn the_page_asks_for_nothing_elsewhere_and_may_not() {
    let elsewhere = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    elsewhere.set_nonblocking(true).unwrap();
    let foreign = format!("http://{}/", elsewhere.local_addr().unwrap());
    // The policy's message about an attempt, or that it was allowed.
    let tried = |what: &str| {
        format!(
            "new Promise((resolve) => {{
                const policy = (event) => resolve(event.effectiveDirective + ' ' + event.blockedURI);
                document.addEventListener('securitypolicyviolation', policy, {{ once: true }});
                {what}
                setTimeout(() => resolve('let through'), 2000);
            }})"
        )
    };
    let fetch = tried(&format!("fetch('{foreign}').catch(() => {{}});"));
    let image = tried(&format!("new Image().src = '{foreign}';"));
    let inline =
        tried("document.head.append(Object.assign(document.createElement('script'), { textContent: '1' }));");
    let evaluate = [("fetch", fetch.as_str()), ("image", &image), ("inline", &inline)];
    for page in ["conformance.html", "index.html", "view.html"] {
        let until = if page == "index.html" { "document.querySelector('li a')" } else { ENDED };
        let visited = visited(visit(page, "", until, &evaluate));
        let here = format!("http://{}/", pages().address);
        let requests = visited["requests"].as_array().unwrap();
        assert!(requests.len() >= 2, "{visited}");
        for request in requests {
            let request = request.as_str().unwrap();
            assert!(request.starts_with(&here) || request.starts_with("data:"), "{page} asks for {request}");
        }
        assert_eq!(visited["errors"], json!([]), "{page}");
        assert_eq!(visited["found"]["fetch"], format!("connect-src {foreign}"), "{page}");
        assert_eq!(visited["found"]["image"], format!("img-src {foreign}"), "{page}");
        assert_eq!(visited["found"]["inline"], "script-src-elem inline", "{page}");
    }
    assert_eq!(elsewhere.accept().unwrap_err().kind(), std::io::ErrorKind::WouldBlock, "somebody came");
}

#[test]
fn without_webgpu_one_sentence_says_who_has_it() {
    let neither = format!("{NO_WEBGPU} {NO_WEBGL}");
    let no_adapter = "GPU.prototype.requestAdapter = async () => null;";
    let sentence = |page: &str, before: &str| {
        let evaluate = [&RESULT[..], &[("shown", "document.getElementById('status').innerText")]].concat();
        visited(visit(page, before, ENDED, &evaluate))["found"].take()
    };
    // WebGL 2 is enough to look at a face, and not to test kernels.
    let of_viewer = sentence("view.html", &neither)["message"].as_str().unwrap().to_owned();
    let of_kernels = sentence("conformance.html", NO_WEBGPU)["message"].as_str().unwrap().to_owned();
    assert!(of_viewer.starts_with(&of_kernels) && of_viewer.contains("no WebGL 2 either"), "{of_viewer}");
    for (before, words) in [
        (NO_WEBGPU, ["Chrome and Edge", "113", "Safari", "26", "Firefox", "141"]),
        (no_adapter, ["no GPU"; 6]),
    ] {
        let found = sentence("conformance.html", before);
        assert_eq!(found["state"], "unsupported", "{found}");
        assert_eq!(found["shown"], found["message"]);
        for word in words {
            assert!(found["message"].as_str().unwrap().contains(word), "{word} is missing: {found}");
        }
    }
}

#[test]
fn where_no_face_can_be_drawn_a_film_of_it_plays() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("page.png");
    let film = "document.getElementById('film')";
    let hidden = "['canvas', 'open'].map((id) => document.getElementById(id).checkVisibility())";
    let size = format!("[{film}.videoWidth, {film}.videoHeight, {film}.checkVisibility(), {film}.muted]");
    let shown = "document.getElementById('status').innerText";
    let mut visit = visit("view.html", &format!("{NO_WEBGPU} {NO_WEBGL}"), ENDED, &[]);
    // It plays to its end and begins again.
    visit["steps"] = json!([
        { "until": format!("{film}.currentTime > 0.3") },
        { "evaluate": { "shown": shown, "hidden": hidden, "size": size, "length": format!("{film}.duration") } },
        { "evaluate": { "_": format!("({film}.playbackRate = 8, 0)") } },
        { "until": format!("{film}.currentTime > 6") },
        { "until": format!("{film}.currentTime < 3") },
    ]);
    visit["picture"] = json!(picture);
    visit["width"] = json!(390);
    let visited = visited(visit);
    let found = &visited["found"];
    assert_eq!(visited["errors"], json!([]));
    assert_eq!(found["size"], json!([480, 480, true, true]));
    assert_eq!(found["hidden"], json!([false, false]));
    let take = &demo().1;
    let seconds = take.times.len() as f64 / take.rate();
    assert!((found["length"].as_f64().unwrap() - seconds).abs() < 0.05, "{} of {seconds}", found["length"]);
    assert!(found["shown"].as_str().unwrap().contains("no WebGL 2 either"), "{found}");
    assert!(shows_face(&std::fs::read(&picture).unwrap()), "the page does not show the film");
}

#[test]
fn all_of_it_without_data_is_small() {
    let files = &pages().files;
    // A browser loads one of the two programs.
    for (program, other, most) in
        [("rhytid_web", "rhytid_webgl", 8_600_000), ("rhytid_webgl", "rhytid_web", 10_600_000)]
    {
        let names = [format!("{other}.js"), format!("{other}_bg.wasm")];
        let loaded = files.iter().filter(|file| !file.is_data && !names.contains(&file.name));
        let bytes: u64 = loaded.map(|file| file.bytes).sum();
        println!("{program}: {bytes} bytes without data: {files:?}");
        assert!(bytes < most, "{program}: {files:?}");
    }
    let data: Vec<&str> = files.iter().filter(|file| file.is_data).map(|file| file.name.as_str()).collect();
    assert_eq!(data, ["demo.csv.gz", "demo.safetensors.gz", "film.mp4", "film.png"]);
    let film: u64 = files.iter().filter(|file| file.name.starts_with("film.")).map(|file| file.bytes).sum();
    assert!(film < 1_000_000, "{files:?}");
}
