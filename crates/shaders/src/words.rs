//! Comments in characters that every compiler accepts.

/// Replacements of non-ASCII characters.
const PLAIN: [(char, &str); 21] = [
    ('α', "alpha"),
    ('β', "beta"),
    ('δ', "delta"),
    ('ε', "epsilon"),
    ('θ', "theta"),
    ('μ', "mu"),
    ('π', "pi"),
    ('ρ', "rho"),
    ('φ', "phi"),
    ('σ', "sigma"),
    ('Δ', "Delta"),
    ('Σ', "sum"),
    ('√', "sqrt "),
    ('²', "^2"),
    ('³', "^3"),
    ('½', "1/2"),
    ('×', "x"),
    ('·', "*"),
    ('≤', "<="),
    ('≥', ">="),
    ('°', " degrees"),
];

/// Converts to ASCII. Characters without a replacement become `?`.
pub(crate) fn ascii(text: &str) -> String {
    let plain = |letter: char| match PLAIN.iter().find(|(other, _)| *other == letter) {
        Some((_, words)) => (*words).to_owned(),
        None if letter.is_ascii() => letter.to_string(),
        None => "?".to_owned(),
    };
    text.chars().map(plain).collect()
}

/// A comment with lines of at most `width` characters, each starting with `front`.
pub(crate) fn wrapped(text: &str, front: &str, width: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("one at least");
        if !line.is_empty() && front.len() + line.len() + 1 + word.len() > width {
            lines.push(word.to_owned());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.into_iter().map(|line| format!("{front}{line}").trim_end().to_owned() + "\n").collect()
}
