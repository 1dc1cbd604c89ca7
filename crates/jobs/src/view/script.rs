//! The script of a page: modules in a single scope.

/// Modules, each after its imports. The modules in the folder `shared` are also part of the web package.
const MODULES: [&str; 14] = [
    include_str!("shared/levels.js"),
    include_str!("page/state.js"),
    include_str!("page/data.js"),
    include_str!("page/colour.js"),
    include_str!("page/camera.js"),
    include_str!("page/photographs.js"),
    include_str!("page/lights.js"),
    include_str!("shared/upload_webgl.js"),
    include_str!("page/webgl.js"),
    include_str!("shared/upload_webgpu.js"),
    include_str!("page/webgpu.js"),
    include_str!("page/drawing.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];

/// Joins all modules, without their imports, exports and comments.
pub(super) fn script() -> String {
    let lines = MODULES.iter().flat_map(|module| module.lines());
    let lines = lines.filter(|line| !line.starts_with("import ") && !is_comment(line));
    lines.map(|line| line.strip_prefix("export ").unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

/// True for a line of a comment. No line of code starts with an asterisk.
fn is_comment(line: &str) -> bool {
    ["//", "/*", "*"].iter().any(|start| line.trim_start().starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn names_are_unique_in_the_scope() {
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        let script = script();
        for line in script.lines() {
            let words: Vec<&str> = line.split([' ', '(']).collect();
            let name = match words[..] {
                ["function" | "class" | "const" | "let", name, ..] => name,
                ["async", "function", name, ..] => name,
                _ => continue,
            };
            *names.entry(name).or_default() += 1;
        }
        assert!(names.len() > 40);
        let twice: Vec<_> = names.iter().filter(|(_, count)| **count > 1).collect();
        assert!(twice.is_empty(), "{twice:?}");
        // Comments that are left out are whole.
        assert!(script.lines().all(|line| line.matches("/*").count() == line.matches("*/").count()));
        // The script must not end its element.
        assert!(!script.contains("</script") && !script.contains("import ") && script.contains("globalThis.brdfcView"));
    }
}
