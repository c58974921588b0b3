//! Rules for all pages.

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
    let none = "Object.defineProperty(Navigator.prototype, 'gpu', { value: undefined });";
    let no_adapter = "GPU.prototype.requestAdapter = async () => null;";
    let sentence = |page: &str, before: &str| {
        let evaluate = [&RESULT[..], &[("shown", "document.getElementById('status').innerText")]].concat();
        visited(visit(page, before, ENDED, &evaluate))["found"].take()
    };
    assert_eq!(sentence("view.html", none), sentence("conformance.html", none));
    for (before, words) in
        [(none, ["Chrome and Edge", "113", "Safari", "26", "Firefox", "141"]), (no_adapter, ["no GPU"; 6])]
    {
        let found = sentence("conformance.html", before);
        assert_eq!(found["state"], "unsupported", "{found}");
        assert_eq!(found["shown"], found["message"]);
        for word in words {
            assert!(found["message"].as_str().unwrap().contains(word), "{word} is missing: {found}");
        }
    }
}

#[test]
fn all_of_it_without_data_is_small() {
    let files = &pages().files;
    let bytes: u64 = files.iter().filter(|file| !file.is_data).map(|file| file.bytes).sum();
    println!("{bytes} bytes without data: {files:?}");
    assert!(bytes < 5_200_000, "{files:?}");
    let data: Vec<&str> = files.iter().filter(|file| file.is_data).map(|file| file.name.as_str()).collect();
    assert_eq!(data, ["demo.csv.gz", "demo.safetensors.gz"]);
}
