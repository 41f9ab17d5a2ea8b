//! A peer's program: a process that stays alive, is asked for a run by a line, and answers each with a line of its own.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use anyhow::{Context, bail};

/// The process, which ends with this.
pub struct Worker {
    process: Child,
    questions: Option<ChildStdin>,
    answers: Receiver<String>,
    patience: Duration,
}

impl Worker {
    /// Starts it; an answer that takes longer than `patience_s` is given up.
    pub fn start(command: &mut Command, patience_s: f64) -> anyhow::Result<Self> {
        let name = command.get_program().to_string_lossy().into_owned();
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().context(name)?;
        let questions = process.stdin.take();
        let lines = BufReader::new(process.stdout.take().context("the peer has no output")?).lines();
        let (send, answers) = channel();
        std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| send.send(line)));
        Ok(Self { process, questions, answers, patience: Duration::from_secs_f64(patience_s) })
    }

    /// Asks for a run; the words of the answer. A line that begins with `error` is one.
    pub fn ask(&mut self, question: &str) -> anyhow::Result<Vec<String>> {
        writeln!(self.questions.as_mut().context("the peer has no input")?, "{question}")?;
        let answer = match self.answers.recv_timeout(self.patience) {
            Ok(answer) => answer,
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {
                bail!("no answer in {:.0} s", self.patience.as_secs_f64())
            }
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => bail!("the peer ended without an answer"),
        };
        if let Some(reason) = answer.strip_prefix("error") {
            bail!("{}", reason.trim());
        }
        Ok(answer.split_whitespace().map(str::to_owned).collect())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // It ends when nothing is left to be asked; one that is still at work is ended.
        drop(self.questions.take());
        if matches!(self.process.try_wait(), Ok(None)) {
            std::thread::sleep(Duration::from_millis(200));
            let _ = self.process.kill();
        }
        let _ = self.process.wait();
    }
}
