//! The `brdfc` command.

fn main() {}
