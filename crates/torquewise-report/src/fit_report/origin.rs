//! Title, list of logs and foot of a report.

use crate::{Heading, Item, Table};

/// Where a fit comes from, as its report names it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Origin<'a> {
    /// Logs the model was fitted on.
    pub logs: &'a [LogFile],
    /// Logs it was tested on; empty for none.
    pub tests: &'a [LogFile],
    /// The model file that was written.
    pub model: &'a str,
    /// The command line as it was given.
    pub command: &'a str,
    /// When the report was made.
    pub date: &'a str,
}

/// A log as its reader knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogFile {
    /// Its file name, without folders.
    pub name: String,
    /// When it was last written; may be empty.
    pub date: String,
}

const MOST_LETTERS: usize = 32;

impl Origin<'_> {
    /// A title of one line, whatever the number of logs and the length of their names.
    pub(crate) fn title(&self) -> String {
        let logs = short(self.logs);
        if self.tests.is_empty() {
            return format!("Torque model from {logs}");
        }
        format!("Torque model from {logs}, tested on {}", short(self.tests))
    }

    pub(crate) fn files(&self) -> Option<Item> {
        let row = |(log, of): (&LogFile, &str)| {
            [log.name.as_str(), of, log.date.as_str()].map(Into::into).to_vec()
        };
        let fitted = self.logs.iter().map(|log| (log, "fitted"));
        let rows: Vec<_> =
            fitted.chain(self.tests.iter().map(|log| (log, "tested"))).map(row).collect();
        let summary = format!("Logs: {} fitted, {} tested", self.logs.len(), self.tests.len());
        let table = Table {
            columns: ["log", "use", "last written"].map(Heading::words).into(),
            rows,
            ..Table::default()
        };
        (!table.rows.is_empty()).then(|| Item::Details { summary, items: vec![Item::Table(table)] })
    }

    pub(crate) fn foot(&self) -> Vec<String> {
        let dates = self.logs.iter().chain(self.tests).map(|log| log.date.as_str());
        let newest = dates.max().filter(|date| !date.is_empty());
        let logs = newest.map_or_else(String::new, |date| format!(" Newest log: {date}."));
        let version = env!("CARGO_PKG_VERSION");
        let made = format!("torquewise {version}. Report: {}.{logs}", self.date);
        let lines = [(self.date, made), (self.command, self.command.to_owned())];
        lines.into_iter().filter(|(told, _)| !told.is_empty()).map(|(_, line)| line).collect()
    }
}

/// The first name, shortened in its middle, and how many more there are.
fn short(logs: &[LogFile]) -> String {
    let Some(first) = logs.first() else { return "a log".into() };
    let letters: Vec<char> = first.name.chars().collect();
    let half = MOST_LETTERS / 2;
    let name = if letters.len() > MOST_LETTERS {
        let ends = [&letters[..half], &letters[letters.len() - half + 1..]];
        ends.map(|end| end.iter().collect::<String>()).join("…")
    } else {
        first.name.clone()
    };
    if logs.len() > 1 { format!("{name} and {} more", logs.len() - 1) } else { name }
}

#[cfg(test)]
mod tests {
    use super::{LogFile, Origin};

    #[test]
    fn a_title_is_short_whatever_the_logs_are_called() {
        let log = |name: &str| LogFile { name: name.into(), date: String::new() };
        let (long, plain) = ([log(&"é".repeat(500)), log("b")], [log("test.csv")]);

        let title = |tests| Origin { logs: &long, tests, ..Origin::default() }.title();

        assert!(title(&[]).ends_with("…ééééééééééééééé and 1 more"), "{}", title(&[]));
        assert!(title(&plain).ends_with(" and 1 more, tested on test.csv"));
        assert!(title(&plain).chars().count() < 100);
    }
}
