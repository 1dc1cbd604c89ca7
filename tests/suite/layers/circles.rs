//! Cycles between the files of one crate.
//!
//! A file depends on another if its code, without tests, names an item that is **defined** there. Declaring a module (`mod x;`) or
//! re-exporting a name (`pub use x::Name;`) is not a dependency: a parent that lists its children does not depend on them, and
//! code that imports a re-exported name depends on the file that defines it. So a `mod.rs` may sequence its children, or the
//! children may share its definitions, but not both. Dependencies without a name (methods of a type that are defined in another
//! file) are not detected.

use super::code::{Import, code_of, declares, imports_and_paths, module_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// One file as a module of its crate.
struct Module {
    file: String,
    code: String,
    imports: Vec<Import>,
    paths: Vec<Vec<String>>,
}

/// The files of one crate, by module.
pub struct Crate {
    modules: BTreeMap<Vec<String>, Module>,
}

/// Dependencies of a file, with the names that cause them.
pub type Graph = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

impl Crate {
    /// `files` are paths below `src/` with their texts. Modules that only tests compile are ignored.
    pub fn new(files: &[(String, String)]) -> Self {
        let mut modules = BTreeMap::new();
        for (file, text) in files {
            let code = code_of(text);
            let (imports, paths) = imports_and_paths(&code);
            modules.insert(module_of(Path::new(file)), Module { file: file.clone(), code, imports, paths });
        }
        let declared = |name: &Vec<String>| {
            (1..=name.len()).all(|depth| {
                let parent = modules.get(&name[..depth - 1]);
                parent.is_none_or(|parent: &Module| parent.code.contains(&format!("mod {};", name[depth - 1])))
            })
        };
        let retained: BTreeSet<Vec<String>> = modules.keys().filter(|name| declared(name)).cloned().collect();
        modules.retain(|name, _| retained.contains(name));
        Self { modules }
    }

    /// The number of files that are not tests.
    pub fn files(&self) -> usize {
        self.modules.len()
    }

    /// A path as the root of the crate sees it, if it leads into the crate.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Vec<String>> {
        let up = path.iter().take_while(|name| *name == "super").count();
        let (base, rest) = match path[0].as_str() {
            "crate" => (&[][..], &path[1..]),
            "self" => (module, &path[1..]),
            "super" => (&module[..module.len().checked_sub(up)?], &path[up..]),
            first => {
                let child = [module, &[first.to_owned()]].concat();
                (self.modules.contains_key(&child).then_some(module)?, path)
            }
        };
        Some([base, rest].concat())
    }

    /// Finds the file that defines the item of an absolute path, and the name; `None` for a module or an unknown item.
    fn definition(&self, path: &[String], depth: usize) -> Option<(Vec<String>, String)> {
        let length = (0..=path.len()).rev().find(|length| self.modules.contains_key(&path[..*length]))?;
        let (name, module) = (path[..length].to_vec(), &self.modules[&path[..length]]);
        let item = path.get(length)?;
        if item == "*" || declares(&module.code, item) || depth == 0 {
            return Some((name, item.clone()));
        }
        // Re-exported, by name or as a whole module.
        for import in module.imports.iter().filter(|import| import.name == *item || import.name == "*") {
            let Some(mut target) = self.absolute(&name, &import.path) else { continue };
            if import.name == "*" {
                target.pop();
                target.push(item.clone());
            }
            target.extend_from_slice(&path[length + 1..]);
            if let Some(found) = self.definition(&target, depth - 1)
                && self.modules.get(&found.0).is_some_and(|module| declares(&module.code, &found.1))
            {
                return Some(found);
            }
        }
        None
    }

    /// Dependencies between the files.
    pub fn graph(&self) -> Graph {
        let mut graph = Graph::new();
        for (name, module) in &self.modules {
            let mut used: Vec<Vec<String>> = Vec::new();
            let mut scope: BTreeMap<&str, Vec<String>> = BTreeMap::new();
            for import in &module.imports {
                let Some(path) = self.absolute(name, &import.path) else { continue };
                let spoken = || module.paths.iter().any(|path| path[0] == import.name);
                if !import.public || spoken() {
                    used.push(path.clone());
                }
                scope.insert(&import.name, path);
            }
            for path in &module.paths {
                // An imported name represents its path.
                match scope.get(path[0].as_str()) {
                    Some(start) => used.push([start, &path[1..]].concat()),
                    None if path.len() > 1 => used.extend(self.absolute(name, path)),
                    None => {}
                }
            }
            let arrows = graph.entry(module.file.clone()).or_default();
            for path in used {
                if let Some((target, item)) = self.definition(&path, 8)
                    && target != *name
                {
                    arrows.entry(self.modules[&target].file.clone()).or_default().insert(item);
                }
            }
        }
        graph
    }
}

/// The files from which `from` can be reached, or which it reaches, by one or more dependencies.
fn reached(graph: &Graph, from: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(file) = open.pop() {
        for next in graph.get(file).into_iter().flat_map(BTreeMap::keys) {
            if found.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    found
}

/// Every dependency of every cycle, one line each, with the names that cause it; empty if there is none.
pub fn circles(graph: &Graph) -> Vec<String> {
    let reach: BTreeMap<&String, BTreeSet<String>> = graph.keys().map(|file| (file, reached(graph, file))).collect();
    let mut lines = Vec::new();
    for (file, arrows) in graph {
        for (target, names) in arrows {
            if reach.get(target).is_some_and(|files| files.contains(file)) {
                lines.push(format!("{file} -> {target}: {}", names.iter().cloned().collect::<Vec<_>>().join(", ")));
            }
        }
    }
    lines
}
