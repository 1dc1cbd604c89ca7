//! The verdict on a build: failures, missed limits and failed gates.

use super::error::JobError;
use super::run::Outcomes;
use super::scene_section::ENVIRONMENT;
use crate::encode::Message;
use crate::error::Error;
use crate::report::gate::GateResult;
use brdfc_core::words::counted_of;

/// Missed limits and gates of a material or another asset.
struct Checked<'a> {
    missed: Vec<String>,
    gates: &'a [GateResult],
}

impl Checked<'_> {
    fn passed(&self) -> bool {
        self.missed.is_empty() && self.gates.iter().all(|gate| gate.passed)
    }
}

impl Outcomes {
    /// The checks of each material and asset by name, or its error.
    fn checked(&self) -> Vec<(&str, Result<Checked<'_>, &JobError>)> {
        let materials = self.materials.iter().map(|outcome| {
            let checked = |made: &'_ super::run::Made| made.missed().collect::<Vec<String>>();
            let result = outcome.result.as_ref().map(|made| Checked { missed: checked(made), gates: &made.gates });
            (outcome.name.as_str(), result)
        });
        let assets = self.assets.iter().map(|outcome| {
            let result = outcome.result.as_ref();
            let checked =
                result.map(|made| Checked { missed: made.report.missed.iter().cloned().collect(), gates: &made.gates });
            (outcome.name.as_str(), checked)
        });
        materials.chain(assets).collect()
    }

    /// Returns true if a job failed, missed its limits or failed a gate. Cancelled jobs do not count.
    pub(super) fn any_failed(&self) -> bool {
        let failed = |result: &Result<Checked<'_>, &JobError>| match result {
            Ok(checked) => !checked.passed(),
            Err(error) => !error.is_cancelled(),
        };
        let environment = self.environment.as_ref().and_then(|made| made.as_ref().err());
        self.checked().iter().any(|(_, result)| failed(result))
            || environment.is_some_and(|error| !error.is_cancelled())
    }

    /// Lists all failures, missed limits and failed gates, one line each, with the name of the material or asset.
    pub fn problems(&self) -> Vec<Message> {
        let mut lines = Vec::new();
        for (name, result) in self.checked() {
            let of = |text: &Message| Message::from(format!("{name}: ")).with_message(text);
            match result {
                Ok(checked) => {
                    lines.extend(checked.missed.into_iter().map(|missed| of(&missed.into())));
                    lines.extend(checked.gates.iter().filter(|gate| !gate.passed).map(|gate| of(&gate.message())));
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
        let noun = if self.assets.is_empty() { "material" } else { "asset" };
        let checked = self.checked();
        let count = checked.len();
        let of = |is_one: &dyn Fn(&Checked<'_>) -> bool| {
            checked.iter().filter(|(_, result)| result.as_ref().is_ok_and(is_one)).count()
        };
        let missed = of(&|checked| !checked.missed.is_empty());
        let failed_gates = of(&|checked| checked.gates.iter().any(|gate| !gate.passed));
        let of_materials = self.materials.into_iter().filter_map(|outcome| outcome.result.err());
        let of_assets = self.assets.into_iter().filter_map(|outcome| outcome.result.err());
        let failures = of_materials.chain(of_assets).filter(|error| !error.is_cancelled());
        let mut failures: Vec<Error> = failures.map(Error::from).collect();
        let mut failed = Vec::new();
        if !failures.is_empty() {
            failed.push(format!("{} failed", counted_of(failures.len(), count, noun)));
        }
        for (number, one, more) in [
            (missed, "misses its limits", "miss their limits"),
            (failed_gates, "does not meet its requirements", "do not meet their requirements"),
        ] {
            if number > 0 {
                let what = if number == 1 { one } else { more };
                failed.push(format!("{} {what}", counted_of(number, count, noun)));
                failures.push(Error::check(""));
            }
        }
        if let Some(error) = self.environment.and_then(Result::err) {
            failed.push("the environment failed".to_owned());
            failures.push(error.into());
        }
        let Some(first) = failures.into_iter().max_by_key(Error::kind) else { return Ok(()) };
        let summary = failed.join(", ");
        Err(first.with_message(summary))
    }
}
