//! How far a render is: a bar on a terminal, a few plain lines elsewhere, nothing when asked for quiet.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Plain lines come at each of this many equal parts.
const LINES: u64 = 4;

/// Reports on standard error.
pub struct Progress {
    started: Instant,
    form: Form,
    /// Those that are done, and all.
    pictures: [u64; 2],
}

enum Form {
    Quiet,
    Lines { printed: u64 },
    Bar(ProgressBar),
}

impl Progress {
    /// For so many pictures of a like amount of work.
    pub fn new(quiet: bool, pictures: u64) -> Progress {
        let form = if quiet {
            Form::Quiet
        } else if std::io::stderr().is_terminal() {
            Form::Bar(bar())
        } else {
            Form::Lines { printed: 0 }
        };
        Progress {
            started: Instant::now(),
            form,
            pictures: [0, pictures],
        }
    }

    /// `done` of `total` parts of equal work of a picture.
    pub fn update(&mut self, done: u64, total: u64) {
        let [before, pictures] = self.pictures;
        let all = [before * total + done, pictures * total];
        let left = time_left(self.started.elapsed(), all[0], all[1]);
        match &mut self.form {
            Form::Quiet => {}
            Form::Bar(bar) => {
                bar.set_length(all[1]);
                let frame = match pictures {
                    1 => String::new(),
                    _ => format!("frame {} of {pictures}, ", before + 1),
                };
                let left = left.map_or_else(String::new, |t| format!("{} left", human(t)));
                bar.set_message(frame + &left);
                bar.set_position(all[0]);
            }
            // Each picture's last line is a summary; a sequence needs no other.
            Form::Lines { .. } if pictures > 1 => {}
            Form::Lines { printed } => {
                let part = done * LINES / total.max(1);
                if part > *printed && done < total {
                    *printed = part;
                    let left = left.map_or_else(String::new, |t| format!(", {} left", human(t)));
                    // Nobody reads it where it cannot be written.
                    let _ = writeln!(
                        std::io::stderr(),
                        "snell: {} % rendered{left}",
                        done * 100 / total
                    );
                }
            }
        }
    }

    /// Goes on to the next picture; takes the bar away, so that lines can be written.
    pub fn finish_picture(&mut self) {
        self.pictures[0] += 1;
        if let Form::Bar(old) = &mut self.form {
            old.finish_and_clear();
            *old = bar();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    bar.set_style(
        ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}")
            .expect("invariant: the template is well formed"),
    );
    bar
}

/// If the rest goes on as before; `None` before anything is done.
fn time_left(elapsed: Duration, done: u64, total: u64) -> Option<Duration> {
    (done > 0).then(|| elapsed.mul_f64(total.saturating_sub(done) as f64 / done as f64))
}

/// A duration to two digits or so: "0.42 s", "12.3 s", "4 min 05 s", "2 h 10 min".
pub fn human(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let whole = seconds.round() as u64;
    if seconds < 10.0 {
        format!("{seconds:.2} s")
    } else if seconds < 60.0 {
        format!("{seconds:.1} s")
    } else if whole < 3600 {
        format!("{} min {:02} s", whole / 60, whole % 60)
    } else {
        format!("{} h {:02} min", whole / 3600, whole / 60 % 60)
    }
}
