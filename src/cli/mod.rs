//! The command line: one module per subcommand, each with its arguments and a `run`.

pub mod bench;
pub mod bsdf;
pub mod doctor;
pub mod info;
mod intrinsics;
mod moment;
pub mod plot;
mod record;
pub mod render;
mod renderer;
mod sequence;
mod studio;
mod value;
mod view;

use std::io::{self, Write};

use clap::{ArgAction, Parser, Subcommand};

use crate::error::Error;

/// Renders glTF to physically based images, with no window and no display server.
#[derive(Debug, Parser)]
#[command(name = "snell", version, about, max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 2 wrong usage, 3 input invalid, \
    4 input needs an unsupported feature, 5 no adapter, 6 over a limit, 7 GPU failure, \
    8 output not written, 130 interrupted (nothing is written but a \
    sequence's finished frames).")]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// Say more on standard error; twice for still more. RUST_LOG overrides it.
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to pictures.
    Render(Box<render::RenderArgs>),
    /// List the adapters and say what is wrong, if anything.
    Doctor(doctor::DoctorArgs),
    /// Say what is in a glTF file, and what Snell does with each of its extensions.
    Info(info::InfoArgs),
    /// Measure how fast this machine renders, part by part.
    Bench(bench::BenchArgs),
    Bsdf(bsdf::BsdfArgs),
    Plot(plot::PlotArgs),
}

impl Cli {
    /// Does what was asked for.
    pub fn run(self) -> Result<(), Error> {
        match self.command {
            Command::Render(args) => render::run(&*args.sized()?),
            Command::Doctor(args) => doctor::run(&args),
            Command::Info(args) => info::run(&args),
            Command::Bench(args) => bench::run(&args),
            Command::Bsdf(args) => bsdf::run(&args),
            Command::Plot(args) => plot::run(&args),
        }
    }

    /// Messages go to standard error: warnings always, more by -v and RUST_LOG.
    pub fn start_log(&self) {
        let default = match self.verbose {
            0 => "snell=warn",
            1 => "snell=info,wgpu=warn",
            2 => "snell=debug,wgpu=info,naga=info",
            _ => "trace",
        };
        env_logger::Builder::from_env(env_logger::Env::default().default_filter_or(default)).init();
    }
}

/// Writes to standard output. That nobody reads on (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Error> {
    let mut stdout = io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(Error::Stdout),
    }
}

/// Says a line on standard error, where messages for people go; nobody reads it where it cannot be
/// written.
pub fn say(line: &str) {
    let _ = writeln!(io::stderr(), "snell: {line}");
}
