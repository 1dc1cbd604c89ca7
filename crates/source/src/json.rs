//! Errors of JSON files.

use serde_json::error::Category;

/// Describes why a file is not the expected JSON.
pub fn json_problem(error: &serde_json::Error) -> String {
    let place = format!("line {}, column {}", error.line(), error.column());
    match error.classify() {
        Category::Eof if error.column() == 0 && error.line() == 1 => "an empty file".to_owned(),
        Category::Eof => format!("truncated JSON, at {place}"),
        Category::Syntax | Category::Io => format!("text that is not JSON, at {place}"),
        Category::Data => {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or_default();
            // Types of the program would confuse users.
            let message = message.split(", expected struct ").next().unwrap_or_default();
            format!("JSON of another layout, at {place}: {message}")
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
            ("{\"_name\": \"x", "truncated JSON, at line 1, column 12"),
            ("\0\0", "text that is not JSON, at line 1, column 1"),
            ("3", "JSON of another layout, at line 1, column 1: invalid type: integer `3`"),
            ("{}", "JSON of another layout, at line 1, column 2: missing field `_name`"),
        ] {
            assert_eq!(json_problem(&serde_json::from_str::<Inner>(text).unwrap_err()), problem);
        }
    }
}
