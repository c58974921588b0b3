//! A host for a folder of files, to try the pages on this machine. Published pages need a real one.
use crate::Result;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The longest request that is read, in bytes.
const LONGEST_REQUEST: u64 = 16 << 10;

/// How long a browser may take to send or to receive something.
const PATIENCE: Duration = Duration::from_secs(10);

/// Serves a folder by HTTP.
pub struct Server {
    listener: TcpListener,
    folder: PathBuf,
}

impl Server {
    /// Listens at `address`. Port 0 means any free port.
    ///
    /// # Errors
    /// If the address is taken or does not belong to this machine.
    pub fn new(address: SocketAddr, folder: &Path) -> Result<Self> {
        let listener = TcpListener::bind(address)
            .map_err(|e| format!("nothing can be served at {address}: {e}; name another address"))?;
        Ok(Self { listener, folder: folder.to_owned() })
    }

    /// The address at which it listens.
    ///
    /// # Errors
    /// If the system does not tell.
    pub fn address(&self) -> Result<SocketAddr> {
        self.listener.local_addr().map_err(|e| format!("the server's address: {e}"))
    }

    /// Answers until the process ends.
    pub fn run(&self) {
        for stream in self.listener.incoming().filter_map(std::result::Result::ok) {
            let folder = self.folder.clone();
            // A browser that goes away meanwhile is no error. A connection for which there is no thread is
            // closed, and the browser tries again.
            let _ = std::thread::Builder::new().spawn(move || answer(stream, &folder).ok());
        }
    }
}

/// Answers one request and closes, so that a browser's idle connections block nobody.
fn answer(mut stream: TcpStream, folder: &Path) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut lines = BufReader::new((&stream).take(LONGEST_REQUEST)).lines();
    let first = lines.next().transpose()?.unwrap_or_default();
    // The other headers are read, since some systems drop an answer if input is left.
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    let (status, kind, body) = respond(&first, folder);
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    if !first.starts_with("HEAD ") {
        stream.write_all(&body)?;
    }
    stream.flush()
}

/// Status, media type and body for a request's first line.
fn respond(request: &str, folder: &Path) -> (&'static str, &'static str, Vec<u8>) {
    const TEXT: &str = "text/plain; charset=utf-8";
    let mut words = request.split(' ');
    let (method, address) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    if !matches!(method, "GET" | "HEAD") {
        return ("405 Method Not Allowed", TEXT, b"only GET and HEAD are answered\n".to_vec());
    }
    let path = address.split(['?', '#']).next().unwrap_or_default();
    let name = match path.strip_prefix('/') {
        Some("") => "index.html",
        Some(name) => name,
        None => "",
    };
    // The folder is flat: a name without a slash stays within it.
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let found = if name.starts_with('.') || !name.chars().all(is_plain) {
        None
    } else {
        fs::read(folder.join(name)).ok()
    };
    match found {
        Some(body) => ("200 OK", media_type(name), body),
        None => ("404 Not Found", TEXT, b"there is no such file here\n".to_vec()),
    }
}

/// Browsers run modules, and compile WebAssembly while it arrives, only with the right media type.
fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "wasm" => "application/wasm",
        "json" => "application/json",
        "mp4" => "video/mp4",
        "png" => "image/png",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    #[test]
    fn only_files_of_the_folder_are_served() {
        let outside = tempfile::tempdir().unwrap();
        let folder = outside.path().join("pages");
        fs::create_dir(&folder).unwrap();
        for (path, text) in [
            ("secret.txt", "no"),
            ("pages/index.html", "yes"),
            ("pages/a.wasm", "code"),
            ("pages/.hidden", "no"),
        ] {
            fs::write(outside.path().join(path), text).unwrap();
        }
        let server = Server::new((Ipv4Addr::LOCALHOST, 0).into(), &folder).unwrap();
        let address = server.address().unwrap();
        std::thread::spawn(move || server.run());
        let ask = |request: &str| {
            let mut stream = TcpStream::connect(address).unwrap();
            write!(stream, "{request}\r\nHost: here\r\n\r\n").unwrap();
            let mut text = String::new();
            stream.read_to_string(&mut text).unwrap();
            text
        };
        let index = ask("GET / HTTP/1.1");
        assert!(
            index.starts_with(
                "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: 3\r\n"
            ),
            "{index}"
        );
        assert!(index.ends_with("\r\n\r\nyes"), "{index}");
        assert!(ask("GET /a.wasm?x=1 HTTP/1.1").contains("Content-Type: application/wasm\r\n"));
        assert!(ask("HEAD / HTTP/1.1").ends_with("\r\n\r\n"));
        for path in [
            "/../secret.txt",
            "/%2e%2e/secret.txt",
            "/..",
            "/.hidden",
            "//etc/passwd",
            "/pages/index.html",
            "/nothing",
            "x",
        ] {
            assert!(ask(&format!("GET {path} HTTP/1.1")).starts_with("HTTP/1.1 404 "), "{path}");
        }
        assert!(ask("POST / HTTP/1.1").starts_with("HTTP/1.1 405 "));
        assert!(ask("").starts_with("HTTP/1.1 405 "));
        // Clients that connect and say nothing keep nobody waiting.
        let silent: Vec<TcpStream> = (0..300).map(|_| TcpStream::connect(address).unwrap()).collect();
        let start = std::time::Instant::now();
        assert!(ask("GET / HTTP/1.1").ends_with("\r\n\r\nyes"));
        assert!(start.elapsed() < PATIENCE / 2, "{:?}", start.elapsed());
        drop(silent);
        let taken = Server::new(address, &folder).err().unwrap();
        assert!(taken.contains(&address.to_string()) && taken.contains("name another address"), "{taken}");
    }
}
