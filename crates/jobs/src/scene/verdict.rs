//! The verdict on a build: failures, missed limits and failed gates.

use super::error::JobError;
use super::run::{Made, Outcomes};
use super::scene_section::ENVIRONMENT;
use crate::encode::Message;
use crate::error::Error;
use brdfc_core::words::counted_of;

impl Outcomes {
    /// Returns true if a job failed, missed its limits or failed a gate. Cancelled jobs do not count.
    pub(super) fn any_failed(&self) -> bool {
        let of_material = |result: &Result<Made, JobError>| match result {
            Ok(made) => !made.passed(),
            Err(error) => !error.is_cancelled(),
        };
        let environment = self.environment.as_ref().and_then(|made| made.as_ref().err());
        self.materials.iter().any(|outcome| of_material(&outcome.result))
            || environment.is_some_and(|error| !error.is_cancelled())
    }

    /// Lists all failures, missed limits and failed gates, one line each, with the name of the material.
    pub fn problems(&self) -> Vec<Message> {
        let mut lines = Vec::new();
        for outcome in &self.materials {
            let of = |text: &Message| Message::from(format!("{}: ", outcome.name)).with_message(text);
            match &outcome.result {
                Ok(made) => {
                    lines.extend(made.missed().map(|missed| of(&missed.into())));
                    lines.extend(made.gates.iter().filter(|gate| !gate.passed).map(|gate| of(&gate.message())));
                }
                Err(error) if error.is_cancelled() => {}
                Err(error) => lines.push(of(&error.message())),
            }
        }
        if let Some(Err(error)) = &self.environment {
            lines.push(format!("{ENVIRONMENT}: {error}").into());
        }
        lines
    }

    /// Summarises the build.
    ///
    /// # Errors
    /// Returns an error if a job failed, missed its limits or failed a gate. The failure with the highest exit code
    /// decides the kind.
    pub fn verdict(self) -> Result<(), Error> {
        let count = self.materials.len();
        let missed = self.made().filter(|(_, made)| made.missed().next().is_some()).count();
        let failed_gates = self.made().filter(|(_, made)| made.gates.iter().any(|gate| !gate.passed)).count();
        let environment = self.environment.and_then(Result::err);
        let failures = self.materials.into_iter().filter_map(|o| o.result.err()).filter(|error| !error.is_cancelled());
        let mut failures: Vec<Error> = failures.map(Error::from).collect();
        let mut failed = Vec::new();
        if !failures.is_empty() {
            failed.push(format!("{} failed", counted_of(failures.len(), count, "material")));
        }
        for (number, one, more) in [
            (missed, "misses its limits", "miss their limits"),
            (failed_gates, "does not meet its requirements", "do not meet their requirements"),
        ] {
            if number > 0 {
                let what = if number == 1 { one } else { more };
                failed.push(format!("{} {what}", counted_of(number, count, "material")));
                failures.push(Error::check(""));
            }
        }
        if let Some(error) = environment {
            failed.push("the environment failed".to_owned());
            failures.push(error.into());
        }
        let Some(first) = failures.into_iter().max_by_key(Error::kind) else { return Ok(()) };
        let summary = failed.join(", ");
        Err(first.with_message(summary))
    }
}
