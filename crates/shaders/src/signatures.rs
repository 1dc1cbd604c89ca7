//! Declarations of an interface's functions in a translated text.

use crate::interface::Interface;

/// The signatures of an interface's functions in a translated text.
///
/// # Panics
/// Panics if the text lacks a function.
pub(crate) fn signatures(text: &str, interface: &Interface) -> Vec<String> {
    interface.functions.iter().map(|function| signature(text, &function.name, function.parameters())).collect()
}

/// Text from the line of the name to the brace, with the parameter names of the WGSL, since the writers number them.
fn signature<'a>(text: &str, name: &str, parameters: impl Iterator<Item = [&'a str; 2]>) -> String {
    let call = format!(" {name}(");
    let is_it = |line: &&str| line.contains(&call) && !line.starts_with([' ', '\t', '}', '/']);
    let line = text.lines().find(is_it).unwrap_or_else(|| panic!("no function {name} in a translated text"));
    let from = text.find(line).unwrap_or(0);
    let whole = text[from..].split('{').next().unwrap_or(line).split_whitespace().collect::<Vec<_>>().join(" ");
    let (result, rest) = whole.split_once('(').unwrap_or((&whole, ""));
    let mut written: Vec<String> =
        rest.trim_end().trim_end_matches(')').split(',').map(|parameter| parameter.trim().to_owned()).collect();
    for (parameter, [own, _]) in written.iter_mut().zip(parameters) {
        if let Some((ty, _)) = parameter.rsplit_once(' ') {
            *parameter = format!("{ty} {own}");
        }
    }
    format!("{result}({})", written.join(", "))
}
