//! Measures the time from the start of a browser to the first rendering of pages that `brdfc view` wrote, and the frame
//! rate afterwards: `cargo bench -p brdfc-benches --bench first_rendering -- PAGE.html...`

use brdfc_testing::browser::{result_of_page, with_script};
use std::process::ExitCode;

/// Pixels of the rendering.
const SIZE: [usize; 2] = [696, 700];
/// Starts of the browser for each page and API.
const STARTS: usize = 5;

/// Milliseconds until the first rendering, and renderings per second, averaged over several.
const SCRIPT: &str = "
const first = await brdfcView.first;
await fetch('/result', { method: 'POST', body: JSON.stringify([first, await brdfcView.speed(3)]) });
";

fn main() -> ExitCode {
    // Cargo adds '--bench'.
    let pages: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    if pages.is_empty() {
        // This is the case if all benchmarks are run.
        println!("skipped: first_rendering: needs a PAGE.html written by 'brdfc view'");
        return ExitCode::SUCCESS;
    }
    println!("{:<28} {:<7} {:>8} {:>8} {:>8} {:>10}", "page", "", "median", "least", "most", "renderings/s");
    for page in &pages {
        let text = match std::fs::read_to_string(page) {
            Ok(text) => text,
            Err(error) => {
                eprintln!("{page}: cannot read: {error}");
                return ExitCode::from(4);
            }
        };
        for api in ["webgl2", "webgpu"] {
            let looked_at = with_script(&text, SIZE, api, SCRIPT);
            let mut found = Vec::new();
            for _ in 0..STARTS {
                let Some(posted) = result_of_page(&[("", "text/html", looked_at.as_bytes())]) else {
                    return ExitCode::FAILURE;
                };
                found.push(serde_json::from_slice::<[f64; 2]>(&posted).expect("two numbers"));
            }
            found.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let [least, median, most] = [0, STARTS / 2, STARTS - 1].map(|k| found[k][0]);
            let speed = found.iter().map(|[_, speed]| speed).sum::<f64>() / STARTS as f64;
            println!("{page:<28} {api:<7} {median:>5.0} ms {least:>5.0} ms {most:>5.0} ms {speed:>10.1}");
        }
    }
    ExitCode::SUCCESS
}
