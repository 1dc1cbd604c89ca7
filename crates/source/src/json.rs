//! What is wrong with files of JSON.

use serde_json::error::Category;

/// Says what a file of JSON is that is not what it should be.
pub fn json_problem(error: &serde_json::Error) -> String {
    let place = format!("line {}, column {}", error.line(), error.column());
    match error.classify() {
        Category::Eof if error.column() == 0 && error.line() == 1 => "an empty file".to_owned(),
        Category::Eof => format!("JSON that ends too early, in {place}"),
        Category::Syntax | Category::Io => format!("text that is no JSON, in {place}"),
        Category::Data => {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or_default();
            // What is expected may be named as the program names it.
            let message = message.split(", expected struct ").next().unwrap_or_default();
            format!("JSON of another layout, in {place}: {message}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_of_json_name_no_types() {
        #[derive(Debug, serde::Deserialize)]
        struct Inner {
            _name: String,
        }
        for (text, problem) in [
            ("", "an empty file"),
            ("{\"_name\": \"x", "JSON that ends too early, in line 1, column 12"),
            ("\0\0", "text that is no JSON, in line 1, column 1"),
            ("3", "JSON of another layout, in line 1, column 1: invalid type: integer `3`"),
            ("{}", "JSON of another layout, in line 1, column 2: missing field `_name`"),
        ] {
            assert_eq!(json_problem(&serde_json::from_str::<Inner>(text).unwrap_err()), problem);
        }
    }
}
