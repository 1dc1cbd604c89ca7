//! Dependency files for other build systems.

use std::path::Path;

/// Writes a rule for make and ninja: `target` depends on the inputs that exist as files.
pub fn depfile(target: &Path, inputs: &[&Path]) -> Vec<u8> {
    let mut rule = escaped(target);
    rule.push(b':');
    for path in inputs.iter().filter(|path| path.exists()) {
        rule.extend(b" \\\n  ");
        rule.extend(escaped(path));
    }
    rule.push(b'\n');
    rule
}

/// Escapes a path, which need not be UTF-8.
fn escaped(path: &Path) -> Vec<u8> {
    let mut text = Vec::new();
    for byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'$' => text.push(b'$'),
            b'#' | b' ' | b':' => text.push(b'\\'),
            _ => {}
        }
        text.push(*byte);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_and_signs_are_escaped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(if cfg!(windows) { "red #1 $.brdf" } else { "a:red #1 $.brdf" });
        std::fs::write(&path, "").unwrap();
        let rule = depfile(Path::new("out:1/report.json"), &[&path, Path::new("synth:lambert")]);
        let rule = String::from_utf8(rule).unwrap();
        assert!(rule.starts_with("out\\:1/report.json: \\\n  ") && rule.ends_with("red\\ \\#1\\ $$.brdf\n"), "{rule}");
        assert!(rule.contains("/a\\:red") || cfg!(windows), "{rule}");
        assert!(!rule.contains("synth"));
    }
}
