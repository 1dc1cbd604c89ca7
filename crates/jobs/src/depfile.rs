//! Rules that tell other build systems what a build read.

use std::path::Path;

/// A rule for make and ninja: `target` depends on files that are there. Addresses are none.
pub fn depfile(target: &Path, inputs: &[&Path]) -> String {
    let inputs = inputs.iter().filter(|path| path.exists()).map(|path| format!(" \\\n  {}", escaped(path)));
    format!("{}:{}\n", escaped(target), inputs.collect::<String>())
}

fn escaped(path: &Path) -> String {
    path.display().to_string().replace('$', "$$").replace('#', "\\#").replace(' ', "\\ ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_and_signs_are_escaped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("red #1 $.brdf");
        std::fs::write(&path, "").unwrap();
        let rule = depfile(Path::new("out/report.json"), &[&path, Path::new("synth:lambert")]);
        assert!(rule.starts_with("out/report.json: \\\n  ") && rule.ends_with("/red\\ \\#1\\ $$.brdf\n"), "{rule}");
        assert!(!rule.contains("synth"));
    }
}
