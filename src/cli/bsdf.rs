//! `snell bsdf`: JSON lines in, JSON lines out.

use crate::error::Error;
use crate::gpu::device::{DeviceError, open};
use crate::lab::query::{Kind, Query, Rejected, parse};
use crate::lab::{Answer, Lab};
use clap::{Args, ValueEnum};
use serde::Serialize;
use serde_json::Value;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// The schema that `--schema` prints.
pub const SCHEMA: &str = include_str!("../../schema/bsdf.schema.json");

/// What is read at a time; also bounds what waits for an answer.
const READ_BYTES: usize = 1 << 20;
/// A longer line is refused, and skipped without being kept.
const LINE_BYTES: u64 = 1 << 20;

/// Evaluate the reflection functions: JSON lines in, JSON lines out
///
/// One query a line, one answer a line, in order, each with the query's `id`. A query that makes no
/// sense is answered by {"id": ..., "error": "..."} and does not change the exit status. Directions
/// are in the local frame (the normal is +z) and point away from the surface; `f` excludes the
/// cosine; `pdf` is per solid angle, and 0 means "no sample".
#[derive(Args, Debug)]
pub struct BsdfArgs {
    /// What to evaluate; `mixed`: each query says it itself, by "kind"
    #[arg(required_unless_present = "schema")]
    kind: Option<KindArg>,
    /// Queries, one JSON object a line; `-` is standard input
    #[arg(default_value = "-")]
    input: PathBuf,
    /// Evaluate in float64 on the CPU
    #[arg(long, conflicts_with = "adapter")]
    cpu: bool,
    /// Take the first adapter whose name contains this
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
    /// Print the JSON schema of queries and answers
    #[arg(long)]
    schema: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindArg {
    Fresnel,
    Eval,
    Sample,
    Albedo,
    Mixed,
}

impl KindArg {
    fn kind(self) -> Option<Kind> {
        match self {
            Self::Fresnel => Some(Kind::Fresnel),
            Self::Eval => Some(Kind::Eval),
            Self::Sample => Some(Kind::Sample),
            Self::Albedo => Some(Kind::Albedo),
            Self::Mixed => None,
        }
    }
}

#[derive(Serialize)]
struct Answered {
    id: Value,
    #[serde(flatten)]
    answer: Answer,
}

#[derive(Serialize)]
struct Refused {
    id: Value,
    error: String,
}

/// Answers all queries of the input.
pub fn run(args: &BsdfArgs) -> Result<(), Error> {
    let Some(kind) = args.kind.filter(|_| !args.schema) else {
        return super::print(SCHEMA);
    };
    let mut output = io::stdout().lock();
    let read = |source| Error::Input {
        path: args.input.clone(),
        source,
    };
    let mut input = BufReader::with_capacity(READ_BYTES, open_input(&args.input).map_err(read)?);
    let lab = open_lab(args)?;
    let mut batch = Vec::new();
    let mut line = Vec::new();
    loop {
        let end = !read_line(&mut input, &mut line).map_err(read)?;
        if !end && !line.trim_ascii().is_empty() {
            batch.push(parse_line(&line, kind.kind()));
        }
        // What has been read is answered before waiting for more, so that a program may ask, wait
        // for the answer, and ask again.
        if end || !input.buffer().contains(&b'\n') {
            match answer(&lab, std::mem::take(&mut batch), &mut output)? {
                Written::All if end => return Ok(()),
                Written::All => {}
                Written::NobodyReads => return Ok(()),
            }
        }
    }
}

fn open_input(path: &Path) -> io::Result<Box<dyn Read>> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin().lock()));
    }
    Ok(Box::new(std::fs::File::open(path)?))
}

fn open_lab(args: &BsdfArgs) -> Result<Lab, Error> {
    if args.cpu {
        return Ok(Lab::cpu());
    }
    match open(args.adapter.as_deref()) {
        Ok(gpu) => Ok(Lab::gpu(gpu)?),
        Err(error @ DeviceError::NoAdapter) if args.adapter.is_none() => {
            eprintln!("snell: {error}; answering on the CPU");
            Ok(Lab::cpu())
        }
        Err(error) => Err(error.into()),
    }
}

/// Reads a line without its end into `line`, at most `LINE_BYTES` + 1 of it; false at the end of input.
fn read_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<bool> {
    line.clear();
    let count = input
        .by_ref()
        .take(LINE_BYTES + 1)
        .read_until(b'\n', line)?;
    if line.last() == Some(&b'\n') {
        line.pop();
    } else if count as u64 > LINE_BYTES {
        input.skip_until(b'\n')?;
    }
    Ok(count > 0)
}

type Parsed = Result<(Value, Query), (Value, String)>;

fn parse_line(line: &[u8], kind: Option<Kind>) -> Parsed {
    if line.len() as u64 > LINE_BYTES {
        return Err((
            Value::Null,
            "a line of more than 1 MiB is no query".to_owned(),
        ));
    }
    parse(line, kind).map_err(|Rejected { id, error }| (id, error.to_string()))
}

enum Written {
    All,
    NobodyReads,
}

fn answer(lab: &Lab, batch: Vec<Parsed>, output: &mut impl Write) -> Result<Written, Error> {
    let queries: Vec<Query> = batch
        .iter()
        .filter_map(|parsed| parsed.as_ref().ok())
        .map(|(_, query)| *query)
        .collect();
    let mut answers = lab.answer(&queries)?.into_iter();
    let mut lines = Vec::new();
    for parsed in batch {
        let written = match parsed {
            Ok((id, _)) => {
                let answer = answers.next().expect("one answer for each query");
                if answer.is_finite() {
                    serde_json::to_writer(&mut lines, &Answered { id, answer })
                } else {
                    let error = "the model gives no finite number here".to_owned();
                    serde_json::to_writer(&mut lines, &Refused { id, error })
                }
            }
            Err((id, error)) => serde_json::to_writer(&mut lines, &Refused { id, error }),
        };
        written.expect("writing to memory does not fail");
        lines.push(b'\n');
    }
    match output.write_all(&lines).and_then(|()| output.flush()) {
        // Who closes the pipe has seen enough: `snell bsdf ... | head` is no failure.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(Written::NobodyReads),
        result => result.map(|()| Written::All).map_err(Error::Stdout),
    }
}
