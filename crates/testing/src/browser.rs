//! Pages in a headless browser: Chromium, whose software driver has WebGL 2 and WebGPU.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Names of the program.
const PROGRAMS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// Without a graphics card, and as root.
const OPTIONS: [&str; 12] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu-sandbox",
    "--disable-extensions",
    "--disable-background-networking",
    "--no-first-run",
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
    // Without it, canvases of WebGPU are not presented, and the graphics process crashes.
    "--use-vulkan=swiftshader",
    "--enable-features=Vulkan",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
];
/// Time limit for a page to post its result.
const PATIENCE: Duration = Duration::from_secs(120);

/// Posts the canvas after some frames, or an error. The first frame may come before a page has loaded everything, or
/// before it has uploaded lost resources again; the third does not.
const LOOK: &str = "
const FRAMES = 3;
const say = (body) => parent.postMessage(body, '*');
addEventListener('error', ({ message }) => say(`error: ${message}`));
addEventListener('unhandledrejection', ({ reason }) => say(`error: ${reason?.stack ?? reason}`));
let device;
if (globalThis.GPUAdapter) {
    const { requestDevice } = GPUAdapter.prototype;
    GPUAdapter.prototype.requestDevice = async function (...words) {
        device = await requestDevice.apply(this, words);
        device.addEventListener('uncapturederror', ({ error }) => say(`error: ${error.message}`));
        return device;
    };
}
// Pages draw once they have loaded everything, and a canvas retains its contents until the end of the frame's
// callbacks.
const frame = requestAnimationFrame.bind(window);
let frames = 0;
window.requestAnimationFrame = (draw) => frame((time) => {
    draw(time);
    frames += 1;
    if (frames === FRAMES) {
        const url = document.querySelector('canvas').toDataURL('image/png');
        // Errors of the device come before that.
        Promise.resolve(device?.queue.onSubmittedWorkDone()).then(() => fetch(url)).then((answer) => answer.blob()).then(say);
    }
});
";

/// A file of a page: its path after `/`, its media type, its bytes.
pub type File<'a> = (&'a str, &'a str, &'a [u8]);

/// Maximum number of attempts to open a page. On a busy machine it may post nothing, or its browser may lose the
/// graphics process.
const ATTEMPTS: usize = 3;
/// Result of a page whose browser lost the graphics process.
const LOST: &[u8] = b"error: OperationError: A valid external Instance reference no longer exists";

/// Opens `/` of these files and waits for the page to POST to `/result`. Returns `None` and prints a message if there
/// is no browser.
///
/// # Panics
/// If the page posts nothing for two minutes, three times.
pub fn result_of_page(files: &[File<'_>]) -> Option<Vec<u8>> {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port of this machine");
    listener.set_nonblocking(true).expect("a socket that does not block");
    let address = format!("http://{}/", listener.local_addr().expect("it is bound"));
    for _ in 0..ATTEMPTS {
        let profile = tempfile::tempdir().expect("a temporary folder");
        let mut browser = browser(&address, profile.path())?;
        let posted = posted(&listener, files);
        let _ = browser.kill();
        let _ = browser.wait();
        match posted {
            Some(posted) if !posted.starts_with(LOST) => return Some(posted),
            _ => println!("opening a page again"),
        }
    }
    panic!("the page said nothing for {} s, {ATTEMPTS} times", PATIENCE.as_secs());
}

/// Starts the browser; returns `None` if there is none.
fn browser(address: &str, profile: &Path) -> Option<Child> {
    let program = std::env::var("BRDFC_CHROMIUM");
    let programs = program.iter().map(String::as_str).chain(PROGRAMS);
    let mut started = programs.filter_map(|program| {
        let mut command = Command::new(program);
        command.args(OPTIONS).arg(format!("--user-data-dir={}", profile.display())).arg(address);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()
    });
    let started = started.next();
    if started.is_none() {
        println!("skipped: pages need a browser; found no {}", PROGRAMS.join(", no "));
    }
    started
}

/// Answers requests until a result is posted or the time limit is over.
fn posted(listener: &TcpListener, files: &[File<'_>]) -> Option<Vec<u8>> {
    let end = Instant::now() + PATIENCE;
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        while Instant::now() < end {
            // Browsers open connections ahead of their requests, which must not block others.
            if let Ok((stream, _)) = listener.accept() {
                let sender = sender.clone();
                scope.spawn(move || {
                    if let Ok(Some(posted)) = answer(stream, files) {
                        let _ = sender.send(posted);
                    }
                });
            }
            if let Ok(posted) = receiver.recv_timeout(Duration::from_millis(5)) {
                return Some(posted);
            }
        }
        None
    })
}

/// A page of `brdfc view` in a browser: a rendering of this size, by one API (`webgl2`, `webgpu`), and a script after
/// its own.
pub fn with_script(page: &str, [width, height]: [usize; 2], api: &str, script: &str) -> String {
    let size = format!("<style>#stage {{ width: {width}px; height: {height}px }}</style>");
    let hash = format!("<script>history.replaceState(null, '', '#api={api}&embed')</script>");
    let page = page.replacen("</head>", &format!("{size}{hash}</head>"), 1);
    page.replacen("</body>", &format!("<script type=\"module\">{script}</script></body>"), 1)
}

/// Opens pages of a list one after another, which costs less than a browser for each: `ADDRESSES`, `WIDTH`, `HEIGHT`.
const IN_TURN: &str = "<!doctype html><body><script type='module'>
const renderings = [];
for (const src of ADDRESSES) {
    const frame = Object.assign(document.createElement('iframe'), { src, width: WIDTH, height: HEIGHT });
    frame.style.border = 0;
    const said = new Promise((done) => {
        addEventListener('message', ({ source, data }) => { if (source === frame.contentWindow) { done(data); } });
    });
    document.body.append(frame);
    const rendering = await said;
    if (typeof rendering === 'string') {
        await fetch('/result', { method: 'POST', body: rendering });
    }
    renderings.push(new Uint32Array([rendering.size]), rendering);
    frame.remove();
}
await fetch('/result', { method: 'POST', body: new Blob(renderings) });
</script>";

/// Renderings of the only canvas of each of these pages, some frames after it was opened, as PNG. Returns `None` and
/// prints a message if there is no browser.
///
/// # Panics
/// If a page posts nothing, or an error.
pub fn renderings_of_pages(
    addresses: &[String],
    [width, height]: [u32; 2],
    files: &[File<'_>],
) -> Option<Vec<Vec<u8>>> {
    let page = IN_TURN.replace("ADDRESSES", &format!("{addresses:?}"));
    let page = page.replace("WIDTH", &width.to_string()).replace("HEIGHT", &height.to_string());
    let is_asked = |name: &str| addresses.iter().any(|address| address.split('?').next() == Some(name));
    // In the pages themselves, before their own scripts.
    let looked_at = |name: &str, bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        if is_asked(name) {
            text.replacen("<script", &format!("<script>{LOOK}</script>\n<script"), 1).into_bytes()
        } else {
            bytes.to_vec()
        }
    };
    let changed: Vec<(&str, &str, Vec<u8>)> =
        files.iter().map(|(name, media, bytes)| (*name, *media, looked_at(name, bytes))).collect();
    let mut all = vec![("", "text/html", page.as_bytes())];
    all.extend(changed.iter().map(|(name, media, bytes)| (*name, *media, bytes.as_slice())));
    let posted = result_of_page(&all)?;
    let (mut rest, mut renderings) = (posted.as_slice(), Vec::new());
    while let Some((length, more)) = rest.split_first_chunk() {
        let rendering = more.split_at_checked(u32::from_le_bytes(*length) as usize);
        let (png, more) = rendering.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&posted)));
        assert!(png.starts_with(b"\x89PNG"), "{}", String::from_utf8_lossy(&posted));
        renderings.push(png.to_vec());
        rest = more;
    }
    assert_eq!(renderings.len(), addresses.len());
    Some(renderings)
}

/// Answers one request. Returns the posted bytes if it is the result.
fn answer(mut stream: TcpStream, files: &[File<'_>]) -> std::io::Result<Option<Vec<u8>>> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(Duration::from_secs(3)))?;
    let mut reader = BufReader::new(stream.try_clone()?);
    let mut line = String::new();
    reader.read_line(&mut line)?;
    let mut words = line.split_whitespace();
    let (method, path) = (words.next().unwrap_or_default().to_owned(), words.next().unwrap_or_default().to_owned());
    let mut length = 0;
    loop {
        let mut header = String::new();
        if reader.read_line(&mut header)? <= 2 {
            break;
        }
        if let Some((name, value)) = header.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            length = value.trim().parse().unwrap_or(0);
        }
    }
    if method == "POST" {
        let mut body = vec![0; length];
        reader.read_exact(&mut body)?;
        stream.write_all(b"HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n")?;
        return Ok(Some(body));
    }
    let path = path.split('?').next().unwrap_or_default();
    match files.iter().find(|(name, ..)| path.trim_start_matches('/') == *name) {
        Some((_, media, bytes)) => {
            let head = format!(
                "HTTP/1.1 200 OK\r\nContent-Type: {media}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
                bytes.len()
            );
            stream.write_all(head.as_bytes())?;
            stream.write_all(bytes)?;
        }
        None => stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")?,
    }
    Ok(None)
}
