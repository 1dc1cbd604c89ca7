//! Checks that apply to all inputs.

use super::Error;
use brdfc_source::Input;

/// Rejects a second use of standard input. `inputs` are the names of arguments with their values.
pub fn refuse_stdin_twice(inputs: &[(&str, Option<&Input>)]) -> Result<(), Error> {
    let names: Vec<&str> =
        inputs.iter().filter(|(_, input)| input.is_some_and(Input::is_stdin)).map(|(name, _)| *name).collect();
    match names[..] {
        [first, second, ..] => Err(Error::usage(format!("{first} and {second}: both are -; only one can be stdin"))),
        _ => Ok(()),
    }
}
