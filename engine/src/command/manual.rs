//! What the command says about itself: completions for shells, manual pages, and which subcommand somebody may have meant.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use super::Out;
use super::args::Cli;
use super::failure::Failure;

/// Prints what makes a shell complete the command line.
pub(crate) fn completions(shell: Shell) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "mobula", &mut text);
    put(&text)
}

/// Prints the manual page of the command or of a subcommand.
pub(crate) fn page(subcommand: Option<&str>) -> Result<(), Failure> {
    let mut cli = Cli::command();
    cli.build();
    let command = match subcommand {
        None => cli,
        Some(name) => {
            let found = cli.find_subcommand(name).cloned();
            let unknown = || Failure::Usage(format!("there is no command {name:?}; there are {}", names().join(", ")));
            let found = found.ok_or_else(unknown)?;
            // As pages of manuals are called.
            found.display_name(format!("mobula-{name}"))
        }
    };
    let mut text = Vec::new();
    Man::new(command).render(&mut text)?;
    put(&text)
}

/// What to say to somebody who gave the name of a subcommand with a slip, which then looks like the first scene.
pub(crate) fn misspelt(scenes: &[PathBuf]) -> Option<String> {
    let word = scenes.first()?;
    let text = word.to_str()?;
    if word.exists() || text.contains(['.', '/', ':']) {
        return None;
    }
    // As clap itself suggests.
    let likeness = |name: &String| strsim::jaro(name, &text.to_lowercase());
    let best = names().into_iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
    (likeness(&best) > 0.7).then(|| format!("there is no command {text:?} and no such file; is it `mobula {best}`?"))
}

/// What to say where options of a subcommand stand before it.
pub(crate) fn misplaced(found: &ArgMatches) -> Option<Failure> {
    let name = found.subcommand_name()?;
    let given = |id: &&str| *id != "quiet" && found.value_source(id) == Some(ValueSource::CommandLine);
    found.ids().map(|id| id.as_str()).find(given)?;
    Some(Failure::Usage(format!(
        "only --quiet may stand before the command; the rest belongs behind it: mobula {name} ..."
    )))
}

fn names() -> Vec<String> {
    Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect()
}

fn put(text: &[u8]) -> Result<(), Failure> {
    let mut out = Out(io::stdout().lock());
    out.write_all(text)?;
    Ok(out.flush()?)
}
