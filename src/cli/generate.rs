//! `brdfc generate`: shell completions and man pages, for packagers.

use super::Error;
use super::output::{make_folder, print, write_file};
use clap::{Args, ValueEnum};
use clap_complete::{Generator, Shell, generate};
use clap_mangen::Man;
use std::path::PathBuf;

/// Write shell completions or man pages into a folder, and print their paths.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc generate completions --out completions
  brdfc generate man --out man/man1")]
pub struct Arguments {
    /// Files to write.
    #[arg(value_enum)]
    what: Kind,
    /// Output folder, created if missing.
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Completions for bash, elvish, fish, PowerShell and zsh.
    Completions,
    /// A man page for the program, and one for each command.
    Man,
}

pub(super) fn run(arguments: &Arguments, command: clap::Command) -> Result<(), Error> {
    let files = match arguments.what {
        Kind::Completions => completions(command),
        Kind::Man => pages(command)?,
    };
    make_folder(&arguments.out)?;
    let mut paths = String::new();
    for (name, bytes) in files {
        let path = arguments.out.join(name);
        write_file(&path, &bytes)?;
        paths += &format!("{}\n", path.display());
    }
    print(&paths)
}

/// Generates a completion script for each shell.
fn completions(mut command: clap::Command) -> Vec<(String, Vec<u8>)> {
    let name = command.get_name().to_owned();
    let script = |shell: &Shell| {
        let mut bytes = Vec::new();
        generate(*shell, &mut command, &name, &mut bytes);
        (shell.file_name(&name), bytes)
    };
    Shell::value_variants().iter().map(script).collect()
}

/// Generates a man page for the program, and one for each command in its help.
fn pages(command: clap::Command) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let commands = command.get_subcommands().filter(|command| !command.is_hide_set());
    let page = |command: &clap::Command| {
        let page = Man::new(command.clone());
        let mut bytes = Vec::new();
        page.render(&mut bytes).map_err(|error| Error::internal(format!("man page: {error}")))?;
        Ok((page.get_filename(), typeset(&String::from_utf8_lossy(&bytes)).into_bytes()))
    };
    std::iter::once(&command).chain(commands).map(page).collect()
}

/// Adapts a page to all formatters: examples keep their lines, and characters outside ASCII become escapes.
fn typeset(page: &str) -> String {
    const EXTRA: &str = ".SH EXTRA\n";
    let page = match page.split_once(EXTRA) {
        Some((before, after)) => {
            let (extra, rest) = after.split_at(after.find("\n.SH ").map_or(after.len(), |end| end + 1));
            format!("{before}{EXTRA}.nf\n{extra}.fi\n{rest}")
        }
        None => page.to_owned(),
    };
    let escape = |c: char| if c.is_ascii() { c.to_string() } else { format!("\\[u{:04X}]", u32::from(c)) };
    page.chars().map(escape).collect()
}
