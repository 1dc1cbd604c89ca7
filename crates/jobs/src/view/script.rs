//! The script of a page: modules that stand in one scope.

/// In the order in which they use each other. Those of the folder `shared` are also part of the package for the web.
const MODULES: [&str; 12] = [
    include_str!("shared/levels.js"),
    include_str!("page/state.js"),
    include_str!("page/data.js"),
    include_str!("page/colour.js"),
    include_str!("page/camera.js"),
    include_str!("shared/upload_webgl.js"),
    include_str!("page/webgl.js"),
    include_str!("shared/upload_webgpu.js"),
    include_str!("page/webgpu.js"),
    include_str!("page/drawing.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];

/// All of them, without what they import from each other.
pub(super) fn script() -> String {
    let lines = MODULES.iter().flat_map(|module| module.lines());
    let kept = lines.filter(|line| !line.starts_with("import "));
    kept.map(|line| line.strip_prefix("export ").unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn no_name_stands_twice_in_the_scope() {
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
        // It ends where the element does that holds it.
        assert!(!script.contains("</script") && !script.contains("import ") && script.contains("globalThis.brdfcView"));
    }
}
