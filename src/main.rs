//! The program: arguments, messages, the command, and what is said when it fails.

use std::process::ExitCode;

use clap::Parser;
use snell::cli::Cli;

fn main() -> ExitCode {
    let cli = Cli::parse();
    cli.start_log();
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("snell: error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}
