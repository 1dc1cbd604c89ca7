//! The `brdfc` command.

fn main() -> std::process::ExitCode {
    brdfc::cli::main()
}
